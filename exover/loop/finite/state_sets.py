"""The Boolean algebra in which conditions on the finite loop are read: BDDs, or expressions of a text."""

from collections.abc import Iterable
from typing import Protocol, TypeVar

from exover.loop.finite.builder import ClosedLoop
from exover.loop.finite.variables import GuardedValue

S = TypeVar("S")
"""A set of states, or an expression that is true of them."""


class StateSets(Protocol[S]):
    """Sets of states of one loop; equal sets are equal values."""

    loop: ClosedLoop

    @property
    def none(self) -> S:
        """No state."""

    @property
    def all(self) -> S:
        """All states."""

    def complement(self, states: S) -> S:
        """Return the states that are not among these."""

    def conjunction(self, parts: Iterable[S]) -> S:
        """Return the states that are in all parts."""

    def disjunction(self, parts: Iterable[S]) -> S:
        """Return the states that are in some part."""

    def is_value(self, var: int, value: int) -> S:
        """Return the states in which a variable has this value."""

    def among(self, var: int, values: Iterable[int]) -> S:
        """Return the states in which a variable has one of these values."""

    def sum_of(self, terms: list[tuple[int, GuardedValue]]) -> dict[int, S]:
        """Return for each value of `sum(factor * term)` the states in which it has it."""
