"""All checks of a compiled model, their traces replayed on the tables."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter

from exover.checks import CHECKS
from exover.checks.finding import Finding, Severity
from exover.checks.limits import NO_LIMITS, Limits
from exover.checks.question import Check, Context, Question
from exover.model.event import Event
from exover.model.model import Model
from exover.model.property import NO_PROPERTIES, Properties
from exover.model.semantics import Reference
from exover.model.trace import Answers, confirm
from exover.ocrd.compile import Compiled
from exover.ocrd.machine import Machine
from exover.verify.bdd.analysis import Analysis
from exover.verify.bdd.search import Progress
from exover.verify.bdd.walk import Spurious
from exover.verify.cells import TooLarge

SEVERITIES: tuple[Severity, ...] = ("error", "warning", "note")
FIGURES = "figures"
"""What the last question of an agenda is about: the loop itself."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What the checks found, in the order of docs/checks.md, the number of bits of the loop's state, and a remark."""

    findings: tuple[Finding, ...] = ()
    state_bits: int = 0
    note: str = ""


def check_all(
    compiled: Compiled,
    progress: Progress,
    severities: Collection[Severity] = SEVERITIES,
    properties: Properties = NO_PROPERTIES,
    limits: Limits = NO_LIMITS,
) -> Outcome:
    """Return what every check says of a model and its tables, which should be those decoded from the emitted bytes.

    Only runs that `properties` assumes are looked at. Only checks of the given severities are asked. Traces are runs
    of the reference interpreter, confirmed on the tables. `progress` is told what is looked at. The answers are the
    same for any number of jobs; what has none within the limits is unknown.
    """
    desk = Desk(compiled, properties, tuple(questions(compiled.model, severities, properties)))
    if limits.seconds is None and limits.jobs == 1:
        findings = tuple(desk.answer(number, progress) for number in range(len(desk.questions)))
        return Outcome(findings, desk.context(progress).analysis.state_bits)
    return _spread(desk, limits, progress)


def questions(
    model: Model, severities: Collection[Severity], properties: Properties
) -> Iterator[tuple[Check, Question]]:
    """Yield the questions of every check of these severities in the order of docs/checks.md."""
    for check in CHECKS:
        if check.severity in severities:
            for subject, location in check.subjects(model, properties):
                yield check, Question(check.name, check.severity, subject, location)


def unanswered(model: Model, severities: Collection[Severity], properties: Properties, reason: str) -> Outcome:
    """Return what is known of a model of which no question could be asked."""
    return Outcome(tuple(question.unknown(reason) for _, question in questions(model, severities, properties)))


@dataclass
class Desk:
    """Where the questions about a model are answered; what one answer has cost, the next need not pay."""

    compiled: Compiled
    properties: Properties
    questions: tuple[tuple[Check, Question], ...]
    _context: Context | None = None

    def context(self, progress: Progress) -> Context:
        """Return the loop under examination."""
        if self._context is None:
            reference = Reference(self.compiled.model)
            self._context = Context(self.compiled, Analysis(self.compiled, reference, progress, self.properties))
        return self._context

    def answer(self, number: int, progress: Progress) -> Finding:
        """Return the finding of a question with the seconds it took; `unknown` if the engine cannot express it."""
        check, question = self.questions[number]
        progress(f"{question.check} {question.subject}")
        started = perf_counter()
        try:
            finding = check.decide(self.context(progress), question)
        except (TooLarge, Spurious) as reason:
            finding = question.unknown(str(reason))
        if finding.trace:
            confirm(finding.trace, "the walker of the tables", self._walk)
        return replace(finding, seconds=perf_counter() - started)

    @cached_property
    def _machine(self) -> Machine:
        return Machine(self.compiled.model, self.compiled.tables)

    def _walk(self, events: tuple[Event, ...]) -> tuple[Answers, ...]:
        self._machine.restart()
        return tuple(self._machine.step(event) for event in events)

    def answer_or_figures(self, number: int, progress: Progress) -> Finding | int:
        """Return the finding of a question or, for the number after the last, the number of bits of the state."""
        if number < len(self.questions):
            return self.answer(number, progress)
        return self.context(progress).analysis.state_bits


def _spread(desk: Desk, limits: Limits, progress: Progress) -> Outcome:
    """Return what the checks say, asked in processes of their own."""
    from exover.checks.agenda import Agenda
    from exover.checks.workers import Lost, spread  # it imports what only those need who want it

    agenda = Agenda((*(question.check for _, question in desk.questions), FIGURES), limits.seconds)
    *answers, bits = spread(desk.answer_or_figures, agenda, limits, progress)
    findings: list[Finding] = []
    for answer, (_, question) in zip(answers, desk.questions, strict=True):
        if isinstance(answer, Lost):
            answer = question.unknown(answer.reason)  # noqa: PLW2901
        assert isinstance(answer, Finding)
        findings.append(answer)
    return Outcome(tuple(findings), bits if isinstance(bits, int) else 0)
