"""Proofs for findings: what is invariant of all runs, runs, layers that lead to a goal, sets that no run leaves."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from exover.certificate.check import Checker, GaveUp
from exover.certificate.table import Refused, decode
from exover.certificate.term import conj, neg, z3
from exover.certificate.verify import Proof
from exover.checks.finding import Finding
from exover.model.expression import Or, Status
from exover.model.model import NOWHERE
from exover.model.property import Broken, Disjunction, Formula, Happened, Negation, Passed, Properties, Property, atoms
from exover.model.semantics import Reference
from exover.ocrd.compile import Compiled
from exover.ocrd.vector import same_arguments
from exover.proofs.runs import Runs
from exover.proofs.sets import Sets
from exover.proofs.statement import Always, Json, Possible, Recoverable, Shape, Statement, Unsaid, shape
from exover.verify.bdd.analysis import Analysis
from exover.verify.bdd.backwards import Backwards, TooWide
from exover.verify.bdd.search import Progress
from exover.verify.bdd.space import Set
from exover.verify.bdd.steps import WIDE
from exover.verify.bdd.walk import Spurious
from exover.verify.cells import TooLarge
from exover.verify.claim import Claim
from exover.verify.temporal.moments import moments

MOST_NODES = 3000
"""A set with more nodes is not written down."""
TOO_LARGE = "the set of states that the proof needs is too large to be written down"


def houdini(checker: Checker, texts: Sequence[str]) -> list[str]:
    """Return those of the formulas that are together invariant: the largest such set (Flanagan, Leino 2001)."""
    kept = [(text, checker.formula(text)) for text in dict.fromkeys(texts)]
    kept = [(text, part) for text, part in kept if checker.true(part, checker.initial, {})]
    typed = checker.typed()
    while True:
        checker.listen(part for part in (*typed, *(part for _, part in kept)))
        before = len(kept)
        for _, enabled, now in checker.operations():
            kept = _surviving(checker, typed, kept, enabled, now)
        if len(kept) == before:
            return [text for text, _ in kept]


def _surviving(
    checker: Checker, typed: list[Any], kept: list[tuple[str, Any]], enabled: Any, now: Any
) -> list[tuple[str, Any]]:
    """Return the formulas that an operation does not make false while they and `typed` are true before it."""
    changed = checker.changed(now)
    after = {t: checker.at(part, now.state, now.facts) for t, part in kept if checker.reads(part) & changed}
    while after:
        solver = checker.solver((*typed, *(part for _, part in kept), enabled, neg(conj(*after.values()))))
        answer = solver.check()
        if answer == z3().unsat:
            break
        lost = set(after)
        if answer == z3().sat:
            model = solver.model()
            lost = {text for text, part in after.items() if z3().is_false(model.eval(part, model_completion=True))}
        kept = [(text, part) for text, part in kept if text not in lost]
        after = {text: part for text, part in after.items() if text not in lost}
    return kept


@dataclass
class Prover:
    """Finds proofs about one table; every proof is checked before it is given."""

    compiled: Compiled
    data: bytes
    properties: Properties
    claims: dict[tuple[str, str], Claim]
    progress: Progress
    seconds: float

    @cached_property
    def statement(self) -> Statement:
        """Says what is claimed."""
        return Statement(self.compiled.model)

    @cached_property
    def runs(self) -> Runs:
        """Writes runs."""
        return Runs(self.statement)

    @cached_property
    def checker(self) -> Checker:
        """The checker, which knows what is invariant."""
        checker = Checker(decode(self.data), self.seconds)
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
        found = houdini(self.checker, list(self._candidates()))
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
            with suppress(Unsaid):
                said = statement.claim(shape(claim))
                if "always" in said:
                    yield said["always"]
                elif "possible" in said:
                    yield f"(not {said['possible']})"

    # ---- the proof of one finding ----

    def finding(self, finding: Finding) -> Json:
        """Return a finding with its claim and the proof of it, or why there is none."""
        head: Json = {"check": finding.check, "subject": finding.subject, "verdict": finding.verdict}
        self.progress(f"proof of {finding.check} {finding.subject}")
        claim = None
        reason = "the question has no answer" if finding.verdict == "unknown" else "no run is known that shows it"
        try:
            form = shape(self.claims[finding.check, finding.subject])
            claim = self.statement.claim(form)
            for proof in self._proofs(finding, form):
                entry = head | {"claim": claim, "proof": proof}
                try:
                    Proof(self.checker, entry).check()
                    return entry
                except (Refused, GaveUp) as error:
                    reason = f"what was tried does not prove it: {error}"
        except (Unsaid, TooLarge, Spurious) as error:
            reason = str(error)
        except TooWide:
            reason = TOO_LARGE
        return head | {"claim": claim, "proof": {"kind": "none", "reason": reason}}

    def _proofs(self, finding: Finding, form: Shape) -> Iterator[Json]:
        """Yield what may prove the verdict, the simplest first."""
        holds = finding.verdict == "holds"
        match form:
            case _ if finding.verdict == "unknown":
                return
            case Always(part):
                yield from self._moment(finding, Negation(part), not holds)
            case Possible(now, later):
                yield from self._moment(finding, Disjunction((now, later)), holds)
            case Recoverable(since, allowed, goal):
                yield from self._layers(since, allowed, goal) if holds else self._trap(finding, since, allowed, goal)

    def _moment(self, finding: Finding, goal: Formula, reached: bool) -> Iterator[Json]:
        """Yield the run of the finding, or a shortest run to the goal; what no step leaves, if there is none."""
        if not reached:
            yield {"kind": "invariant"}
            bad = self._leading(self._moments(goal), self.analysis.space.all)
            yield {"kind": "closed", "steps": [], "states": self._text(~bad)}
            return
        yield {"kind": "run", "steps": []}
        trace = finding.trace or self.analysis.run_into(self._moments(goal))
        if trace is not None:
            yield {"kind": "run", "steps": self.runs.steps(trace)}

    # ---- what needs sets of states ----

    @cached_property
    def analysis(self) -> Analysis:
        """The closed loop, in which what claims ask of steps is remembered."""
        asked = [each for claim in self.claims.values() if claim.formula is not None for each in _facts(claim.formula)]
        extra = tuple(Property("", None, "ctl", fact, None, NOWHERE) for fact in dict.fromkeys(asked))
        properties = replace(self.properties, properties=(*self.properties.properties, *extra))
        return Analysis(self.compiled, Reference(self.compiled.model), self.progress, properties)

    @cached_property
    def _backwards(self) -> Backwards:
        return Backwards(self.analysis.stepper, self.analysis.stepper.universe, WIDE)

    @cached_property
    def _sets(self) -> Sets:
        return Sets(self.analysis.space, self.statement)

    def _moments(self, formula: Formula) -> Set:
        return moments(self.analysis.meaning, formula)

    def _text(self, states: Set) -> str:
        """Return a set, which may be any between steps that are none."""
        simple = self.analysis.space.simplified(states, self._backwards.within)
        if len(simple) > MOST_NODES:
            raise Unsaid(TOO_LARGE)
        return self._sets.text(simple)

    def _leading(self, goal: Set, allowed: Set) -> Set:
        """Return the states from which steps that end in `allowed` lead into `goal`, their last step as well."""
        backwards, found = self._backwards, self.analysis.space.none
        while True:
            before, wanted = found, goal & allowed | found & allowed
            for number in backwards.touching(wanted):
                for _, ways in backwards.before(wanted, [number]):
                    found |= ways
            if found == before:
                return found

    def _trap(self, finding: Finding, since: Formula, allowed: Formula, goal: Formula) -> Iterator[Json]:
        """Yield the run of the finding, and the states from which no allowed steps lead to the goal."""
        if finding.trace is not None:
            able = self._leading(self._moments(goal), self._moments(allowed))
            yield {"kind": "closed", "steps": self.runs.steps(finding.trace), "states": self._text(~able)}

    def _layers(self, since: Formula, allowed: Formula, goal: Formula) -> Iterator[Json]:
        """Yield layers of states: by an allowed event each leads to the goal or into one before."""
        layers = list(self._rings(self._moments(since), self._moments(allowed), self._moments(goal)))
        yield {"kind": "layers", "layers": layers}

    def _rings(self, since: Set, allowed: Set, goal: Set) -> Iterator[Json]:
        """Yield layers until `since` is covered; events take turns, each from all that is found so far (chaining)."""
        backwards, events, found = self._backwards, self.analysis.loop.events, self.analysis.space.none
        while True:
            before = found
            for number in backwards.touching((goal | found) & allowed):
                for _, ways in backwards.before((goal | found) & allowed, [number]):
                    if not self.analysis.excluded(ways & ~found):
                        yield {"event": self.runs.event(events[number].event), "states": self._text(ways & ~found)}
                        found |= ways
                if self.analysis.excluded(since & ~found):
                    return
            if found == before:
                raise Unsaid("it holds of the states that are reached, and what they are is not written down")


def _facts(formula: Formula) -> Iterator[Happened | Passed]:
    """Yield what a formula that has a statement asks of steps."""
    for atom in atoms(formula):
        if (isinstance(atom, Passed) and atom.label[0] in ("launch", "rule", "abort")) or (
            isinstance(atom, Happened) and atom.where is None
        ):
            yield atom
