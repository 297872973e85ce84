"""The search for proofs of claims: by the invariant, by the run of a finding or another one, by sets of states."""

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from typing import Any

from exover.certificate.check import State
from exover.checks.finding import Finding
from exover.checks.questions.property import is_contradiction
from exover.dataclass import dataclass
from exover.engines.bdd.analysis import Analysis
from exover.engines.bdd.concretize import SpuriousRun
from exover.engines.bdd.manager import Set
from exover.loop.claim import Claim, Progress
from exover.loop.finite.abstraction import abstract
from exover.loop.finite.step_predicates import moments
from exover.model.model import NOWHERE
from exover.model.property import (
    TRUE,
    Conjunction,
    Disjunction,
    Formula,
    Happened,
    Negation,
    Passed,
    Properties,
    Property,
    SomeAlways,
    SomeNext,
    SomeUntil,
    atoms,
    momentary,
)
from exover.model.semantics import Reference
from exover.model.trace import Trace
from exover.ocrd.compile import Compiled
from exover.proofs.alarm import Late, bounded
from exover.proofs.invariants import Hurried, never
from exover.proofs.operators import INVARIANT, LATE, OperatorProof, Operators, trivial
from exover.proofs.runs import RunWriter
from exover.proofs.sets import Sets
from exover.proofs.statement import Statement, Unsaid
from exover.proofs.witness import SHOWS_NOT, WitnessProof

GRACE = 5.0
"""The seconds after the deadline in which a search that reads the clock may end by itself."""


def denied(formula: Formula, positive: bool) -> Iterator[Formula]:
    """Yield formulas of one moment that are false after every step if `formula` is true, or if not `positive` false."""
    match formula:
        case Negation(part):
            yield from denied(part, not positive)
        case Conjunction(parts) | Disjunction(parts):
            for part in parts:
                yield from denied(part, positive)
        case SomeNext(SomeUntil(_, goal)) | SomeUntil(_, goal) | SomeNext(goal) if not positive and momentary(goal):
            yield goal
        case _:
            pass


@dataclass
class ProofSearch:
    """Searches for proofs of claims about one table; `checker`: its checker, which has the invariant."""

    compiled: Compiled
    properties: Properties
    claims: dict[tuple[str, str], Claim]
    progress: Progress
    statement: Statement
    checker: Hurried

    @cached_property
    def _runs(self) -> RunWriter:
        return RunWriter(self.statement)

    @cached_property
    def _analysis(self) -> Analysis:
        """The analysis of the closed loop, in which the facts about steps that claims read are observed."""
        asked = (atom for claim in self.claims.values() if claim.formula is not None for atom in atoms(claim.formula))
        steps = dict.fromkeys(each for each in asked if isinstance(each, Happened | Passed) and self._is_said(each))
        extra = tuple(Property("", None, "ctl", fact, None, NOWHERE) for fact in steps)
        properties = replace(self.properties, properties=(*self.properties.properties, *extra))
        return Analysis(self.compiled, Reference(self.compiled.model), self.progress, properties)

    @cached_property
    def _sets(self) -> Sets:
        return Sets(self._analysis.space, self.statement)

    def parts(self, claim: Claim, finding: Finding, deadline: float) -> list[OperatorProof]:
        """Return a proof, not checked yet, that the verdict on a claim is right: a part for each temporal operator.

        Raises `Unsaid`, `TooWide`, `TooLarge` or `SpuriousRun` if none is found by `deadline`.
        """
        if finding.verdict == "unknown" or claim.formula is None:
            raise Unsaid("the question has no answer")
        if is_contradiction(finding.message):
            raise Unsaid("that the assumptions contradict each other is no part of the claim")
        holds = finding.verdict == "holds"
        if claim.linear and not holds:
            return [self._lasso(finding.trace)]
        plain = None if claim.linear else self._plain(claim.formula, holds, finding.trace)
        if plain is not None:
            return plain
        try:
            with bounded(deadline + GRACE):
                return self._by_sets(claim.formula, claim, finding.trace, holds, deadline)
        except Late as error:
            self._forget()
            raise Unsaid(LATE) from error

    def _by_sets(
        self, formula: Formula, claim: Claim, trace: Trace | None, holds: bool, deadline: float
    ) -> list[OperatorProof]:
        operators = Operators(self._analysis, self._sets, self._runs, self._never, claim.fair, deadline)
        if claim.linear:
            return operators.linear(formula)
        with suppress(SpuriousRun):
            trace = trace or self._run(formula, holds)
        trace = trace or Trace(())
        return WitnessProof(operators, trace, self._held(trace)).prove(formula, holds)

    def _forget(self) -> None:
        """Drop the analysis and what the checker derived: an interrupted search may have left them half done."""
        vars(self).pop("_analysis", None)
        vars(self).pop("_sets", None)
        self.checker.suppose(self.checker.parts)

    # ---- what needs no sets of states ----

    def _plain(self, formula: Formula, positive: bool, trace: Trace | None) -> list[OperatorProof] | None:
        """Return proofs by the invariant and by the run of the finding; None if these do not prove the formula."""
        match formula:
            case Negation(part):
                return self._plain(part, not positive, trace)
            case _ if momentary(formula):
                return [] if self._at(formula, self.checker.initial) is positive else None
            case Conjunction(parts) | Disjunction(parts):
                shown = [(part, self._plain(part, positive, trace)) for part in parts]
                if positive is isinstance(formula, Disjunction):  # one of them is enough
                    chosen = next((n for n, (_, proof) in enumerate(shown) if proof is not None), None)
                    if chosen is None:
                        return None
                    shown = [
                        (part, proof if n == chosen else trivial(part, positive))
                        for n, (part, proof) in enumerate(shown)
                    ]
                return (
                    None if any(proof is None for _, proof in shown) else [p for _, proof in shown for p in proof or ()]
                )
            case SomeNext(SomeUntil(left, goal)) if momentary(left) and momentary(goal):
                found = self._comes(left, goal, trace) if positive else self._excluded(goal)
                return None if found is None else [None, found]
            case SomeNext(goal) if momentary(goal) and not positive:
                found = self._excluded(goal)
                return None if found is None else [found]
            case SomeUntil(left, goal) if momentary(left) and momentary(goal):
                here = self._at(goal, self.checker.initial)
                if here:
                    return [{"kind": "layers", "layers": []}] if positive else None
                if positive and not self._at(left, self.checker.initial):
                    return None
                found = self._comes(left, goal, trace) if positive else self._excluded(goal)
                return None if found is None else [found]
            case _:
                return None

    def _excluded(self, goal: Formula) -> OperatorProof:
        return INVARIANT if self._never(goal) else None

    def _comes(self, left: Formula, goal: Formula, trace: Trace | None) -> OperatorProof:
        """Return the run of a finding up to where the goal is true, if `left` is true until then; else None."""
        steps = self._runs.steps(trace or Trace(()))
        for number, now in enumerate(self._states(steps), 1):
            if self._at(goal, now):
                return {"kind": "run", "steps": steps[:number], "from": 0, "loop": None}
            if not self._at(left, now):
                return None
        return None

    def _states(self, steps: Iterable[dict[str, Any]]) -> Iterator[State]:
        """Yield the states of the checker after the steps of a run."""
        now = self.checker.initial
        for step in steps:
            now = self.checker.whole(self.checker.event(step["event"]), now, [])[0].state
            yield now

    def _at(self, formula: Formula, state: State) -> bool:
        return self.checker.true(self.checker.formula(self.statement.moment(formula)), state)

    # ---- runs, and what is known of their moments ----

    def _lasso(self, trace: Trace | None) -> OperatorProof:
        if trace is None or trace.loop_start is None:
            raise Unsaid(SHOWS_NOT)
        return {"kind": "run", "steps": self._runs.steps(trace), "from": 0, "loop": trace.loop_start}

    def _run(self, formula: Formula, positive: bool) -> Trace | None:
        """Return a run that shows a formula, or if not `positive` its negation, or a part of it; None if none does."""
        match formula:
            case Negation(part):
                return self._run(part, not positive)
            case SomeNext(part) if positive:
                return self._run(part, True)
            case SomeUntil(left, goal) if positive and left == TRUE and momentary(goal):
                return self._analysis.run_into(moments(self._analysis.meaning, goal))
            case SomeUntil() | SomeAlways() if positive:
                return self._analysis.temporal.answer(Property("", None, "ctl", formula, None, NOWHERE)).trace
            case Conjunction(parts) | Disjunction(parts):
                found = (self._run(part, positive) for part in parts)
                return next((trace for trace in found if trace is not None), None)
            case _:
                return None

    def _never(self, formula: Formula) -> bool:
        """Return True only if the invariant implies that a formula of one moment is false after every step."""
        return never(self.checker, self.statement.moment(formula))

    def _held(self, trace: Trace) -> list[Set]:
        """Return for each moment of a run, the start first, the loop states with its state and observed facts."""
        analysis, loop = self._analysis, self._analysis.loop
        facts = [(number, fact) for number, fact in enumerate(loop.observed) if self._is_said(fact)]
        said = [(number, self.checker.formula(self.statement.moment(fact))) for number, fact in facts]
        held, state = [analysis.space.initial], analysis.reference.start()
        for moment, now in zip(trace.moments, self._states(self._runs.steps(trace)), strict=True):
            state, _ = analysis.reference.step(state, moment.event)
            held.append(analysis.space.cube_of(abstract(loop, state)))
            for number, fact in said:
                value = int(self.checker.true(fact, now))
                held[-1] &= analysis.space.is_value(loop.index["happened", number], value)
        return held

    def _is_said(self, fact: Happened | Passed) -> bool:
        """Return whether a fact can be expressed in the facts of the checker."""
        with suppress(Unsaid):
            return bool(self.statement.moment(fact))
        return False
