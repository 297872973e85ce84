"""Bounded search for runs of which a formula of LTL is true: lassos, and finite runs that show it already.

The loop of a lasso may begin at each of its moments; each beginning is a query of its own.
"""

from collections.abc import Iterable, Sequence
from typing import Any

from exover.dataclass import dataclass
from exover.engines.smt.bounded_semantics import BoundedSemantics
from exover.engines.smt.unrolling import Taken, Unrolled
from exover.model.property import Formula
from exover.model.state import SlotId

LASSOS = range(1, 15)
"""The lengths of the lassos that are searched."""


@dataclass(frozen=True, slots=True)
class FoundRun:
    """A run; with `loop_start` it repeats its steps from there on for ever."""

    steps: list[Taken]
    loop_start: int | None = None


class TermSemantics(BoundedSemantics[Any]):
    """What is true of unrolled runs, as terms of Z3."""

    def __init__(self, unrolled: Unrolled, depth: int, back: int | None) -> None:
        super().__init__(depth, back)
        self.unrolled = unrolled

    def truth(self, value: bool) -> Any:
        """Return `true` or `false`."""
        import z3

        return z3.BoolVal(value)

    def both(self, parts: Sequence[Any]) -> Any:
        """Return the conjunction."""
        import z3

        return z3.And(list(parts))

    def either(self, parts: Sequence[Any]) -> Any:
        """Return the disjunction."""
        import z3

        return z3.Or(list(parts))

    def at(self, moment: int, formula: Formula, positive: bool) -> Any:
        """Return where a formula without temporal operators, or its negation, is true of a moment."""
        import z3

        found = self.unrolled.at(moment, self.unrolled.system.truth(formula))
        return found if positive else z3.Not(found)


@dataclass
class Lassos:
    """Looks for runs; `fair`: those alone on which every slot is, again and again, idle or being reported."""

    unrolled: Unrolled
    fair: bool
    endless: bool
    """Whether a finite run that shows the formula is not enough: its infinite continuation must be shown as well."""

    def find(self, formula: Formula, depths: Iterable[int]) -> FoundRun | None:
        """Return a run of one of these lengths of which the formula is true; raises `Inconclusive`."""
        for depth in depths:
            self.unrolled.grow_to(depth)
            if not self.endless:
                model = self.unrolled.check([TermSemantics(self.unrolled, depth, None).true(0, formula)])
                if model is not None:
                    return FoundRun(self.unrolled.taken(model, depth))
            for back in reversed(range(depth)):
                conditions = [
                    self.unrolled.same(back, depth),
                    TermSemantics(self.unrolled, depth, back).true(0, formula),
                ]
                model = self.unrolled.check([*conditions, *self._fairness(back, depth)])
                if model is not None:
                    return FoundRun(self.unrolled.taken(model, depth), back)
        return None

    def _fairness(self, back: int, depth: int) -> list[Any]:
        """Return the conditions that between the two moments every slot is idle or reported at least once."""
        import z3

        if not self.fair:
            return []
        found, system = [], self.unrolled.system
        for slot, names in system.layout.slots.items():
            if names.active in system.vars:
                active = system.vars[names.active]
                idle = [z3.Not(self.unrolled.at(moment, active)) for moment in range(back, depth)]
                found.append(z3.Or(idle + [self._reported(moment, slot) for moment in range(back, depth)]))
        return found

    def _reported(self, moment: int, slot: SlotId) -> Any:
        moves, relation = self.unrolled.system.moves, self.unrolled.relation
        chosen = [relation.chosen(k) for k, move in enumerate(moves) if move.kind.reported == slot]
        return self.unrolled.at(moment, self.unrolled.system.terms.either(chosen))
