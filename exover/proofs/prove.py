"""Proofs for findings: what is invariant of all runs, and for each claim what the search finds."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from math import inf
from time import process_time
from typing import Any

from exover.certificate.check import Checker, GaveUp
from exover.certificate.proof import Proof
from exover.certificate.step import Step
from exover.certificate.table import Refused, decode
from exover.certificate.term import conj, neg, z3
from exover.checks.finding import Finding
from exover.loop.claim import Claim
from exover.model.expression import Or, Status
from exover.model.property import Broken, Properties, SomeUntil
from exover.ocrd.compile import Compiled
from exover.ocrd.vector import same_arguments
from exover.proofs.operators import LATE, TOO_LARGE
from exover.proofs.search import Search
from exover.proofs.statement import Json, Statement, Unsaid, facts, momentary
from exover.verify.bdd.backwards import TooWide
from exover.verify.bdd.search import Progress
from exover.verify.bdd.walk import Spurious
from exover.verify.cells import TooLarge
from exover.verify.temporal.rankings import temporal


def houdini(checker: "Hurried", texts: Sequence[str]) -> list[str]:
    """Return those of the formulas that are together invariant: the largest such set (Flanagan, Leino 2001).

    None of them, where there is no time to tell.
    """
    kept = {text: checker.formula(text) for text in dict.fromkeys(texts)}
    kept = {text: part for text, part in kept.items() if checker.true(part, checker.initial)}
    typed = checker.typed()
    while True:
        given = [*typed, *kept.values()]  # of a whole round: what is lost in it counts from the next one on
        for _, enabled, now in checker.operations():
            if process_time() > checker.deadline:
                return []
            while lost := _lost(checker, given, kept, enabled, now):
                kept = {text: part for text, part in kept.items() if text not in lost}
        if len(given) == len(typed) + len(kept):
            return list(kept)


def _lost(checker: Checker, given: list[Any], kept: dict[str, Any], enabled: Any, now: Step) -> set[str]:
    """Return some of the formulas that an operation makes false where what is given is true; none if it makes none."""
    changed = checker.changed(now)
    touched = {text: part for text, part in kept.items() if checker.reads(part).keys() & changed}
    after = checker.at(conj(*touched.values()), now.state, changed)
    wrong = conj(enabled, neg(after))
    if wrong is False:
        return set()
    solver = checker.solver(given)
    solver.push()
    solver.add(wrong)
    answer, lost = solver.check(), set(touched)
    if answer == z3().sat:
        model, parts = solver.model(), after.children() if len(touched) > 1 else [after]
        truths = (model.eval(part, model_completion=True) for part in parts)
        lost = {text for text, truth in zip(touched, truths, strict=True) if z3().is_false(truth)}
    solver.pop()
    return set() if answer == z3().unsat else lost


class Hurried(Checker):
    """The checker, which gives up when the time for a claim is over."""

    deadline: float = inf

    def satisfiable(self, what: str, given: list[Any], *parts: Any) -> bool:
        """Return whether some state is as all of the parts say."""
        if process_time() > self.deadline:
            raise GaveUp(LATE)
        return super().satisfiable(what, given, *parts)


@dataclass
class Prover:
    """Finds proofs about one table; every proof is checked before it is given."""

    compiled: Compiled
    data: bytes
    properties: Properties
    claims: dict[tuple[str, str], Claim]
    progress: Progress
    seconds: float
    seconds_each: float
    seconds_all: float

    def __post_init__(self) -> None:
        self._end = process_time() + self.seconds_all

    @cached_property
    def statement(self) -> Statement:
        """Says what is claimed."""
        return Statement(self.compiled.model, facts(self.claims.values(), self.properties))

    @cached_property
    def checker(self) -> Hurried:
        """The checker, which knows what is invariant."""
        checker = Hurried(decode(self.data), self.seconds, watched=self.statement.watched())
        checker.assumptions = [checker.formula(text) for text in self.assumptions]
        return checker

    @cached_property
    def assumptions(self) -> list[str]:
        """What steps are assumed to end in."""
        return [self.statement.moment(each.formula) for each in self.properties.assumptions]

    @cached_property
    def invariant(self) -> list[str]:
        """Formulas that are together invariant, on the level of single operations."""
        self.progress("invariant")
        self.checker.deadline = self._end
        found = houdini(self.checker, list(self._candidates()))
        self.checker.deadline = inf
        self.checker.induction(found)
        return found

    def _candidates(self) -> Iterator[str]:
        """Yield what may be invariant: that no rule is broken, that launches are as required, what is claimed."""
        model, statement = self.compiled.model, self.statement
        for rule in model.rules:
            yield from (f"(not {statement.moment(Broken(rule, calm))})" for calm in (False, True))
        for number, launch in enumerate(model.launches):
            same = same_arguments(model.request[launch.request], launch)
            held = Or((Status("active", launch.request, same), Status("waiting", launch.request, same)))
            yield f"(or (not tried.{number}) {statement.condition(held)})"
        for number in range(len(model.requests)):
            yield from (f"(not fallen.{number})", f"(not (= place.{number} 1))", f"(not (= place.{number} 2))")
        for claim in self.claims.values():
            for formula in () if claim.formula is None else temporal(claim.formula):
                if isinstance(formula, SomeUntil) and momentary(formula.right):
                    with suppress(Unsaid):
                        yield f"(or start (not {statement.moment(formula.right)}))"

    @cached_property
    def search(self) -> Search:
        """Finds what may prove a claim."""
        return Search(self.compiled, self.properties, self.claims, self.progress, self.statement, self.checker)

    def finding(self, finding: Finding) -> Json:
        """Return a finding with its claim and the proof of it, or why there is none."""
        head: Json = {"check": finding.check, "subject": finding.subject, "verdict": finding.verdict}
        self.progress(f"proof of {finding.check} {finding.subject}")
        asked, claim = self.claims[finding.check, finding.subject], None
        self.checker.deadline = min(process_time() + self.seconds_each, self._end)
        try:
            claim = self.statement.claim(asked)
            parts = self.search.parts(asked, finding, self.checker.deadline)
            Proof(self.checker, claim, parts).check(finding.verdict)
            proof: Json = {"kind": "formula", "parts": parts}
        except (Unsaid, TooLarge, Spurious) as error:
            proof = {"kind": "none", "reason": str(error)}
        except (Refused, GaveUp) as error:
            proof = {"kind": "none", "reason": f"what was tried does not prove it: {error}"}
        except TooWide:
            proof = {"kind": "none", "reason": TOO_LARGE}
        return head | {"claim": claim, "proof": proof}
