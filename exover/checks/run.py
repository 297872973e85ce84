"""All checks of a compiled model, their traces replayed on the tables."""

from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import field, replace
from typing import Protocol

from exover.checks.causes.detail import detailed
from exover.checks.finding import Counted, Finding, FindingKey
from exover.checks.questions.question import Check, Question
from exover.checks.schedule.answers import NO_STORE, AnswerStore, KnownAnswers, LoopFigures, StoredLoop
from exover.checks.schedule.engines import suited
from exover.checks.schedule.examination import Examination
from exover.checks.schedule.opinions import compare, contradicted, first, together, vacuous
from exover.checks.schedule.plan import CheckPlan
from exover.checks.schedule.tasks import TaskAnswer, TaskRunner
from exover.checks.schedule.workers import Lost, alone, spread
from exover.dataclass import dataclass
from exover.diagnostics import Severity
from exover.limits import INTERRUPTED, NO_LIMITS, Limits, TimeUp, interrupted
from exover.loop.claim import Progress
from exover.model.model import Model
from exover.ocrd.compile import Compiled


@dataclass(frozen=True, slots=True)
class CheckOutcome:
    """The findings in the order of docs/checks.md, the number of bits of the loop's state, and a remark.

    `state_bits`: None if it is not known. `states`: the number of reachable states, if it was asked for.
    `interrupted`: the user has pressed Ctrl-C. `settled`: the answers to be stored.
    """

    findings: tuple[Finding, ...] = ()
    state_bits: int | None = None
    note: str = ""
    states: Counted | None = None
    interrupted: bool = False
    settled: "Settled | None" = field(default=None, compare=False, repr=False)

    @property
    def recalled(self) -> frozenset[FindingKey]:
        """The findings that were read from the store."""
        return frozenset(each.key for each in self.settled.answers.recalled.values()) if self.settled else frozenset()


@dataclass(frozen=True, slots=True)
class Settled:
    """The questions, their findings before other findings are taken into account, and the store for them."""

    answers: KnownAnswers
    asked: tuple[tuple[Check, Question], ...]
    findings: tuple[Finding, ...]
    state_bits: int | None

    def keep(self, replayed: bool) -> None:
        """Store the findings; `replayed`: traces of violations were replayed on the emitted C as well."""
        self.answers.keep(self.asked, self.findings, self.state_bits, replayed)


class Audience(Protocol):
    """Receives findings as soon as they are known."""

    def asks(self, questions: Counter[Severity]) -> None:
        """Receive the number of questions by severity, before they are asked."""
        ...

    def finds(self, finding: Finding) -> None:
        """Receive the finding of one question, perhaps `unknown`."""
        ...

    def waits(self) -> None:
        """Receive a sign, every now and then, that the checks still run."""
        ...


class Nobody:
    """An audience that ignores everything."""

    def asks(self, questions: Counter[Severity]) -> None:
        """Hear nothing."""

    def finds(self, finding: Finding) -> None:
        """Hear nothing."""

    def waits(self) -> None:
        """Hear nothing."""


NOBODY = Nobody()


def check_all(
    compiled: Compiled,
    progress: Progress,
    plan: CheckPlan,
    *,
    limits: Limits = NO_LIMITS,
    audience: Audience = NOBODY,
    store: AnswerStore = NO_STORE,
) -> CheckOutcome:
    """Return the findings of the checks on a model and its tables, which should be decoded from the emitted bytes.

    Traces are runs of the reference interpreter, confirmed on the tables. `progress` receives the current question, the
    audience each finding. Without a time limit, the answers are the same for any number of jobs. Questions that are
    open when the limits are reached or the user interrupts are `unknown`. Answers in the store are not asked for again,
    unless engines are compared; the outcome says what is to be stored. Raises `Disagreement` if engines that are
    compared contradict each other.
    """
    properties, engines = plan.properties, plan.engines
    put = tuple(plan.questions(compiled.model))
    stored = StoredLoop(compiled, properties, engines, NO_STORE if engines.compared else store)
    figures = stored.figures()
    examination = Examination(compiled, properties)
    if engines.adaptive and figures:
        engines = replace(engines, names=figures.names)
    elif engines.adaptive:
        with suppress(TimeUp), interrupted(limits):
            engines = suited(engines, examination.context(progress).analysis)
    answers = KnownAnswers(stored, engines.names)
    known = answers.answered(put)
    left = tuple(pair for number, pair in enumerate(put) if number not in known)
    spare = limits.jobs > 1 and not engines.compared
    runner = TaskRunner(examination, left, engines, plan.count, limits.seconds is not None, spare)
    sheet = _Sheet(runner, audience, known, figures)
    ended = _answered(sheet, limits, progress)
    reason = limits.reason if ended else INTERRUPTED
    rows = [sheet.row(number, reason) for number in range(len(left))]
    if engines.compared:
        compare(rows, bool(properties.assumptions))
    found = iter(map(sheet.answer, rows))
    findings = tuple(known[number] if number in known else next(found) for number in range(len(put)))
    settled = Settled(answers, put, findings, sheet.bits)
    known_so_far = contradicted(vacuous(findings))
    told = tuple(detailed(compiled.model, properties, known_so_far, lambda: limits.left <= 0))
    return CheckOutcome(told, sheet.bits, states=sheet.states(reason), interrupted=not ended, settled=settled)


def _answered(sheet: "_Sheet", limits: Limits, progress: Progress) -> bool:
    """Answer the questions within the limits; return False iff the user has interrupted."""
    runner, audience = sheet.runner, sheet.audience
    agenda = runner.agenda(limits.seconds)
    asked = Counter(question.severity for _, question in runner.questions)
    audience.asks(asked + Counter(finding.severity for finding in sheet.known.values()))
    for finding in sheet.known.values():
        audience.finds(finding)
    if sheet.figures and not runner.questions and not runner.count:
        return True
    try:
        if limits.jobs == 0:
            alone(runner.task, agenda, progress, sheet.take)
        else:
            spread(runner.task, agenda, limits, progress, sheet.take, audience.waits)
    except KeyboardInterrupt:
        return False
    return True


def unanswered(model: Model, plan: CheckPlan, reason: str, interrupted: bool = False) -> CheckOutcome:
    """Return an outcome in which every question is `unknown` for this reason."""
    findings = tuple(question.unknown(reason, plan.engines.names[0]) for _, question in plan.questions(model))
    states = Counted(None, reason) if plan.count else None
    return CheckOutcome(findings, states=states, interrupted=interrupted)


@dataclass
class _Sheet:
    """The answers so far, by task, and their audience; `known`: findings from the store, which are not asked."""

    runner: TaskRunner
    audience: Audience
    known: Mapping[int, Finding]
    figures: LoopFigures | None
    answers: dict[int, TaskAnswer | Lost] = field(default_factory=dict)

    def take(self, number: int, answer: TaskAnswer | Lost) -> bool:
        """Record the answer of a task; return whether the next engine is to be asked.

        Tell the audience if its question is decided.
        """
        self.answers[number] = answer
        place, question = self.runner.place(number)
        if place == len(self.runner.engines.names):
            return False
        said = self._said(number)
        row = self._row(question)
        goes_on = said.verdict == "unknown" and not self._given_up(place, row)
        if not self._open(row) or not (goes_on or self.runner.engines.compared):
            self.audience.finds(self.answer([each for each in row if each is not None]))
        return goes_on

    def _given_up(self, place: int, row: Sequence[Finding | None]) -> bool:
        """Return whether Z3 would be next, and diagrams came to their limit: such a question takes Z3 long, too."""
        left = self.runner.engines.names[place + 1 :]
        return left[:1] == ("z3",) and any(each is not None and each.exhausted for each in row)

    def answer(self, row: Sequence[Finding]) -> Finding:
        """Return the finding of a question, given those of the engines: joined if they are compared, else the first."""
        return together(row) if self.runner.engines.compared else first(row)

    def row(self, question: int, reason: str) -> Sequence[Finding]:
        """Return the findings of the engines for a question; one that was not asked is `unknown` for this reason.

        Unless engines are compared, those not asked are left out if another has a verdict, or if there is no reason.
        """
        found = self._row(question)
        known = [each for each in found if each is not None]
        decided = not reason or any(each.verdict != "unknown" for each in known)
        if decided and known and not self.runner.engines.compared:
            return known
        tasks = self._tasks(question)
        return [
            self.runner.open(task, reason) if each is None else each for task, each in zip(tasks, found, strict=True)
        ]

    @property
    def bits(self) -> int | None:
        """The number of bits of a state, None if it is not known."""
        if self.figures:
            return self.figures.state_bits
        bits = self.answers.get(self._figures)
        return bits if isinstance(bits, int) else None

    def states(self, reason: str) -> Counted | None:
        """Return the number of reachable states or why it is not known; None if it was not asked for."""
        if not self.runner.count:
            return None
        found = self.answers.get(self._figures + 1, Lost(reason))
        match found:
            case Counted():
                return found
            case Lost(why):
                return Counted(None, why)
            case _:
                raise TypeError(found)

    @property
    def _figures(self) -> int:
        """The number of the first task that is a figure of the loop."""
        return len(self.runner.questions) * len(self.runner.engines.names)

    def _tasks(self, question: int) -> range:
        return range(question, self._figures, len(self.runner.questions))

    def _row(self, question: int) -> list[Finding | None]:
        return [self._said(task) if task in self.answers else None for task in self._tasks(question)]

    def _said(self, number: int) -> Finding:
        answer = self.answers[number]
        match answer:
            case Finding():
                return answer
            case Lost(reason):
                return self.runner.open(number, reason)
            case _:
                raise TypeError(answer)

    @staticmethod
    def _open(row: Sequence[Finding | None]) -> bool:
        return any(each is None for each in row)
