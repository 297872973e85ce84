"""Conditions on the state after a look at the latches of NEW, as conditions on the state before it."""

from functools import cached_property

from exover.dataclass import dataclass
from exover.model.expression import And, AtomicCond, Compare, Cond, Const, ModelTerm, Not, Or, Reading, with_atoms
from exover.model.model import Latch, Model


@dataclass(frozen=True)
class Latching:
    """What a look at the latches of a model does: each is set if its condition holds, and stays what it is if not."""

    model: Model

    @cached_property
    def _latches(self) -> dict[str, Latch]:
        return {latch.name: latch for latch in self.model.latches}

    def latched(self, cond: Cond) -> Cond:
        """Return the condition that holds before the look iff this one holds after it; itself if it reads no latch."""
        return with_atoms(cond, self._latched)

    def _latched(self, atom: AtomicCond) -> Cond:
        match atom:
            case Compare(operator, left, right) if self._is_latch(left) or self._is_latch(right):
                mine, other = self._true(left), self._true(right)
                same = Or((And((mine, other)), And((Not(mine), Not(other)))))
                return same if operator == "==" else Not(same)
            case _:
                return atom

    def _is_latch(self, term: ModelTerm) -> bool:
        return isinstance(term, Reading) and term.name in self._latches

    def _true(self, term: ModelTerm) -> Cond:
        """Return the condition that a bool is true after the look."""
        known = Compare("==", term, Const(True))
        if isinstance(term, Reading) and term.name in self._latches:
            return Or((known, self.latched(self._latches[term.name].condition)))
        return known
