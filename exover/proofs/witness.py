"""Proofs that one run gives: what some run does from a moment on, it shows (docs/certificates.md)."""

from collections.abc import Sequence
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.bdd.space import Set
from exover.model.property import (
    Conjunction,
    Disjunction,
    Formula,
    Negation,
    SomeAlways,
    SomeNext,
    SomeUntil,
    momentary,
)
from exover.model.trace import Moment, Trace
from exover.proofs.operators import OperatorProof, Operators, trivial
from exover.proofs.statement import Unsaid

SHOWS_NOT = "no run is known that shows it"


@dataclass
class WitnessProof:
    """Proves formulas of the moments of a run; `held`: what is known of each moment, the first one included."""

    operators: Operators
    trace: Trace
    held: Sequence[Set]

    @cached_property
    def moments(self) -> list[Moment]:
        """The steps, those that are repeated for ever twice."""
        repeated = () if self.trace.loop_start is None else self.trace.moments[self.trace.loop_start :]
        return [*self.trace.moments, *repeated]

    def _at(self, number: int) -> Set:
        """Return what is known of the moment after so many steps."""
        last = len(self.trace.moments)
        return self.held[number if number <= last else number - last + (self.trace.loop_start or 0)]

    def prove(self, formula: Formula, positive: bool = True, number: int = 0) -> list[OperatorProof]:
        """Return proofs that a formula is true, or if not `positive` false, after so many steps.

        Raises `Unsaid` if there are none, `TooWide` if they need too large sets.
        """
        match formula:
            case Negation(part):
                return self.prove(part, not positive, number)
            case Conjunction(parts) if positive:
                return self._all(parts, True, number)
            case Disjunction(parts) if not positive:
                return self._all(parts, False, number)
            case Conjunction(parts) | Disjunction(parts) if not momentary(formula):
                return self._one_of(parts, positive, number)
            case SomeNext() | SomeUntil() if positive:
                try:
                    return self._shown(formula, number)
                except Unsaid:
                    return self._of_all_runs(formula, True, number)
            case SomeAlways(part) if positive:
                return self._stays(part, number)
            case _:
                return self._of_all_runs(formula, positive, number)

    def _all(self, parts: Sequence[Formula], positive: bool, number: int) -> list[OperatorProof]:
        """Return proofs of all parts; those of one moment are looked at first."""
        for part in parts:
            if momentary(part):
                self._of_all_runs(part, positive, number)
        return [each for part in parts for each in self.prove(part, positive, number)]

    def _one_of(self, parts: Sequence[Formula], positive: bool, number: int) -> list[OperatorProof]:
        """Return proofs of the first part that has one; a part of one moment needs none."""
        for chosen in sorted(parts, key=momentary, reverse=True):
            try:
                shown = self.prove(chosen, positive, number)
            except Unsaid:
                continue
            return [each for part in parts for each in (shown if part is chosen else trivial(part, positive))]
        raise Unsaid(SHOWS_NOT)

    def _of_all_runs(self, formula: Formula, positive: bool, number: int) -> list[OperatorProof]:
        """Return proofs of what is not about some run, and so not shown by one."""
        there, true = self._at(number), self.operators.true(formula)
        if there & (~true if positive else true) != self.operators.fixpoints.none:
            raise Unsaid(SHOWS_NOT)
        return self.operators.prove(formula, positive, there)

    # ---- what a run shows ----

    def _run(self, start: int, end: int, loop: int | None = None) -> OperatorProof:
        """Return the proof that the run is from after `start` steps on, to after `end`, and on from `loop` for ever."""
        if end > len(self.moments):
            raise Unsaid(SHOWS_NOT)
        steps = self.operators.runs.steps(Trace(tuple(self.moments[:end])))
        return {"kind": "run", "steps": steps, "from": start, "loop": loop}

    def _shown(self, formula: SomeNext | SomeUntil, number: int) -> list[OperatorProof]:
        """Return proofs, by what comes later on this run, that some run goes on so."""
        match formula:
            case SomeNext(SomeUntil(left, right)):
                return [None, *self._comes_to(left, right, number, number + 1)]
            case SomeNext(part):
                return [self._run(number, number + 1), *self.prove(part, True, number + 1)]
            case SomeUntil(left, right):
                try:
                    return [{"kind": "layers", "layers": []}, *trivial(left, True), *self.prove(right, True, number)]
                except Unsaid:
                    self._of_all_runs(left, True, number)
                    return self._comes_to(left, right, number, number + 1)

    def _comes_to(self, left: Formula, right: Formula, start: int, number: int) -> list[OperatorProof]:
        """Return proofs of an `until` after `number` steps or later, by the run from `start` on."""
        between = self.operators.fixpoints.none
        for end in range(number, len(self.moments) + 1):
            try:
                shown = self.prove(right, True, end)
            except Unsaid:
                self._of_all_runs(left, True, end)
                between |= self._at(end)
                continue
            return [self._run(start, end), *self.operators.prove(left, True, between), *shown]
        raise Unsaid(SHOWS_NOT)

    def _stays(self, part: Formula, number: int) -> list[OperatorProof]:
        """Return proofs that the run stays for ever where a formula is true, from after `number` steps on."""
        first, last = self.trace.loop_start, len(self.trace.moments)
        if first is None or number > last:
            raise Unsaid(SHOWS_NOT)
        loop = max(first, number)
        end = last + loop - first
        moments = self.operators.fixpoints.none
        for each in range(number, end + 1):
            moments |= self._at(each)
        if moments & ~self.operators.true(part) != self.operators.fixpoints.none:
            raise Unsaid(SHOWS_NOT)
        return [self._run(number, end, loop), *self.operators.prove(part, True, moments)]
