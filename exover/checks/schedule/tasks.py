"""The questions about a loop as numbered tasks: one for each engine and question, and the figures of the loop."""

from collections.abc import Iterator, Sequence
from dataclasses import field, replace
from math import inf
from time import perf_counter

from exover.checks.finding import SEVERITIES, Counted, Finding
from exover.checks.questions.property import is_contradiction
from exover.checks.questions.question import TABLES, WITNESS, Check, Question
from exover.checks.schedule.agenda import Agenda, Lot, Turn
from exover.checks.schedule.engines import EngineName, Engines, at_once, batch_of, judge_of
from exover.checks.schedule.examination import Examination
from exover.checks.schedule.opinions import finding_of
from exover.checks.schedule.serving import Say
from exover.dataclass import dataclass
from exover.engines.bdd.concretize import SpuriousRun
from exover.engines.bdd.effort import Effort, OutOfSteps, limited
from exover.loop.claim import APPROXIMATE, Claim, Judge, Opinion, Progress, believed
from exover.loop.finite.tested_bounds import TooLarge

SHOWN = 0.05
"""Seconds between two progress messages, at least: many questions take less."""
MARGIN = 0.8
"""The fraction of its slice after which an engine gives up by itself, before its process is halted."""
STEPS, PART = 400_000_000, 4
"""The steps that diagrams may take, without a time limit, for all questions that they do not answer; one question may
take one `PART`th of what is left of them: of the first some two minutes."""

TaskAnswer = Finding | int | Counted | None


@dataclass
class TaskRunner:
    """The questions about a loop as tasks, and the engines that answer them.

    With n questions and m engines, task e * n + q puts question q to engine e. Task m * n is the number of bits of a
    state and, with `count`, task m * n + 1 the number of reachable states. `limited`: any answer may be cut off;
    `spare`: the first engine, if it is asked all at once, may have two processes.
    """

    examination: Examination
    questions: tuple[tuple[Check, Question], ...]
    engines: Engines
    count: bool = False
    limited: bool = False
    spare: bool = False
    _judges: dict[str, tuple[float, Judge]] = field(default_factory=dict)
    _told: float = -inf
    _steps: float = 0
    """The steps that diagrams have taken for questions that they did not answer."""

    # ---- tasks ----

    def agenda(self, seconds: float | None) -> Agenda:
        """Return the agenda of the tasks; unless engines are compared, a task of the next engine is a stand-in."""
        count = len(self.questions)
        stages = 0 if self.engines.compared else len(self.engines.names) - 1
        lots = [lot for place, name in enumerate(self.engines.names) for lot in self._lots(name, place * count)]
        first = count * len(self.engines.names)
        lots += [Lot((first + number,), len(SEVERITIES)) for number in range(1 + self.count)]
        return Agenda(lots, seconds, {task: task + count for task in range(count * stages)})

    def _lots(self, engine: EngineName, first: int) -> Iterator[Lot]:
        """Yield the tasks of an engine, numbered from `first`: one lot if asked at once, else one for each check.

        Of diagrams that are asked at once, `tables` are a lot of their own, the first: no engine before them answers
        these, so they need not wait until those have answered the rest.
        """
        numbers = range(len(self.questions))
        if at_once(engine, self.engines, self.limited):
            tables = [n for n in numbers if engine == "bdd" and self.questions[n][1].check == "tables"]
            for part in filter(None, (tables, sorted(set(numbers).difference(tables)))):
                yield Lot([first + n for n in part], together=True, in_order=engine == "bdd")
            return
        checks: dict[str, list[int]] = {}
        for number in numbers:
            checks.setdefault(self.questions[number][1].check, []).append(number)
        for asked in checks.values():
            rank = SEVERITIES.index(self.questions[asked[0]][1].severity)
            yield Lot([first + number for number in asked], rank)

    def task(self, turn: Turn, say: Say[TaskAnswer], progress: Progress) -> None:
        """Do the tasks of a turn, and pass each answer to `say`."""
        place, _ = self.place(turn.numbers[0])
        if place == len(self.engines.names):
            (number,) = turn.numbers
            say(number, self._counted(progress) if self.place(number)[1] else self.examination.state_bits(progress))
            return
        name = self.engines.names[place]
        if at_once(name, self.engines, self.limited):
            self._batch(name, turn.numbers, say, progress)
        else:
            (number,) = turn.numbers
            self._one(name, number, turn.seconds, say, progress)

    def place(self, number: int) -> tuple[int, int]:
        """Return of a task the indices of its engine and question; of a figure the number of engines, and 0 or 1."""
        count, engines = len(self.questions), len(self.engines.names)
        return divmod(number, count) if number < count * engines else (engines, number - count * engines)

    def open(self, number: int, reason: str) -> Finding:
        """Return the finding `unknown` of a task that has no answer, with the reason."""
        place, question = self.place(number)
        return self.questions[question][1].unknown(reason, self.engines.names[place])

    # ---- answers ----

    def _one(self, engine: EngineName, number: int, seconds: float, say: Say[TaskAnswer], progress: Progress) -> None:
        """Pass the finding of one engine for one question to `say`, unless more time could give a better one.

        That is so if the verdict is `unknown` and over half of the slice is used up.
        """
        _, question = self.place(number)
        started = perf_counter()
        finding = (
            self._decided(question, progress) if engine == "bdd" else self._judged(engine, question, seconds, progress)
        )
        hurried = finding.verdict == "unknown" and perf_counter() - started > seconds / 2
        if not hurried:
            say(number, finding)

    def _batch(self, engine: EngineName, numbers: Sequence[int], say: Say[TaskAnswer], progress: Progress) -> None:
        """Pass the findings of an engine that is asked all at once to `say`."""
        if engine == "bdd":
            for number in numbers:
                say(number, self._decided(self.place(number)[1], progress))
            return
        progress(f"all that {engine} can answer")
        spare = self.spare and engine == self.engines.names[0]
        judge = batch_of(engine, self.engines, self.examination.compiled, self.examination.properties, spare)
        started = perf_counter()

        def answer(index: int, opinion: Opinion) -> None:
            nonlocal started
            check, question = self.questions[self.place(numbers[index])[1]]
            found = finding_of(opinion, judge.name, check, question)
            say(numbers[index], self._timed(check, found, started))
            started = perf_counter()

        judge.judge_all([self._claim(self.place(number)[1]) for number in numbers], answer)

    def _judged(self, engine: EngineName, number: int, seconds: float, progress: Progress) -> Finding:
        """Return the finding of an engine for a question; it is made anew if the slice has more than doubled."""
        kept = self._judges.get(engine)
        if kept is None or kept[0] * 2 < seconds < inf:
            patience = None if seconds == inf else seconds * MARGIN
            compiled, properties = self.examination.compiled, self.examination.properties
            kept = seconds, judge_of(engine, self.engines, compiled, properties, patience)
            self._judges[engine] = kept
        judge = kept[1]
        check, question = self.questions[number]
        started = self._begin(question, progress)
        found = finding_of(judge.judge(self._claim(number)), judge.name, check, question)
        return self._timed(check, found, started)

    def _decided(self, number: int, progress: Progress) -> Finding:
        """Return the finding of decision diagrams for a question.

        It is `unknown` if they cannot express it or, without a time limit, if it takes them too many steps.
        """
        check, question = self.questions[number]
        started = self._begin(question, progress)
        try:
            with self._limited() as effort:
                finding = check.decide(self.examination.context(progress), question)
            if self.examination.reads_reals and not self._believed(number, finding):
                approximate = self.examination.context(progress).analysis.loop.approximate
                finding = question.unknown(APPROXIMATE) if approximate else finding
            return self._timed(check, finding, started)
        except OutOfSteps as reason:
            self._steps += effort.taken
            return self._timed(check, replace(question.unknown(str(reason)), exhausted=True), started)
        except (TooLarge, SpuriousRun) as reason:
            return self._timed(check, question.unknown(str(reason)), started)

    def _limited(self) -> Effort:
        """Return a context for the work of diagrams at one question."""
        return limited(inf if self.limited else (STEPS - self._steps) / PART)

    def _counted(self, progress: Progress) -> Counted:
        """Return the number of reachable states, or why it is not known."""
        try:
            with self._limited():
                return self.examination.counted(progress)
        except OutOfSteps as reason:
            return Counted(None, str(reason))

    def _believed(self, number: int, finding: Finding) -> bool:
        """Return whether a finding of decision diagrams is right even if their loop has too many runs."""
        if finding.verdict == "unknown" or finding.method == TABLES or is_contradiction(finding.message):
            return True
        return believed(self._claim(number), finding.verdict, finding.trace is not None or finding.method == WITNESS)

    def _begin(self, question: Question, progress: Progress) -> float:
        """Report the question as progress, unless something was reported a moment ago, and return the time."""
        now = perf_counter()
        if now - self._told > SHOWN:
            self._told = now
            progress(f"{question.check} {question.subject}")
        return now

    def _timed(self, check: Check, finding: Finding, started: float) -> Finding:
        """Return the finding with its trace confirmed, and the seconds since `started`."""
        return replace(self.examination.confirmed(check, finding), seconds=perf_counter() - started)

    def _claim(self, number: int) -> Claim:
        check, question = self.questions[number]
        return self.examination.claim(check, question.subject)
