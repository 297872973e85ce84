"""Proofs by one run: it shows that some run does from a moment on what a formula says (docs/certificates.md)."""

from collections.abc import Sequence
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.bdd.manager import Set
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
    """Proves formulas of the moments of a run; `held`: for each moment, the start first, a set that it is in."""

    operators: Operators
    trace: Trace
    held: Sequence[Set]

    @cached_property
    def moments(self) -> list[Moment]:
        """The steps of the run, and those of its loop once more."""
        repeated = () if self.trace.loop_start is None else self.trace.moments[self.trace.loop_start :]
        return [*self.trace.moments, *repeated]

    def _at(self, number: int) -> Set:
        """Return the set that is known of the moment after `number` steps."""
        last = len(self.trace.moments)
        return self.held[number if number <= last else number - last + (self.trace.loop_start or 0)]

    def prove(self, formula: Formula, positive: bool = True, number: int = 0) -> list[OperatorProof]:
        """Return proofs that a formula is true, or if not `positive` false, after `number` steps of the run.

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
        """Return proofs of all parts; those of one moment are tried first."""
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
        """Return proofs by sets of states, for a formula that this run cannot show."""
        there, true = self._at(number), self.operators.true(formula)
        if there & (~true if positive else true) != self.operators.fixpoints.none:
            raise Unsaid(SHOWS_NOT)
        return self.operators.prove(formula, positive, there)

    # ---- what a run shows ----

    def _run(self, start: int, end: int, loop: int | None = None) -> OperatorProof:
        """Return the proof by the run from after `start` steps to after `end`; from `loop` on it repeats for ever."""
        if end > len(self.moments):
            raise Unsaid(SHOWS_NOT)
        steps = self.operators.runs.steps(Trace(tuple(self.moments[:end])))
        return {"kind": "run", "steps": steps, "from": start, "loop": loop}

    def _shown(self, formula: SomeNext | SomeUntil, number: int) -> list[OperatorProof]:
        """Return proofs of an operator that says what some run does, by the steps of this run that follow."""
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
        """Return proofs that the run from `start` has `right` after `number` steps or more, and `left` until then."""
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
