"""Operations on few bits of small sets, at a cost that does not depend on the number of declared bits.

CUDD fills an array of all bits for each substitution of several bits, each quantifier and each cube, which is most of
the work in a loop of a thousand requests. It substitutes a single bit without that; the other operations are reduced to
it by expansion (Shannon 1938).
"""

from collections.abc import Iterable, Mapping, Sequence

from exover.dataclass import dataclass
from exover.engines.bdd.effort import Meter
from exover.engines.bdd.manager import BddManager, Set

FEW, SMALL = 5, 100
"""The bits, and the nodes of a set, up to which bits are taken one by one."""


@dataclass(frozen=True)
class FewBits:
    """A manager of BDDs with its own operations on few bits; everything else is delegated to `manager`.

    `meter` is told of the operations.
    """

    manager: BddManager
    true: Set
    false: Set
    meter: Meter

    def declare(self, *names: str) -> None:
        """Add bits, below those that there are."""
        self.manager.declare(*names)

    def var(self, name: str) -> Set:
        """Return the states in which a bit is 1."""
        return self.manager.var(name)

    def cube(self, literals: Mapping[str, bool]) -> Set:
        """Return the states in which bits have these values."""
        if len(literals) > FEW:
            return self.manager.cube(literals)
        found = self.true
        for name, positive in literals.items():
            found &= self.manager.var(name) if positive else ~self.manager.var(name)
        return found

    def exist(self, names: Iterable[str], states: Set) -> Set:
        """Return the states with these bits existentially quantified."""
        chosen, size = tuple(names), len(states)
        self.meter.work(size)
        if len(chosen) > FEW or size > SMALL:
            return self.manager.exist(chosen, states)
        for name in chosen:
            states = self._where(name, self.true, states) | self._where(name, self.false, states)
        return states

    def let(self, values: Mapping[str, bool] | Mapping[str, str] | Mapping[str, Set], states: Set) -> Set:
        """Return the states with bits replaced, simultaneously."""
        size = len(states)
        self.meter.work(size)
        if len(values) > FEW:
            values = {name: values[name] for name in self.manager.support(states) & values.keys()}  # type: ignore[assignment]
        if size > SMALL:
            return self.manager.let(values, states) if values else states
        functions = []
        for name, value in ((name, self._set(value)) for name, value in values.items()):
            if value in (self.true, self.false):
                states = self._where(name, value, states)
            else:
                functions.append((name, value))
        return self._composed(functions, states) if len(functions) <= FEW else self.manager.let(dict(functions), states)

    def _set(self, value: bool | str | Set) -> Set:
        match value:
            case bool():
                return self.true if value else self.false
            case str():
                return self.manager.var(value)
            case _:
                return value

    def _where(self, name: str, value: Set, states: Set) -> Set:
        """Return the states with one bit replaced."""
        return self.manager.let({name: value}, states)

    def _composed(self, values: Sequence[tuple[str, Set]], states: Set) -> Set:
        """Return the states with bits replaced simultaneously by functions."""
        if not values or states in (self.true, self.false):
            return states
        (name, value), *rest = values
        if not rest:
            return self._where(name, value, states)
        high, low = self._where(name, self.true, states), self._where(name, self.false, states)
        if high == low:
            return self._composed(rest, high)
        return self.manager.ite(value, self._composed(rest, high), self._composed(rest, low))

    def apply(self, operator: str, one: Set, other: Set) -> Set:
        """Return the result of a Boolean operator on two sets."""
        self.meter.work(len(one))
        return self.manager.apply(operator, one, other)

    def ite(self, condition: Set, one: Set, other: Set) -> Set:
        """Return `one` where the condition holds, else `other`."""
        self.meter.work(len(condition))
        return self.manager.ite(condition, one, other)

    def support(self, states: Set) -> set[str]:
        """Return the bits on which a set depends."""
        return self.manager.support(states)

    def level_of_var(self, name: str) -> int:
        """Return the level of a bit in the order."""
        return self.manager.level_of_var(name)

    def var_at_level(self, level: int) -> str:
        """Return the bit at a level of the order."""
        return self.manager.var_at_level(level)

    def reorder(self) -> None:
        """Sift the order."""
        self.manager.reorder()

    def __len__(self) -> int:
        """Return the number of nodes."""
        return len(self.manager)

    def configure(self, *, reordering: bool) -> object:
        """Switch dynamic reordering by the manager on or off."""
        return self.manager.configure(reordering=reordering)
