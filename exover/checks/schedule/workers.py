"""Worker processes that answer the questions of an agenda, and are halted or killed when their time is over.

A decision diagram is built in C code that no signal handler and no thread interrupts, but a process can be halted and
killed. A worker answers one question after the other and keeps what it has learnt. If it exceeds its time while other
questions are ready, it is halted, and continued when its question is asked again; if more than `HALTED` are halted, the
one that was halted first is ended. A worker that is asked many questions together is not halted as long as another
worker is free for the other questions. Processes are forked where possible, so that no data need be sent to them.
"""

import os
import signal
import sys
from collections.abc import Callable
from contextlib import redirect_stdout, suppress
from dataclasses import field
from math import inf
from multiprocessing import Pipe, get_all_start_methods, get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from threading import Lock, get_ident
from time import monotonic
from typing import Any, Generic, TextIO, TypeVar, cast

from exover.checks.schedule.agenda import Agenda, Turn
from exover.checks.schedule.serving import Work, is_memory, serve
from exover.dataclass import dataclass
from exover.ending import ENDING
from exover.engines.process import uninterrupted
from exover.engines.scratch import Scratch
from exover.limits import NO_MEMORY, Limits
from exover.loop.claim import Progress

GRACE = 1.0
"""Seconds that a worker may take to end once it has closed its channel."""
HALTED = 4
"""The greatest number of halted workers: each keeps its memory."""
PULSE = 0.5
"""Seconds between two calls of `pulse`, at most."""
GAVE_UP = "the engine gave up"
"""The reason if a worker ended its turn before the time was over, and left the question without an answer."""
NO_TURN = Turn(())
ALONE = Lock()
"""Held by the thread that answers in this process: Z3 is for one thread at a time, and there is one standard output."""

T = TypeVar("T")


class WorkerFault(RuntimeError):
    """An exception in a worker process: a fault of exover; the message says what it is, the note is its traceback."""


@dataclass(frozen=True, slots=True)
class Lost:
    """The reason why a question has no answer."""

    reason: str


Take = Callable[[int, T | Lost], bool]
"""Receives the answer to a question, or why there is none, and returns whether the question was asked in vain."""


def nothing() -> None:
    """Do nothing: the default of `pulse`."""


def alone(work: Work[T], agenda: Agenda, progress: Progress, take: Take[T]) -> None:
    """Answer all questions of the agenda in this process, one turn after the other and without limits.

    Output of libraries is discarded meanwhile, since standard output is for the report; what other threads print is
    printed. Another thread that wants answers waits until these are there.
    """
    with ALONE, redirect_stdout(cast("TextIO", _OthersOutput(sys.stdout))):
        _in_turn(work, agenda, progress, take)


class _OthersOutput:
    """Standard output, if there is one, without what is written by the thread that makes this."""

    def __init__(self, out: TextIO | None) -> None:
        self._out = out
        self._unheard = get_ident()

    def write(self, text: str) -> int:
        """Write a text of another thread, and return its length."""
        return len(text) if self._out is None or get_ident() == self._unheard else self._out.write(text)

    def flush(self) -> None:
        """Flush standard output."""
        if self._out is not None:
            self._out.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._out, name)


def _in_turn(work: Work[T], agenda: Agenda, progress: Progress, take: Take[T]) -> None:
    while (turn := agenda.next(inf)) is not None:
        left = set(turn.numbers)

        def say(number: int, answer: T, left: set[int] = left) -> None:
            left.discard(number)
            agenda.answered(number, take(number, answer))

        lost, reason = left, GAVE_UP
        try:
            work(turn, say, progress)
        except Exception as error:
            if not is_memory(error):
                raise
            lost, reason = set(turn.lost(left)), NO_MEMORY
        agenda.again(sorted(left - lost))
        for number in sorted(lost):
            agenda.answered(number, take(number, Lost(reason)))


def spread(
    work: Work[T],
    agenda: Agenda,
    limits: Limits,
    progress: Progress,
    take: Take[T],
    pulse: Callable[[], None] = nothing,
) -> None:
    """Answer the questions of the agenda by worker processes within the limits, and pass each answer to `take`.

    Questions that are still open when the time is over are not passed to `take`. `pulse` is called every `PULSE`
    seconds or more often. When this returns or raises, no worker is left. Raises `WorkerFault` if `work` raises
    anything but that there is no memory.
    """
    with _Pool(work, agenda, limits, progress, take) as pool:
        while pool.busy() and limits.left > 0:
            pool.listen()
            pulse()


@dataclass(eq=False)
class _Worker:
    """A worker process and its channel, its turn (`NO_TURN` if idle), and the questions of the turn still open."""

    process: BaseProcess
    channel: "Connection[object, Any]"
    turn: Turn = NO_TURN
    left: set[int] = field(default_factory=set)
    since: float = 0.0
    until: float = 0.0
    """The deadline of its next answer, on the clock of `monotonic`."""
    last: float = 0.0
    """The deadline of its whole turn, unless it keeps its place."""

    def begin(self, turn: Turn) -> None:
        """Record that it is asked the questions of a turn, for the first time or again."""
        self.turn, self.left, self.since = turn, set(turn.numbers), monotonic()
        self.last = self.since + turn.most
        self.extend()

    def extend(self) -> None:
        """Move the deadline of the next answer to one slice from now."""
        self.until = monotonic() + self.turn.seconds

    def signal(self, number: int) -> None:
        """Send it a signal: `SIGSTOP` halts it, `SIGCONT` continues it."""
        with suppress(ProcessLookupError):
            os.kill(self.process.pid or 0, number)


class _Pool(Generic[T]):
    """At most `limits.jobs` workers that run, and some that are halted; a context at whose end all are killed."""

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
        """Give idle workers a turn, start workers while there are turns and jobs left; return whether any works."""
        idle = [worker for worker in self._workers if not worker.turn.numbers]
        running = len(self._workers) - len(idle)
        while running < self._limits.jobs and (turn := self._agenda.next(self._limits.left)) is not None:
            running += 1
            if self._resumed(turn):
                continue
            worker = idle.pop() if idle else self._start()
            worker.begin(turn)
            with suppress(OSError):  # the worker has ended, which `listen` finds out
                worker.channel.send(turn)
        return running > 0

    def _resumed(self, turn: Turn) -> bool:
        """Continue the worker that was halted at the questions of the turn; return whether there is one."""
        worker = next((worker for worker in self._halted if worker.left.issuperset(turn.numbers)), None)
        if worker is None:
            return False
        self._halted.remove(worker)
        self._workers.append(worker)
        worker.begin(turn)
        worker.signal(signal.SIGCONT)
        return True

    def _put_off(self, worker: _Worker) -> None:
        """Put off the questions of a worker and halt it, or end it where the system cannot halt a process.

        If too many are halted then, end the one halted first, if possible one whose turn is not asked together.
        """
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

    # ---- messages of workers ----

    def listen(self) -> None:
        """Wait for messages, ends and deadlines of workers, at most `PULSE` seconds, and handle them."""
        first = min(self._until(worker) for worker in self._workers if worker.turn.numbers)
        seconds = max(min(first, self._limits.deadline) - monotonic(), 0)
        heard = wait([worker.channel for worker in self._workers], min(seconds, PULSE))
        for worker in list(self._workers):
            if worker not in self._workers:  # dismissed: another worker has just answered its questions
                continue
            if worker.channel in heard:
                self._hear(worker)
            elif worker.turn.numbers and self._until(worker) <= monotonic():
                self._too_slow(worker)

    def _until(self, worker: _Worker) -> float:
        """Return the deadline of a worker: of its next answer and, unless it keeps its place, of its whole turn."""
        return worker.until if self._keeps_place(worker) else min(worker.until, worker.last)

    def _too_slow(self, worker: _Worker) -> None:
        """Make the stand-ins of its questions ready; halt the worker if a question is ready and it keeps no place.

        Otherwise extend its deadlines. A worker that has answered everything and does not end its turn is dismissed.
        """
        self._agenda.call(worker.left)
        if not worker.left:  # it has said all that was asked, and does not come to an end
            self._dismiss(worker)
        elif self._agenda.waits and not self._keeps_place(worker):
            self._put_off(worker)
        else:
            worker.last = monotonic() + worker.turn.most
            worker.extend()

    def _keeps_place(self, worker: _Worker) -> bool:
        """Return whether a worker is not halted for others: asked together, and not all `jobs` workers are."""
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
                worker.process.join(GRACE)  # the channel closes before the exit status is known
                status = worker.process.exitcode
                self._dismiss(worker)
                self._note_end(worker, ended(status, self._limits.no_memory))

    def _take(self, number: int, answer: T | Lost) -> None:
        if number in self._agenda.over:  # another worker was quicker
            return
        over = self._agenda.answered(number, self._give(number, answer))
        for worker in [worker for worker in self._workers + self._halted if not worker.left.isdisjoint(over)]:
            worker.left.difference_update(over)
            if not worker.left:  # all its questions are answered by others
                self._dismiss(worker)

    def _finish(self, worker: _Worker) -> None:
        """Record that a worker has ended its turn, which may leave questions open.

        Put them off if time is limited, they were not asked together, and the turn took over half of its slice; else
        give them up (`GAVE_UP`).
        """
        limited = self._limits.seconds is not None and not worker.turn.together
        if limited and monotonic() - worker.since > worker.turn.seconds / 2:
            self._agenda.late(worker.left)
        else:
            self._lose(worker, GAVE_UP)
        worker.turn, worker.left = NO_TURN, set()

    def _note_end(self, worker: _Worker, reason: str) -> None:
        """Record that a worker has ended; open questions that are not lost with it (`Turn.lost`) are asked again."""
        lost = set(worker.turn.lost(worker.left))
        self._agenda.again(sorted(worker.left - lost))
        worker.left = lost
        self._lose(worker, reason)

    def _lose(self, worker: _Worker, reason: str) -> None:
        left, worker.left = sorted(worker.left), set()
        for number in left:
            self._take(number, Lost(reason))

    # ---- processes ----

    def _start(self) -> _Worker:
        """Start a worker and return it; it is niced if another one is asked questions together."""
        ours, theirs = Pipe()
        behind = any(worker.turn.together for worker in self._workers)
        asked = (theirs, os.getpid(), self._work, self._limits.memory, behind, self._scratch.folder)
        process = process_of(serve, asked, daemon=True)
        worker = _Worker(process, ours)
        with uninterrupted(signal.SIGINT):
            process.start()
            self._workers.append(worker)
        theirs.close()  # else the channel would stay open after the worker has ended
        return worker

    def _dismiss(self, worker: _Worker) -> None:
        (self._workers if worker in self._workers else self._halted).remove(worker)
        _end(worker)


def _end(worker: _Worker) -> None:
    worker.process.kill()
    worker.process.join()
    worker.channel.close()


def process_of(target: Callable[..., None], args: tuple[object, ...], daemon: bool) -> BaseProcess:
    """Return a process that is not started yet, forked where possible, else spawned; a daemon starts none itself."""
    if "fork" in get_all_start_methods():
        return get_context("fork").Process(target=target, args=args, daemon=daemon)
    return get_context("spawn").Process(target=target, args=args, daemon=daemon)


def ended(status: int | None, no_memory: str = "") -> str:
    """Return why a process ended by itself, given its exit status (negative: a signal).

    With a memory limit, its reason `no_memory` comes first: libraries abort when they get no memory.
    """
    if status is None or status >= 0:
        how = f"its process ended with status {status}"
    else:
        how = f"its process was ended by {signal.Signals(-status).name}"
    if no_memory:
        return f"{no_memory}: {how}"
    return how + ", perhaps for want of memory" * (status == -9)
