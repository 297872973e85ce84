"""Runs of which a formula of LTL is true: those that repeat a part of themselves, and those that show it before.

The bounded semantics of Biere, Cimatti, Clarke and Zhu (1999), for each place where the repeated part may begin.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from exover.engines.smt.unrolling import Taken, Unrolled
from exover.loop.exact.events import Kind
from exover.model.property import Conjunction, Disjunction, Formula, Negation, Next, Until, momentary


@dataclass(frozen=True, slots=True)
class FoundRun:
    """A run; with `loop_start` it repeats its steps from there on for ever."""

    steps: list[Taken]
    loop_start: int | None = None


@dataclass
class BoundedSemantics:
    """What is true of runs of `depth` steps; with `back`, after the last moment come those after moment `back`."""

    unrolled: Unrolled
    depth: int
    back: int | None
    _known: dict[tuple[int, Formula, bool], Any] = field(default_factory=dict)

    def true(self, moment: int, formula: Formula, positive: bool = True) -> Any:
        """Return where the formula, or its negation, is true of the run from a moment on."""
        key = (moment, formula, positive)
        if key not in self._known:
            self._known[key] = self._true(moment, formula, positive)
        return self._known[key]

    def _true(self, moment: int, formula: Formula, positive: bool) -> Any:
        import z3

        if momentary(formula):
            term = self.unrolled.system.truth(formula)
            found = self.unrolled.at(moment, term)
            return found if positive else z3.Not(found)
        match formula:
            case Negation(part):
                return self.true(moment, part, not positive)
            case Conjunction(parts) | Disjunction(parts):
                truths = [self.true(moment, part, positive) for part in parts]
                return z3.And(truths) if isinstance(formula, Conjunction) == positive else z3.Or(truths)
            case Next(part):
                following = self._following(moment)
                return z3.BoolVal(False) if following is None else self.true(following, part, positive)
            case Until(left, right):
                return self._until(moment, left, right, positive)
            case _:
                raise TypeError("a path formula is of LTL")

    def _following(self, moment: int) -> int | None:
        if moment < self.depth:
            return moment + 1
        return None if self.back is None else self.back + 1

    def _until(self, moment: int, left: Formula, right: Formula, positive: bool) -> Any:
        """Return where the until is true, or false: at the end of the moments neither is shown, but by repetition."""
        import z3

        later = list(range(moment, self.depth + 1))
        if self.back is not None:
            later += range(self.back + 1, min(moment, self.depth + 1))
        found = z3.BoolVal(not positive and self.back is not None)
        for each in reversed(later):
            first, last = self.true(each, left, positive), self.true(each, right, positive)
            found = z3.Or(last, z3.And(first, found)) if positive else z3.And(last, z3.Or(first, found))
        return found


@dataclass
class Lassos:
    """Looks for runs; `fair`: those alone on which every slot is, again and again, idle or being reported."""

    unrolled: Unrolled
    fair: bool
    endless: bool
    """A run that ends where the formula is shown does not do: what comes after must be shown as well."""

    def find(self, formula: Formula, depths: Iterable[int]) -> FoundRun | None:
        """Return a run of one of these lengths of which the formula is true; raises `Inconclusive`."""
        for depth in depths:
            self.unrolled.grow_to(depth)
            if not self.endless:
                model = self.unrolled.check([BoundedSemantics(self.unrolled, depth, None).true(0, formula)])
                if model is not None:
                    return FoundRun(self.unrolled.taken(model, depth))
            for back in reversed(range(depth)):
                conditions = [
                    self.unrolled.same(back, depth),
                    BoundedSemantics(self.unrolled, depth, back).true(0, formula),
                ]
                model = self.unrolled.check([*conditions, *self._fairness(back, depth)])
                if model is not None:
                    return FoundRun(self.unrolled.taken(model, depth), back)
        return None

    def _fairness(self, back: int, depth: int) -> list[Any]:
        """Return that between the two moments every slot is idle somewhere, or reported."""
        import z3

        if not self.fair:
            return []
        found, system = [], self.unrolled.system
        for (name, number), slot in system.layout.slots.items():
            if slot.active in system.vars:
                active = system.vars[slot.active]
                idle = [z3.Not(self.unrolled.at(moment, active)) for moment in range(back, depth)]
                found.append(z3.Or(idle + [self._reported(moment, name, number) for moment in range(back, depth)]))
        return found

    def _reported(self, moment: int, name: str, number: int) -> Any:
        def reports(kind: Kind) -> bool:
            return kind.verb == "report" and (kind.name, kind.slot) == (name, number)

        moves, relation = self.unrolled.system.moves, self.unrolled.relation
        chosen = [relation.chosen(k) for k, move in enumerate(moves) if reports(move.kind)]
        return self.unrolled.at(moment, self.unrolled.system.terms.either(chosen))
