"""The worker process: it receives turns through a channel, and sends back answers, progress and failures."""

import os
import sys
import traceback
from collections.abc import Callable
from functools import partial
from mmap import mmap
from multiprocessing.connection import Connection
from types import TracebackType
from typing import Any, TypeVar

from exover.checks.schedule.agenda import Turn
from exover.dataclass import dataclass
from exover.ending import leave_ending_to_parent
from exover.engines.process import die_with, step_back
from exover.engines.scratch import files_in
from exover.loop.claim import Progress
from exover.raised import out_of_memory

LOOK = 1.0
"""Seconds between two looks of an idle worker whether its parent is still there."""
NO_THREAD = "can't start new thread"
"""The text of the RuntimeError that Python raises where there is no room for the stack of a thread."""

T = TypeVar("T")
Say = Callable[[int, T], None]
Work = Callable[[Turn, Say[T], Progress], None]
"""Answers the questions of a turn, passes each answer to `Say` at once, and reports its progress.

It may leave out questions for which it would need more time. Answers of a turn that is not `together` are sent when
the work returns.
"""


def serve(
    channel: "Connection[object, Any]", parent: int, work: Work[object], memory: int | None, behind: bool, scratch: str
) -> None:
    """Answer turns until the parent closes the channel or ends.

    `memory`: its limit in MiB; `behind`: run at a lower priority; `scratch`: the folder of its temporary files.
    """
    leave_ending_to_parent()
    if not die_with(parent):
        return
    files_in(scratch)
    if behind:
        step_back()
    _say_nothing()
    try:
        _restrict(memory)
        _answer_turns(channel, parent, work, memory is not None)
    except MemoryError:  # there is not even enough to say so
        os._exit(1)


def _answer_turns(channel: "Connection[object, Any]", parent: int, work: Work[object], limited: bool) -> None:
    """Answer turns until the parent closes the channel or ends; `limited`: whether memory is."""

    def progress(text: str) -> None:
        channel.send(("progress", text))

    def say(number: int, answer: object) -> None:
        channel.send(("answer", number, answer))

    with _Report(channel, limited):
        while True:
            while not channel.poll(LOOK):
                if os.getppid() != parent:
                    return
            turn: Turn = channel.recv()
            last: list[tuple[int, object]] = []
            work(turn, say if turn.together else partial(_keep, last), progress)
            channel.send(("done", last))


def _keep(said: list[tuple[int, object]], number: int, answer: object) -> None:
    """Keep the answer of a turn of one question: it is sent with the message that the turn is done."""
    said.append((number, answer))


def _say_nothing() -> None:
    """Discard what libraries print to standard output in this process, in Python or in C: it is for the report.

    It is not redirected to standard error either: Z3, for one, prints how to install it if there is not enough memory
    to load it, and every failure is raised and reported as well.
    """
    if sys.__stdout__ is None:  # it was closed: its number may be that of the channel
        return
    nowhere = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115  # as long as the process lives
    os.dup2(nowhere.fileno(), sys.__stdout__.fileno())
    sys.stdout = nowhere


def _restrict(memory: int | None) -> None:
    """Limit the address space of this process, and of those that it starts, to so many MiB (on Linux only)."""
    if memory is not None and sys.platform == "linux":
        import resource

        _, most = resource.getrlimit(resource.RLIMIT_AS)
        least = memory << 20 if most == resource.RLIM_INFINITY else min(memory << 20, most)
        resource.setrlimit(resource.RLIMIT_AS, (least, most))
        resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))


def is_memory(error: BaseException, limited: bool = False) -> bool:
    """Return whether an exception means that there is no memory.

    If memory is `limited`, failed imports, failures of the system, threads that do not start and all exceptions of Z3
    count as well, and any exception if no MiB is left.
    """
    of_z3 = type(error).__name__ == "Z3Exception"
    of_system = isinstance(error, ImportError | OSError) or str(error) == NO_THREAD
    return (limited and (of_z3 or of_system or not _is_some_left())) or out_of_memory(error)


def _is_some_left() -> bool:
    """Return whether this process can allocate one MiB more."""
    try:
        mmap(-1, 1 << 20).close()
    except (OSError, MemoryError):
        return False
    return True


@dataclass(frozen=True, slots=True)
class _Report:
    """A context that sends whatever is raised in it to the parent as a message, and raises nothing."""

    channel: "Connection[object, Any]"
    limited: bool
    """Whether memory is limited."""

    def __enter__(self) -> None:
        """Begin."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool:
        match error:
            case None | EOFError() | ConnectionError():  # the parent has ended, or wants no more
                pass
            case _ if is_memory(error, self.limited):
                self.channel.send(("memory",))
            case _:
                where = "".join(traceback.format_exception(error))
                self.channel.send(("fault", f"{type(error).__name__}: {error}", where))
        return True
