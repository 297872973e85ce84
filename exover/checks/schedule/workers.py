"""Work spread over processes that end when their time is over, whatever they are doing.

A decision diagram is built in C code that no signal handler and no thread interrupts; a process can be halted and
killed. A process answers one question after the other and keeps what it has learnt. If it takes too long while others
wait, it is halted, and goes on where it was when its question is asked again; only if too many are halted, the first of
them is ended. One that is asked many questions together keeps its place as long as there is another for those who
wait. Processes are forked where the system can, so that nothing has to be sent to them.
"""

import os
import signal
from collections.abc import Callable
from contextlib import redirect_stdout, suppress
from dataclasses import field
from math import inf
from multiprocessing import Pipe, get_all_start_methods, get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from time import monotonic
from typing import Any, Generic, TypeVar

from exover.checks.schedule.agenda import Agenda, Turn
from exover.checks.schedule.limits import Limits
from exover.checks.schedule.serving import Work, is_memory, serve
from exover.dataclass import dataclass
from exover.engines.process import ENDING, uninterrupted
from exover.engines.scratch import Scratch
from exover.loop.claim import Progress

GRACE = 1.0
"""Seconds that a process may take to end once it has closed its way to us."""
HALTED = 4
"""Processes that may be halted: each keeps its memory."""
PULSE = 0.5
"""Seconds after which the command shows that it is alive."""
GAVE_UP = "the engine gave up"
"""Why a question has no answer whose process went on to others without one, before its time was over."""
NO_MEMORY = "not enough memory"
NO_TURN = Turn(())

T = TypeVar("T")


class WorkerFault(RuntimeError):
    """Something was raised in a process: a fault of exover's own; the message and the notes tell what and where."""


@dataclass(frozen=True, slots=True)
class Lost:
    """A question without an answer, and why."""

    reason: str


Take = Callable[[int, T | Lost], bool]
"""Takes the answer to a question, or why there is none, and returns whether it was asked in vain."""


def nothing() -> None:
    """Show nobody that the command is alive."""


def alone(work: Work[T], agenda: Agenda, progress: Progress, take: Take[T]) -> None:
    """Have all questions of the agenda answered, one turn after the other, in this process and without limits.

    What a library prints meanwhile is not let out: standard output is for the report.
    """
    with open(os.devnull, "w", encoding="utf-8") as nowhere, redirect_stdout(nowhere):
        _in_turn(work, agenda, progress, take)


def _in_turn(work: Work[T], agenda: Agenda, progress: Progress, take: Take[T]) -> None:
    while (turn := agenda.next(inf)) is not None:
        left = set(turn.numbers)

        def say(number: int, answer: T, left: set[int] = left) -> None:
            left.discard(number)
            agenda.answered(number, take(number, answer))

        reason = GAVE_UP
        try:
            work(turn, say, progress)
        except Exception as error:
            if not is_memory(error):
                raise
            reason = NO_MEMORY
        for number in sorted(left):
            agenda.answered(number, take(number, Lost(reason)))


def spread(
    work: Work[T],
    agenda: Agenda,
    limits: Limits,
    progress: Progress,
    take: Take[T],
    pulse: Callable[[], None] = nothing,
) -> None:
    """Have the questions of the agenda answered within the limits; what is not `taken` then has no answer.

    `pulse` is called now and then. When it returns or raises, no process is left. Raises `WorkerFault` if `work` raises
    anything but that there is no memory.
    """
    with _Pool(work, agenda, limits, progress, take) as pool:
        while pool.busy() and limits.left > 0:
            pool.listen()
            pulse()


@dataclass(eq=False)
class _Worker:
    """A process, the way to it, its turn if it has one, and what of that is open."""

    process: BaseProcess
    channel: "Connection[object, Any]"
    turn: Turn = NO_TURN
    left: set[int] = field(default_factory=set)
    since: float = 0.0
    until: float = 0.0
    """When the next answer must be there."""
    last: float = 0.0
    """When all of its turn must be answered, unless it keeps its place."""

    def begin(self, turn: Turn) -> None:
        """Note what it is asked, or what it is asked again."""
        self.turn, self.left, self.since = turn, set(turn.numbers), monotonic()
        self.last = self.since + turn.most
        self.extend()

    def extend(self) -> None:
        """Give it the time for one more answer."""
        self.until = monotonic() + self.turn.seconds

    def signal(self, number: int) -> None:
        """Halt it or let it go on, where the system can."""
        with suppress(ProcessLookupError):
            os.kill(self.process.pid or 0, number)


class _Pool(Generic[T]):
    """At most `limits.jobs` processes at work on an agenda; a context that they do not outlive."""

    def __init__(self, work: Work[T], agenda: Agenda, limits: Limits, progress: Progress, take: Take[T]) -> None:
        self._work, self._agenda, self._limits, self._progress = work, agenda, limits, progress
        self._give = take
        self._workers: list[_Worker] = []
        self._halted: list[_Worker] = []
        self._scratch = Scratch()

    def __enter__(self) -> "_Pool[T]":
        self._scratch.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        with uninterrupted(*ENDING):
            for worker in self._workers + self._halted:
                worker.process.kill()
            for worker in self._workers + self._halted:
                _end(worker)
            self._scratch.__exit__(*error)

    # ---- who is asked ----

    def busy(self) -> bool:
        """Give every idle process a turn, start those that are missing, and return whether any is at work."""
        idle = [worker for worker in self._workers if not worker.turn.numbers]
        running = len(self._workers) - len(idle)
        while running < self._limits.jobs and (turn := self._agenda.next(self._limits.left)) is not None:
            running += 1
            if self._resumed(turn):
                continue
            worker = idle.pop() if idle else self._start()
            worker.begin(turn)
            with suppress(OSError):  # it has ended, which will be heard
                worker.channel.send(turn)
        return running > 0

    def _resumed(self, turn: Turn) -> bool:
        """Let the process go on that was halted at these questions; return whether there is one."""
        worker = next((worker for worker in self._halted if worker.left.issuperset(turn.numbers)), None)
        if worker is None:
            return False
        self._halted.remove(worker)
        self._workers.append(worker)
        worker.begin(turn)
        worker.signal(signal.SIGCONT)
        return True

    def _put_off(self, worker: _Worker) -> None:
        """Halt a process whose time is over, or end it where that cannot be."""
        self._agenda.late(worker.left)
        if not hasattr(signal, "SIGSTOP"):
            self._dismiss(worker)
            return
        worker.signal(signal.SIGSTOP)
        self._workers.remove(worker)
        self._halted.append(worker)
        if len(self._halted) > HALTED:
            first = next((each for each in self._halted if not each.turn.together), self._halted[0])
            self._dismiss(first)

    # ---- what they say ----

    def listen(self) -> None:
        """Wait until a process says something, ends, or has used up its time; not for long."""
        first = min(self._until(worker) for worker in self._workers if worker.turn.numbers)
        seconds = max(min(first, self._limits.deadline) - monotonic(), 0)
        heard = wait([worker.channel for worker in self._workers], min(seconds, PULSE))
        for worker in list(self._workers):
            if worker not in self._workers:  # another has just said all that it was asked
                continue
            if worker.channel in heard:
                self._hear(worker)
            elif worker.turn.numbers and self._until(worker) <= monotonic():
                self._too_slow(worker)

    def _until(self, worker: _Worker) -> float:
        """Return when a process is too slow: for one more answer, or for all where it keeps others from its place."""
        return worker.until if self._keeps_place(worker) else min(worker.until, worker.last)

    def _too_slow(self, worker: _Worker) -> None:
        """Let others try what a process is at, and put it off, unless nobody waits for its place or it keeps that."""
        self._agenda.call(worker.left)
        if not worker.left:  # it has said all that was asked, and does not come to an end
            self._dismiss(worker)
        elif self._agenda.waits and not self._keeps_place(worker):
            self._put_off(worker)
        else:
            worker.last = monotonic() + worker.turn.most
            worker.extend()

    def _keeps_place(self, worker: _Worker) -> bool:
        """Return whether others wait for other places: it is asked questions together, and not all processes are."""
        return worker.turn.together and sum(each.turn.together for each in self._workers) < self._limits.jobs

    def _hear(self, worker: _Worker) -> None:
        try:
            message = worker.channel.recv()
        except (EOFError, OSError):
            message = ("end",)
        match message:
            case ("progress", text):
                self._progress(text)
            case ("answer", number, answer):
                worker.extend()
                worker.left.discard(number)
                self._take(number, answer)
            case ("done", said):
                for number, answer in said:
                    worker.left.discard(number)
                    self._take(number, answer)
                self._finish(worker)
            case ("memory",):
                self._dismiss(worker)
                self._note_end(worker, self._limits.no_memory or NO_MEMORY)
            case ("fault", text, where):
                fault = WorkerFault(text)
                fault.add_note(where)
                raise fault
            case _:
                worker.process.join(GRACE)  # its end is heard before its status is there
                status = worker.process.exitcode
                self._dismiss(worker)
                self._note_end(worker, ended(status, self._limits.no_memory))

    def _take(self, number: int, answer: T | Lost) -> None:
        if number in self._agenda.over:  # another was quicker
            return
        over = self._agenda.answered(number, self._give(number, answer))
        for worker in [worker for worker in self._workers + self._halted if not worker.left.isdisjoint(over)]:
            worker.left.difference_update(over)
            if not worker.left:  # another has the answer
                self._dismiss(worker)

    def _finish(self, worker: _Worker) -> None:
        """Note that a process is done with its turn: one question has no answer yet if that has used up its time.

        Else what is not answered is given up.
        """
        limited = self._limits.seconds is not None and not worker.turn.together
        if limited and monotonic() - worker.since > worker.turn.seconds / 2:
            self._agenda.late(worker.left)
        else:
            self._lose(worker, GAVE_UP)
        worker.turn, worker.left = NO_TURN, set()

    def _note_end(self, worker: _Worker, reason: str) -> None:
        """Note that a process has ended: if it had come to answer anything, what it was at is lost, else all."""
        if len(worker.left) < len(worker.turn.numbers):
            self._agenda.again(sorted(worker.left)[1:])
            worker.left = set(sorted(worker.left)[:1])
        self._lose(worker, reason)

    def _lose(self, worker: _Worker, reason: str) -> None:
        left, worker.left = sorted(worker.left), set()
        for number in left:
            self._take(number, Lost(reason))

    # ---- processes ----

    def _start(self) -> _Worker:
        """Return a new process; one beside an engine that is asked all at once, and may start more, comes after it."""
        ours, theirs = Pipe()
        behind = any(worker.turn.together for worker in self._workers)
        asked = (theirs, os.getpid(), self._work, self._limits.memory, behind, self._scratch.folder)
        process = process_of(serve, asked, daemon=True)
        worker = _Worker(process, ours)
        with uninterrupted(signal.SIGINT):
            process.start()
            self._workers.append(worker)
        theirs.close()  # else its end would not be heard, by us or by processes that start later
        return worker

    def _dismiss(self, worker: _Worker) -> None:
        (self._workers if worker in self._workers else self._halted).remove(worker)
        _end(worker)


def _end(worker: _Worker) -> None:
    worker.process.kill()
    worker.process.join()
    worker.channel.close()


def process_of(target: Callable[..., None], args: tuple[object, ...], daemon: bool) -> BaseProcess:
    """Return a process that has not begun, forked where the system can; one that is a daemon starts no other."""
    if "fork" in get_all_start_methods():
        return get_context("fork").Process(target=target, args=args, daemon=daemon)
    return get_context("spawn").Process(target=target, args=args, daemon=daemon)


def ended(status: int | None, no_memory: str = "") -> str:
    """Return why a process ended by itself; with a limit that is most likely it, for libraries abort then."""
    if status is None or status >= 0:
        how = f"its process ended with status {status}"
    else:
        how = f"its process was ended by {signal.Signals(-status).name}"
    if no_memory:
        return f"{no_memory}: {how}"
    return how + ", perhaps for want of memory" * (status == -9)
