"""The process that answers questions: it is asked through a channel, and says there what comes of it."""

import os
import signal
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
from exover.engines.process import die_with, step_back
from exover.engines.scratch import files_in
from exover.loop.claim import Progress

LOOK = 1.0
"""Seconds after which an idle process looks whether its parent is still there."""

T = TypeVar("T")
Say = Callable[[int, T], None]
Work = Callable[[Turn, Say[T], Progress], None]
"""Answers the questions of a turn, says each answer as it falls, and tells what it is doing.

It may leave out what it would need more time for. The answer of a turn of one question is heard when the work returns.
"""


def serve(
    channel: "Connection[object, Any]", parent: int, work: Work[object], memory: int | None, behind: bool, scratch: str
) -> None:
    """Answer questions until the parent has no more, or is no more.

    `behind`: as far as others leave processors; `scratch`: the folder of its temporary files.
    """
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if not die_with(parent):
        return
    files_in(scratch)
    if behind:
        step_back()
    _say_nothing()
    _restrict(memory)

    def progress(text: str) -> None:
        channel.send(("progress", text))

    def say(number: int, answer: object) -> None:
        channel.send(("answer", number, answer))

    with _Report(channel, memory is not None):
        while True:
            while not channel.poll(LOOK):
                if os.getppid() != parent:
                    return
            turn: Turn = channel.recv()
            last: list[tuple[int, object]] = []
            work(turn, say if turn.together else partial(_keep, last), progress)
            channel.send(("done", last))


def _keep(said: list[tuple[int, object]], number: int, answer: object) -> None:
    """Note the answer of a turn of one question: it is sent with the word that the turn is done."""
    said.append((number, answer))


def _say_nothing() -> None:
    """Let nothing out that a library prints in this process, in Python or in C: standard output is for the report.

    Nor does it go to standard error. Z3, for one, advises how to install it wherever there is not enough memory to load
    it; whatever goes wrong is raised as well, and told.
    """
    if sys.__stdout__ is None:  # it was closed: its number may be that of the channel
        return
    nowhere = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115  # as long as the process lives
    os.dup2(nowhere.fileno(), sys.__stdout__.fileno())
    sys.stdout = nowhere


def _restrict(memory: int | None) -> None:
    """Let this process, and those that it starts, take so many MiB, where the system can see to that."""
    if memory is not None and sys.platform == "linux":
        import resource

        _, most = resource.getrlimit(resource.RLIMIT_AS)
        least = memory << 20 if most == resource.RLIM_INFINITY else min(memory << 20, most)
        resource.setrlimit(resource.RLIMIT_AS, (least, most))
        resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))


def is_memory(error: BaseException, limited: bool = False) -> bool:
    """Return whether it says that there is no memory; Z3 has an exception of its own for that, with these words.

    If it is `limited`, libraries may not even be loaded, Z3 fails in many ways, and where none is left anything may be
    raised.
    """
    of_z3 = type(error).__name__ == "Z3Exception"
    if limited and (of_z3 or isinstance(error, ImportError | OSError) or not _is_some_left()):
        return True
    return isinstance(error, MemoryError) or (of_z3 and "out of memory" in str(error))


def _is_some_left() -> bool:
    """Return whether this process may take one MiB more."""
    try:
        mmap(-1, 1 << 20).close()
    except (OSError, MemoryError):
        return False
    return True


@dataclass(frozen=True, slots=True)
class _Report:
    """A context that tells the parent of whatever is raised in it, and lets nothing pass."""

    channel: "Connection[object, Any]"
    limited: bool
    """Memory is."""

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
