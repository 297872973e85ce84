"""All checks of a compiled model, their traces replayed on the tables."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter
from typing import assert_never

from exover.checks import CHECKS
from exover.checks.agenda import Agenda
from exover.checks.engines import (
    DIAGRAMS,
    EngineName,
    Engines,
    compare,
    finding_of,
    first,
    judge_of,
    together,
    vacuous,
)
from exover.checks.finding import Counted, Finding, Severity
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
from exover.verify.claim import Claim, Judge

SEVERITIES: tuple[Severity, ...] = ("error", "warning", "note")
FIGURES = ("bits", "states")
"""What is found out about the loop itself after all questions are asked."""


Found = tuple[list[Sequence[Finding]], int | None, Counted | None]
"""By question what each engine says of it, the number of bits of a state if it is known, and how many are reachable."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What the checks found, in the order of docs/checks.md, the number of bits of the loop's state, and a remark.

    `state_bits`: None if it is not known. `states`: the number of reachable states, if it was asked for.
    """

    findings: tuple[Finding, ...] = ()
    state_bits: int | None = None
    note: str = ""
    states: Counted | None = None


def check_all(
    compiled: Compiled,
    progress: Progress,
    severities: Collection[Severity] = SEVERITIES,
    properties: Properties = NO_PROPERTIES,
    limits: Limits = NO_LIMITS,
    engines: Engines = DIAGRAMS,
    count: bool = False,
) -> Outcome:
    """Return what every check says of a model and its tables, which should be those decoded from the emitted bytes.

    Only runs that `properties` assumes are looked at. Only checks of the given severities are asked. Traces are runs
    of the reference interpreter, confirmed on the tables. `progress` is told what is looked at. The answers are the
    same for any number of jobs; what has none within the limits is unknown. With `count`, reachable states are counted.
    Raises `Disagreement` if engines that are compared contradict each other.
    """
    asked = tuple(questions(compiled.model, severities, properties))
    desk = Desk(compiled, properties, asked, engines, count, limits.seconds is not None)
    if limits.seconds is None and limits.jobs == 1:
        rows, bits, states = desk.all_answers(progress)
    else:
        rows, bits, states = _spread(desk, limits, progress)
    if engines.compared:
        compare(rows, bool(properties.assumptions))
    findings = [together(row) if engines.compared else first(row) for row in rows]
    return Outcome(vacuous(findings), bits, states=states)


def questions(
    model: Model, severities: Collection[Severity], properties: Properties
) -> Iterator[tuple[Check, Question]]:
    """Yield the questions of every check of these severities in the order of docs/checks.md."""
    for check in CHECKS:
        if check.severity in severities:
            for subject, location in check.subjects(model, properties):
                yield check, Question(check.name, check.severity, subject, location)


def unanswered(
    model: Model,
    severities: Collection[Severity],
    properties: Properties,
    reason: str,
    engines: Engines,
    count: bool,
) -> Outcome:
    """Return what is known of a model of which no question could be asked."""
    asked = questions(model, severities, properties)
    findings = tuple(question.unknown(reason, engines.names[0]) for _, question in asked)
    return Outcome(findings, states=Counted(None, reason) if count else None)


@dataclass
class Desk:
    """Where the questions about a model are answered; what one answer has cost, the next need not pay.

    The tasks are the questions put to the first engine, then the same to the next, and last how large the loop is:
    the number of bits of a state and, with `count`, that of the reachable states. `limited`: any answer may be cut off.
    """

    compiled: Compiled
    properties: Properties
    questions: tuple[tuple[Check, Question], ...]
    engines: Engines = DIAGRAMS
    count: bool = False
    limited: bool = False
    _context: Context | None = None

    # ---- tasks ----

    def agenda(self, seconds: float | None) -> Agenda:
        """Return the order in which the tasks are taken."""
        count = len(self.questions)
        checks = [f"{name} {question.check}" for name in self.engines.names for _, question in self.questions]
        stages = 0 if self.engines.compared else len(self.engines.names) - 1
        return Agenda(
            (*checks, *FIGURES[: 1 + self.count]), seconds, {task: task + count for task in range(count * stages)}
        )

    def task(self, number: int, progress: Progress) -> Finding | int | Counted | None:
        """Return what is found out by a task."""
        figure = number - len(self.questions) * len(self.engines.names)
        if figure >= 0:
            return self.counted(progress) if figure else self.state_bits(progress)
        place, question = divmod(number, len(self.questions))
        return self.answer(self.engines.names[place], question, progress)

    def open(self, number: int, reason: str) -> Finding:
        """Return the finding of a task that was not done."""
        place, question = divmod(number, len(self.questions))
        return self.questions[question][1].unknown(reason, self.engines.names[place])

    def rows(self, findings: Sequence[Finding]) -> list[Sequence[Finding]]:
        """Return by question what each engine says of it."""
        count = len(self.questions)
        return [findings[number::count] for number in range(count)]

    def all_answers(self, progress: Progress) -> Found:
        """Return what is found out by all tasks that have to be done, one after the other."""
        rows: list[Sequence[Finding]] = [self._answers(number, progress) for number in range(len(self.questions))]
        return rows, self.state_bits(progress), self.counted(progress) if self.count else None

    def _answers(self, number: int, progress: Progress) -> list[Finding]:
        found: list[Finding] = []
        for engine in self.engines.names:
            found.append(self.answer(engine, number, progress))
            if found[-1].verdict != "unknown" and not self.engines.compared:
                break
        return found

    # ---- answers ----

    def answer(self, engine: EngineName, number: int, progress: Progress) -> Finding:
        """Return what an engine says of a question, with the seconds it took; `unknown` if it cannot express it."""
        check, question = self.questions[number]
        progress(f"{question.check} {question.subject}")
        started = perf_counter()
        if engine == "bdd":
            finding = self._decided(check, question, progress)
        else:
            finding = finding_of(self._judges[engine], self._claim(number), check, question)
        if finding.trace:
            confirm(finding.trace, "the walker of the tables", self._walk)
        return replace(finding, seconds=perf_counter() - started)

    def _decided(self, check: Check, question: Question, progress: Progress) -> Finding:
        try:
            return check.decide(self.context(progress), question)
        except (TooLarge, Spurious) as reason:
            return question.unknown(str(reason))

    def state_bits(self, progress: Progress) -> int | None:
        """Return the number of bits of the state; None if it is more than can be followed."""
        return self.context(progress).analysis.state_bits

    def counted(self, progress: Progress) -> Counted:
        """Return the number of reachable states."""
        from exover.verify.bdd.count import count_states

        progress("number of states")
        try:
            return Counted(count_states(self.context(progress).analysis.stepper))
        except TooLarge as reason:
            return Counted(None, str(reason))

    def context(self, progress: Progress) -> Context:
        """Return the loop under examination."""
        if self._context is None:
            reference = Reference(self.compiled.model)
            self._context = Context(self.compiled, Analysis(self.compiled, reference, progress, self.properties))
        return self._context

    @cached_property
    def _judges(self) -> dict[str, Judge]:
        others = [name for name in self.engines.names if name != "bdd"]
        claims = None if self.limited else tuple(self._claim(number) for number in range(len(self.questions)))
        return {name: judge_of(name, self.engines, self.compiled, self.properties, claims) for name in others}

    def _claim(self, number: int) -> Claim:
        check, question = self.questions[number]
        return check.claim(self.compiled.model, self.properties, question.subject)

    @cached_property
    def _machine(self) -> Machine:
        return Machine(self.compiled.model, self.compiled.tables)

    def _walk(self, events: tuple[Event, ...]) -> tuple[Answers, ...]:
        self._machine.restart()
        return tuple(self._machine.step(event) for event in events)


def _spread(desk: Desk, limits: Limits, progress: Progress) -> Found:
    """Return what is found out by all tasks that have to be done, in processes of their own."""
    from exover.checks.workers import Lost, spread  # it imports what only those need who want it

    def vain(answer: Finding | int | Counted | Lost | None) -> bool:
        return isinstance(answer, Lost) or (isinstance(answer, Finding) and answer.verdict == "unknown")

    answers = spread(desk.task, desk.agenda(limits.seconds), limits, progress, vain)
    findings: list[Finding] = []
    bits: int | None = None
    states = None
    for number, answer in enumerate(answers):
        match answer:
            case Finding():
                findings.append(answer)
            case int():
                bits = answer
            case Counted():
                states = answer
            case Lost(reason) if number < len(desk.questions) * len(desk.engines.names):
                findings.append(desk.open(number, reason))
            case Lost(reason) if number == len(answers) - 1 and desk.count:
                states = Counted(None, reason)
            case Lost() | None:
                pass
            case _:
                assert_never(answer)
    return desk.rows(findings), bits, states
