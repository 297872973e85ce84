"""Checks, the questions that they ask, and the context in which decision diagrams answer."""

from collections.abc import Callable, Iterator
from functools import cached_property, reduce
from operator import or_

from exover.checks.finding import Finding
from exover.dataclass import dataclass
from exover.diagnostics import Severity
from exover.engines.bdd.analysis import Analysis
from exover.engines.bdd.manager import Set
from exover.equivalence.nearby_runs import NearbyRuns
from exover.equivalence.redundancy import RuleContribution
from exover.equivalence.tables import TableComparison
from exover.loop.claim import Claim, Verdict
from exover.model.model import Location, Model, Rule
from exover.model.property import Label, Properties
from exover.model.semantics import Reference
from exover.model.trace import Trace
from exover.ocrd.compile import DecodedTables

REACHABLE, INDUCTION, WITNESS, TABLES = "reachable set", "induction", "witness", "tables"
"""Methods: by all reachable states, by induction, by a run that shows it, by the tables alone."""
PREVENTED = "only a launch could break the rule, and every decision prevents it"
RESTORED = "wherever the rule is broken, a step does not end before a remedy has restored it"
NEVER_WAITS = "no decision of the tables lets the request wait"

Subjects = Iterator[tuple[str, Location]]
"""The subjects of a check: names and locations, in the order of the text."""


@dataclass(frozen=True)
class Context:
    """A compiled model and its closed loop under examination."""

    compiled: DecodedTables
    analysis: Analysis

    @property
    def model(self) -> Model:
        """The model."""
        return self.compiled.model

    @property
    def properties(self) -> Properties:
        """The properties and assumptions."""
        return self.analysis.properties

    @property
    def reference(self) -> Reference:
        """The reference interpreter."""
        return self.analysis.reference

    @cached_property
    def nearby(self) -> NearbyRuns:
        """Short runs near rules and guards."""
        marks: dict[str, frozenset[Label]] = {}
        for label, _ in self.model.demands.values():
            marks[label[1]] = marks.get(label[1], frozenset()) | {label}
        return NearbyRuns(self.analysis.loop, self.reference, marks)

    def shows(self, mark: Label) -> bool:
        """Return whether a short run near the rule or guard of a mark passes it; False if there are assumptions."""
        return not self.properties.assumptions and mark in self.nearby.shown(mark[1]).marks

    def may_wait(self, request: str) -> bool:
        """Return whether some decision of the tables lets a request wait."""
        loop = self.analysis.loop
        return loop.may_wait[loop.request_number[request]]

    @cached_property
    def comparison(self) -> RuleContribution:
        """The comparison of decisions with and without rules."""
        return RuleContribution(self.analysis, self.tables.by_states)

    @cached_property
    def tables(self) -> TableComparison:
        """The comparison of the tables with the rules."""
        return TableComparison(self.analysis)


@dataclass(frozen=True, slots=True)
class Question:
    """One question: the check, its severity, the subject, and the location of the subject."""

    check: str
    severity: Severity
    subject: str
    location: Location

    def answer(
        self, verdict: Verdict, message: str, method: str = REACHABLE, trace: Trace | None = None, engine: str = "bdd"
    ) -> Finding:
        """Return the finding with this verdict."""
        return Finding(self.check, self.subject, self.severity, verdict, engine, method, message, self.location, trace)

    def holds(self, message: str, method: str = REACHABLE, trace: Trace | None = None) -> Finding:
        """Return the finding that it holds."""
        return self.answer("holds", message, method, trace)

    def violated(self, message: str, trace: Trace | None = None, method: str = REACHABLE) -> Finding:
        """Return the finding that it is violated."""
        return self.answer("violated", message, method, trace)

    def unknown(self, reason: str, engine: str = "bdd") -> Finding:
        """Return the finding that it could not be decided."""
        return self.answer("unknown", reason, method="", engine=engine)


@dataclass(frozen=True, slots=True)
class Check:
    """A question that is asked of every subject; `decide` answers it by diagrams, `claim` states it as a formula.

    `iff`: when a finding is `ok`, in words, as in docs/checks.md and reports; of a check named after what it warns of,
    when it is not. `holds` and `violated`: the messages for engines that know only the formula.
    """

    name: str
    severity: Severity
    iff: str
    subjects: Callable[[Model, Properties], Subjects]
    decide: Callable[[Context, Question], Finding]
    claim: Callable[[Model, Properties, str], Claim]
    holds: str = ""
    violated: str = ""


def unreached(context: Context, question: Question, states: Set, holds: str, violated: str) -> Finding:
    """Return that it holds if no step ends in one of these states, else that it is violated, with a run to one."""
    trace = context.analysis.run_into(states)
    return question.holds(holds) if trace is None else question.violated(violated, trace)


def unbroken(context: Context, question: Question, broken: Callable[[Rule], Set], holds: str, violated: str) -> Finding:
    """Return that it holds iff no step ends in a state that is `broken` for a rule of the subject; else a run to it."""
    named = context.model.rules_named(question.subject)
    if context.tables.prevents(named):
        return question.holds(PREVENTED, INDUCTION)
    states = reduce(or_, map(broken, named), context.analysis.space.none)
    if context.analysis.excluded(states):
        return question.holds(RESTORED, INDUCTION)
    return unreached(context, question, states, holds, violated)


def rules(model: Model, _: Properties) -> Subjects:
    """Yield the rules by name: the pairs of a mutex are one subject."""
    found: dict[str, Location] = {}
    for rule in model.rules:
        found.setdefault(rule.name, rule.location)
    yield from found.items()


def requests(model: Model, _: Properties) -> Subjects:
    """Yield the requests."""
    for request in model.requests:
        yield request.name, request.location


def launches(model: Model, _: Properties) -> Subjects:
    """Yield the launch rules."""
    for launch in model.launches:
        yield launch.name, launch.location
