"""Proofs of findings: one inductive invariant for all of them, and for each claim the proof that the search finds."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import cached_property
from math import inf
from time import process_time

from exover.certificate.check import SolverGaveUp
from exover.certificate.proof import Proof
from exover.certificate.table import Refused, decode
from exover.checks.finding import Finding
from exover.dataclass import dataclass
from exover.engines.aig.invariant_clauses import invariant_clauses
from exover.engines.bdd.backward_reachability import TooWide
from exover.engines.bdd.concretize import SpuriousRun
from exover.loop.claim import Claim, Progress
from exover.loop.finite.tested_bounds import TooLarge
from exover.model.conditions import fulfilled
from exover.model.property import Broken, Formula, Properties, SomeUntil, momentary
from exover.model.wire import Json
from exover.ocrd.compile import Compiled
from exover.proofs.clauses import Clauses, written
from exover.proofs.invariants import Hurried, Invariants, houdini, kept_by_steps, never
from exover.proofs.operators import TOO_LARGE
from exover.proofs.search import ProofSearch, denied
from exover.proofs.statement import Statement, Unsaid, facts, temporal

FOR_IMPLICATION = 10.0
"""Seconds of the solver for one implication."""
FOR_PROOF, FOR_ALL, FOR_STEPS = 60.0, 600.0, 200.0
"""Seconds of the processor: for one proof, for all of them, and for finding what whole steps keep.

When those for all are over, the search ends, and the findings that are left have no proof."""


@dataclass
class CertificateProver:
    """Finds proofs about one table; every proof is checked before it is returned."""

    compiled: Compiled
    data: bytes
    properties: Properties
    claims: dict[tuple[str, str], Claim]
    findings: Sequence[Finding]
    progress: Progress

    def __post_init__(self) -> None:
        self._end = process_time() + FOR_ALL

    @cached_property
    def statement(self) -> Statement:
        """Writes the claims in SMT-LIB."""
        return Statement(self.compiled.model, facts(self.claims.values(), self.properties))

    @cached_property
    def checker(self) -> Hurried:
        """The checker of the table, with the assumptions; `invariants` gives it the invariant."""
        checker = Hurried(decode(self.data), FOR_IMPLICATION, watched=self.statement.watched())
        checker.assumptions = [checker.formula(text) for text in self.assumptions]
        return checker

    @cached_property
    def assumptions(self) -> list[str]:
        """The assumptions, as formulas that are true after every step that is looked at."""
        return [self.statement.moment(each.formula) for each in self.properties.assumptions]

    @cached_property
    def invariants(self) -> Invariants:
        """The formulas that single operations keep, and those that whole steps keep; the checker has them then."""
        self.progress("invariant")
        checker = self.checker
        parts = self._by_parts(list(self._candidates()))
        kept: list[str] = []
        goals = self._left(self._denied())
        if goals:
            self.progress("clauses")
            found = invariant_clauses(self.compiled, self.properties, [*goals.values()])
            clauses = (
                [] if found is None else list(written(found.clauses, Clauses(found.encoding.latches, self.statement)))
            )
            known = [] if found is None else [text for n, text in enumerate(goals) if n in found.never]
            more = self._by_parts([*parts, *clauses]) if clauses else parts
            left = self._left({text: goals[text] for text in known})
            if len(left) < len(known) and more:
                parts = more
            else:
                checker.suppose([*checker.typed(), *map(checker.formula, parts)])
            if left:
                kept = self._by_steps([text for text in clauses if text not in parts], [*left])
        checker.deadline = inf
        checker.suppose([])
        checker.induction(parts)
        checker.keep(kept)
        return Invariants(parts, kept)

    def _by_parts(self, candidates: list[str]) -> list[str]:
        """Return the candidates that all operations keep together; the checker takes them for invariant from now on."""
        self.checker.deadline = self._end
        found = houdini(self.checker, candidates)
        self.checker.suppose([*self.checker.typed(), *map(self.checker.formula, found)])
        return found

    def _by_steps(self, clauses: list[str], goals: list[str]) -> list[str]:
        """Return negations of `goals` that whole steps keep, and the clauses kept with them; empty if none is kept."""
        checker, parts = self.checker, list(self.checker.parts)
        found, wanted = list[str](), [f"(not {text})" for text in goals]
        for candidates in (wanted, [*clauses, *wanted]):
            checker.deadline = min(process_time() + FOR_STEPS / 2, self._end)
            found = kept_by_steps(checker, parts, candidates) or found
            if set(wanted) <= set(found):
                break
        return found if set(wanted) & set(found) else []

    def _denied(self) -> dict[str, Formula]:
        """Return, by their terms, the formulas that are false after every step if the verdicts are right."""
        found: dict[str, Formula] = {}
        for finding in self.findings:
            claim = self.claims[finding.key]
            if finding.verdict != "unknown" and claim.formula is not None and not claim.linear:
                for formula in denied(claim.formula, finding.verdict == "holds"):
                    with suppress(Unsaid):
                        found.setdefault(self.statement.moment(formula), formula)
        return found

    def _left(self, goals: dict[str, Formula]) -> dict[str, Formula]:
        """Return the formulas that the invariant is not known to make false after every step."""
        return {text: formula for text, formula in goals.items() if not never(self.checker, text)}

    def _candidates(self) -> Iterator[str]:
        """Yield candidates for the invariant: no broken rule, launches as required, nothing waits, no goal reached."""
        model, statement = self.compiled.model, self.statement
        for rule in model.rules:
            yield from (f"(not {statement.moment(Broken(rule, once_stopped))})" for once_stopped in (False, True))
        for number, launch in enumerate(model.launches):
            yield f"(or (not tried.{number}) {statement.condition(fulfilled(model, launch))})"
        for number in range(len(model.requests)):
            yield from (f"(not fallen.{number})", f"(not (= place.{number} 1))", f"(not (= place.{number} 2))")
        for claim in self.claims.values():
            for formula in () if claim.formula is None else temporal(claim.formula):
                if isinstance(formula, SomeUntil) and momentary(formula.right):
                    with suppress(Unsaid):
                        yield f"(or start (not {statement.moment(formula.right)}))"

    @cached_property
    def search(self) -> ProofSearch:
        """The search for a proof of each claim."""
        return ProofSearch(self.compiled, self.properties, self.claims, self.progress, self.statement, self.checker)

    def finding(self, finding: Finding) -> Json:
        """Return a finding with its claim and its proof, or with the reason why it has none."""
        head: Json = {"check": finding.check, "subject": finding.subject, "verdict": finding.verdict}
        self.progress(f"proof of {finding.check} {finding.subject}")
        asked, claim = self.claims[finding.key], None
        self.checker.deadline = min(process_time() + FOR_PROOF, self._end)
        try:
            claim = self.statement.claim(asked)
            parts = self.search.parts(asked, finding, self.checker.deadline)
            Proof(self.checker, claim, parts).check(finding.verdict)
            proof: Json = {"kind": "formula", "parts": parts}
        except (Unsaid, TooLarge, SpuriousRun) as error:
            proof = {"kind": "none", "reason": str(error)}
        except (Refused, SolverGaveUp) as error:
            proof = {"kind": "none", "reason": f"what was tried does not prove it: {error}"}
        except TooWide:
            proof = {"kind": "none", "reason": TOO_LARGE}
        return head | {"claim": claim, "proof": proof}
