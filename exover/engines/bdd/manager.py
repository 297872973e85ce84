"""What is used of a manager of BDDs, and of the sets that it makes: the part of dd's interface that is typed here."""

from collections.abc import Iterable, Mapping
from typing import Protocol


class Set(Protocol):
    """A BDD of the manager at hand; `len` is its number of nodes."""

    @property
    def var(self) -> str:
        """The topmost bit that it depends on; undefined for the empty set and for all states."""

    @property
    def level(self) -> int:
        """The level of that bit in the order."""

    def __and__(self, other: "Set", /) -> "Set":
        """Return the intersection."""

    def __or__(self, other: "Set", /) -> "Set":
        """Return the union."""

    def __invert__(self) -> "Set":
        """Return the complement."""

    def __len__(self) -> int:
        """Return the number of nodes."""

    def __hash__(self) -> int:
        """Return a hash."""


class BddManager(Protocol):
    """The operations of dd's BDD managers that are used here; bits are named."""

    @property
    def true(self) -> Set:
        """All states."""

    @property
    def false(self) -> Set:
        """No state."""

    def declare(self, *names: str) -> None:
        """Add bits, below those that there are."""

    def var(self, name: str) -> Set:
        """Return the states in which a bit is 1."""

    def cube(self, literals: Mapping[str, bool]) -> Set:
        """Return the states in which bits have these values."""

    def exist(self, names: Iterable[str], states: Set) -> Set:
        """Return the states with these bits existentially quantified."""

    def let(self, values: Mapping[str, bool] | Mapping[str, str] | Mapping[str, Set], states: Set) -> Set:
        """Return the states with bits replaced, simultaneously."""

    def apply(self, operator: str, one: Set, other: Set) -> Set:
        """Return the result of a Boolean operator on two sets."""

    def ite(self, condition: Set, one: Set, other: Set) -> Set:
        """Return `one` where the condition holds, else `other`."""

    def support(self, states: Set) -> set[str]:
        """Return the bits on which a set depends."""

    def level_of_var(self, name: str) -> int:
        """Return the level of a bit in the order."""

    def var_at_level(self, level: int) -> str:
        """Return the bit at a level of the order."""

    def reorder(self) -> None:
        """Sift the order."""

    def __len__(self) -> int:
        """Return the number of nodes."""

    def configure(self, *, reordering: bool) -> object:
        """Switch dynamic reordering by the manager on or off."""
