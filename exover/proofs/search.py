"""The search for the proof of one claim: the checker reads the claim, and for each operator a part is found.

A part is taken as soon as the checker accepts it, so what is found is proved (docs/certificates.md).
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from exover.certificate.check import Checker, GaveUp
from exover.certificate.proof import Proof
from exover.certificate.table import Refused
from exover.checks.finding import Finding
from exover.model.model import NOWHERE
from exover.model.property import (
    Conjunction,
    Disjunction,
    Formula,
    Happened,
    Negation,
    Passed,
    Properties,
    Property,
    SomeNext,
    SomeUntil,
    atoms,
    parts_of,
)
from exover.model.semantics import Reference
from exover.ocrd.compile import Compiled
from exover.proofs.runs import Runs
from exover.proofs.sets import Sets
from exover.proofs.statement import Json, Statement, Temporal, Unsaid, momentary
from exover.verify.bdd.analysis import Analysis
from exover.verify.bdd.backwards import Backwards
from exover.verify.bdd.search import Progress
from exover.verify.bdd.space import Set
from exover.verify.bdd.steps import WIDE
from exover.verify.claim import Claim
from exover.verify.temporal.moments import moments

MOST_NODES = 3000
"""A set with more nodes is not written down."""
REMEMBERED = ("tried", "fallen", "chosen")
"""Variables of the loop that every step begins by forgetting."""
TOO_LARGE = "the set of states that the proof needs is too large to be written down"


Where = Callable[[], Set] | None
"""States, found out when they are asked for; None: the initial one."""


@dataclass
class Known:
    """What is known of the closed loop, when it is first asked for; claims ask these facts of its steps."""

    compiled: Compiled
    properties: Properties
    claims: dict[tuple[str, str], Claim]
    progress: Progress
    statement: Statement

    @cached_property
    def runs(self) -> Runs:
        """Writes runs."""
        return Runs(self.statement)

    @cached_property
    def analysis(self) -> Analysis:
        """The closed loop, in which what claims ask of steps is remembered."""
        asked = [each for claim in self.claims.values() if claim.formula is not None for each in _facts(claim.formula)]
        extra = tuple(Property("", None, "ctl", fact, None, NOWHERE) for fact in dict.fromkeys(asked))
        properties = replace(self.properties, properties=(*self.properties.properties, *extra))
        return Analysis(self.compiled, Reference(self.compiled.model), self.progress, properties)

    @cached_property
    def backwards(self) -> Backwards:
        """Steps backwards."""
        return Backwards(self.analysis.stepper, self.analysis.stepper.universe, WIDE)

    @cached_property
    def _sets(self) -> Sets:
        return Sets(self.analysis.space, self.statement)

    def text(self, states: Set) -> str:
        """Return a set, which may be any between steps that are none; what the last step remembers tells none apart."""
        space = self.analysis.space
        lasting = [number for number, each in enumerate(space.loop.variables) if each.key[0] not in REMEMBERED]
        simple = space.on(
            space.simplified(space.on(states, lasting), space.on(self.backwards.within, lasting)), lasting
        )
        if len(simple) > MOST_NODES:
            raise Unsaid(TOO_LARGE)
        return self._sets.text(simple)

    def true(self, formula: Formula) -> Set:
        """Return the states of which a formula is true."""
        if momentary(formula):
            return moments(self.analysis.meaning, formula)
        match formula:
            case Negation(part):
                return ~self.true(part)
            case Conjunction(parts):
                return ~self.true(Disjunction(tuple(map(Negation, parts))))
            case Disjunction(parts):
                found = self.analysis.space.none
                for part in parts:
                    found |= self.true(part)
                return found
            case SomeNext(part):
                return self.before(part)
            case SomeUntil(left, right):
                return self.true(right) | self.true(left) & self.before(formula)
            case _:
                raise Unsaid("it is about runs without end")

    def before(self, formula: Formula) -> Set:
        """Return the states with a step to where a formula, or if it is an `until`, that formula is true."""
        if not isinstance(formula, SomeUntil):
            return self._step(self.true(formula))
        found, goal, stay = self.analysis.space.none, self.true(formula.right), self.true(formula.left)
        while True:
            before, found = found, found | self._step(goal | found & stay)
            if found == before:
                return found

    def _step(self, goal: Set) -> Set:
        """Return the states from which a step leads to a goal, and the goal where a step may not lead out of it."""
        touching = self.backwards.touching(goal)
        found = self.backwards.union(self.backwards.before(goal, touching))
        return found | goal if len(touching) < len(self.analysis.loop.events) else found

    def layers(self, formula: Formula, where: Set) -> Iterator[Json]:
        """Yield layers of states by the event that leads on from them, until no more are needed.

        Events take turns, each from all that is found so far (chaining).
        """
        backwards, events, found = self.backwards, self.analysis.loop.events, self.analysis.space.none
        goal, stay, turns = self.true(formula), self.analysis.space.none, [False, True]
        if isinstance(formula, SomeUntil):
            goal, stay = self.true(formula.right), self.true(formula.left)
        while turns:
            before, wanted = found, goal | found & stay
            for number in range(len(events)) if turns[0] else backwards.touching(wanted):
                for _, ways in backwards.before(goal | found & stay, [number]):
                    if not self.analysis.excluded(ways & ~found):
                        yield {"event": self.runs.event(events[number].event), "states": self.text(ways & ~found)}
                        found |= ways
                if self.analysis.excluded(where & ~found):
                    return
            turns = [False, True] if found != before else turns[1:]
        raise Unsaid("it holds of the states that are reached, and what they are is not written down")


def _facts(formula: Formula) -> Iterator[Happened | Passed]:
    """Yield what a formula that has a statement asks of steps."""
    for atom in atoms(formula):
        if (isinstance(atom, Passed) and atom.label[0] in ("launch", "left", "rule", "abort")) or (
            isinstance(atom, Happened) and atom.where is None
        ):
            yield atom


class Search(Proof):
    """The search for the proof of a claim; `found`: its parts, once `check` has returned."""

    def __init__(self, checker: Checker, claim: Json, formula: Formula, finding: Finding, known: Known) -> None:
        self.operators = [formula] if claim["linear"] else list(temporal(formula))
        self.found: list[Json | None] = [
            None if isinstance(each, SomeNext) and isinstance(each.part, SomeUntil) else {"number": number}
            for number, each in enumerate(self.operators)
        ]
        super().__init__(checker, claim, self.found)
        self.trace, self.known = finding.trace, known
        self.places = list(self._places(formula, None))

    def _places(self, formula: Formula, where: Where) -> Iterator[Where]:
        """Yield for each temporal operator where it should be true, or should not; None: at the start."""
        match formula:
            case Negation(part):
                yield from self._places(part, where)
            case Conjunction(parts) | Disjunction(parts):
                now = type(formula)(tuple(part for part in parts if momentary(part)))
                rest = now if isinstance(formula, Conjunction) else Negation(now)
                left = where and (lambda: where() & self.known.true(rest))
                for part in parts:
                    yield from self._places(part, left)
            case SomeNext(SomeUntil() as part):
                yield where
                yield from self._places(part, where)
            case _:
                if not momentary(formula):
                    yield where
                    for part in parts_of(formula):
                        yield from self._places(part, lambda: self.known.analysis.space.all)

    def _rule(self, operator: str, inside: bool, proof: Any, first: Any, stay: Any, goal: Any) -> Any:
        """Return the bound that the first part proves which the checker accepts; raises `Unsaid` if none does."""
        number, reason = proof["number"], "no run is known that shows it"
        alone = operator == "EU" and None not in self.found[max(0, number - 1) : number]
        at_once = alone and self.checker.true(goal, self.checker.initial)
        for candidate in self._candidates(self.operators[number], self.places[number], inside, at_once):
            try:
                bound = super()._rule(operator, inside, candidate, first, stay, goal)
            except (Refused, GaveUp) as error:
                reason = f"what was tried does not prove it: {error}"
            else:
                self.found[number] = candidate
                return bound
        raise Unsaid(reason)

    def _candidates(self, formula: Formula, where: Where, inside: bool, at_once: bool) -> Iterator[Json]:
        """Yield what may prove that an operator is true, or is not, the simplest first."""
        known, nothing = self.known, {"kind": "layers", "layers": []}
        if not isinstance(formula, SomeNext | SomeUntil):
            raise Unsaid("the claim is about runs without end")
        if not inside:
            yield {"kind": "invariant"}
            yield {"kind": "closed", "states": known.text(known.before(formula))}
        elif where is not None:
            yield {"kind": "layers", "layers": list(known.layers(formula, where()))}
        elif at_once:
            yield nothing
        else:
            trace = self.trace or known.analysis.run_into(known.true(parts_of(formula)[-1]))
            if trace is not None:
                yield {"kind": "run", "steps": known.runs.steps(trace), "from": 0}
            yield nothing


def temporal(formula: Formula) -> Iterator[Formula]:
    """Yield the parts of a formula that begin with a temporal operator, outer ones first."""
    if isinstance(formula, Temporal):
        yield formula
    for part in parts_of(formula):
        yield from temporal(part)
