"""Work spread over processes that end when their time is over, whatever they are doing.

A decision diagram is built in C code that no signal handler and no thread interrupts; a process can be killed. A
process answers one question after the other and keeps what it has learnt; if one takes too long, or ends its process,
the next is asked of a new one. Processes are forked where the system can, so that nothing has to be sent to them.
"""

import os
import signal
import sys
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from math import inf
from multiprocessing import Pipe, get_all_start_methods, get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from time import monotonic
from types import TracebackType
from typing import Any, Generic, TypeVar

from exover.checks.agenda import Agenda
from exover.checks.limits import Limits

PR_SET_PDEATHSIG = 1
"""Of `prctl` in Linux: the signal that a process gets when its parent ends."""
LOOK = 1.0
"""Seconds after which an idle process looks whether its parent is still there."""
GRACE = 1.0
"""Seconds that a process may take to end once it has closed its way to us."""
NOT_ASKED = "another answered for it"

T = TypeVar("T")
Progress = Callable[[str], None]
Work = Callable[[int, Progress], T]
"""Answers the question of a number, and tells what it is doing."""


class WorkerFault(RuntimeError):
    """Something was raised in a process: a fault of exover's own; the message and the notes tell what and where."""


@dataclass(frozen=True, slots=True)
class Lost:
    """A question without an answer, and why."""

    reason: str


def _is_lost(answer: object) -> bool:
    return isinstance(answer, Lost)


def spread(
    work: Work[T], agenda: Agenda, limits: Limits, progress: Progress, vain: "Callable[[T | Lost], bool]" = _is_lost
) -> list[T | Lost]:
    """Return the answer to each question of the agenda, or why there is none, within the limits.

    An answer that is `vain` is none to the agenda. When it returns or raises, no process is left. Raises `WorkerFault`
    if `work` raises anything but `MemoryError`.
    """
    with _Crew(work, agenda, limits, progress, vain) as crew:
        while crew.busy() and limits.left > 0:
            crew.listen()
    missing = Lost(NOT_ASKED if limits.seconds is None else limits.reason)
    return [crew.answers.get(number, missing) for number in range(len(agenda.checks))]


@dataclass(eq=False)
class _Worker:
    """A process, the way to it, the question that it was asked, if it is, and until when it may take."""

    process: BaseProcess
    channel: "Connection[int, Any]"
    number: int | None = None
    until: float = 0.0


class _Crew(Generic[T]):
    """At most `limits.jobs` processes at work on an agenda; a context that they do not outlive."""

    def __init__(
        self,
        work: Work[T],
        agenda: Agenda,
        limits: Limits,
        progress: Progress,
        vain: "Callable[[T | Lost], bool]",
    ) -> None:
        self.answers: dict[int, T | Lost] = {}
        self._work, self._agenda, self._limits, self._progress = work, agenda, limits, progress
        self._vain = vain
        self._workers: list[_Worker] = []

    def __enter__(self) -> "_Crew[T]":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for worker in self._workers:
            worker.process.kill()
        for worker in list(self._workers):
            self._dismiss(worker)

    def busy(self) -> bool:
        """Give every idle process a question, start those that are missing, and return whether any is at work."""
        idle = [worker for worker in self._workers if worker.number is None]
        while idle or len(self._workers) < self._limits.jobs:
            task = self._agenda.next(self._limits.left)
            if task is None:
                break
            worker = idle.pop() if idle else self._start()
            worker.number, worker.until = task[0], monotonic() + task[1]
            with suppress(OSError):  # it has ended, which will be heard
                worker.channel.send(task[0])
        return any(worker.number is not None for worker in self._workers)

    def listen(self) -> None:
        """Wait until a process says something, ends, or has used up its time."""
        first = min(worker.until for worker in self._workers if worker.number is not None)
        heard = wait(
            [worker.channel for worker in self._workers], None if first == inf else max(first - monotonic(), 0)
        )
        for worker in list(self._workers):
            if worker.channel in heard:
                self._hear(worker)
            elif worker.number is not None and worker.until <= monotonic():
                self._agenda.late(worker.number)
                self._dismiss(worker)
        for worker in list(self._workers):
            if worker.number in self._agenda.over:  # another has the answer
                self._dismiss(worker)

    def _hear(self, worker: _Worker) -> None:
        try:
            message = worker.channel.recv()
        except (EOFError, OSError):
            message = ("end",)
        match message:
            case ("progress", text):
                self._progress(text)
            case ("answer", answer):
                self._take(worker, answer)
            case ("memory",):
                self._take(worker, Lost("not enough memory"))
                self._dismiss(worker)
            case ("fault", text, where):
                fault = WorkerFault(text)
                fault.add_note(where)
                raise fault
            case _:
                worker.process.join(GRACE)  # its end is heard before its status is there
                status = worker.process.exitcode
                self._dismiss(worker)
                self._take(worker, Lost(_ended(status)))

    def _take(self, worker: _Worker, answer: T | Lost) -> None:
        if worker.number is not None:
            self.answers[worker.number] = answer
            self._agenda.answered(worker.number, self._vain(answer))
        worker.number = None

    def _start(self) -> _Worker:
        ours, theirs = Pipe()
        process = _process(_serve, (theirs, os.getpid(), self._work))
        process.start()
        theirs.close()  # else its end would not be heard, by us or by processes that start later
        worker = _Worker(process, ours)
        self._workers.append(worker)
        return worker

    def _dismiss(self, worker: _Worker) -> None:
        self._workers.remove(worker)
        worker.process.kill()
        worker.process.join()
        worker.channel.close()


def _process(target: Callable[..., None], args: tuple[object, ...]) -> BaseProcess:
    if "fork" in get_all_start_methods():
        return get_context("fork").Process(target=target, args=args, daemon=True)
    return get_context("spawn").Process(target=target, args=args, daemon=True)


def _ended(status: int | None) -> str:
    if status is None or status >= 0:
        return f"its process ended with status {status}"
    return f"its process was ended by {signal.Signals(-status).name}" + (
        ", perhaps for want of memory" * (status == -9)
    )


# ---- in the process ----


def _serve(channel: "Connection[object, int]", parent: int, work: Work[object]) -> None:
    """Answer questions until the parent has no more, or is no more."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # it ended before
            return

    def progress(text: str) -> None:
        channel.send(("progress", text))

    with _Report(channel):
        while True:
            while not channel.poll(LOOK):
                if os.getppid() != parent:
                    return
            channel.send(("answer", work(channel.recv(), progress)))


@dataclass(frozen=True, slots=True)
class _Report:
    """A context that tells the parent of whatever is raised in it, and lets nothing pass."""

    channel: "Connection[object, int]"

    def __enter__(self) -> None:
        """Begin."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool:
        match error:
            case None | EOFError() | ConnectionError():  # the parent has ended, or wants no more
                pass
            case MemoryError():
                self.channel.send(("memory",))
            case _:
                where = "".join(traceback.format_exception(error))
                self.channel.send(("fault", f"{type(error).__name__}: {error}", where))
        return True
