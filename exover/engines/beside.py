"""Work beside ours: in a process of its own where there is a processor for it, else in turn."""

import os
import pickle
import signal
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from multiprocessing import Pipe
from queue import SimpleQueue
from threading import Event, Thread
from typing import Any, Generic, TypeVar

from exover.engines.process import die_with, step_back
from exover.engines.scratch import Scratch, files_in

M = TypeVar("M")
Say = Callable[[M], None]
SideTask = Callable[[Say[M]], None]
"""Says what it finds. Nothing but that comes of it: what it changes may be changed in another process."""
DONE, SAID = "done", "said"
_apart = False
"""Whether this process does work beside another's."""


class Beside(Generic[M]):
    """Work that goes on while the body of this context does other work; its end is heard by `hear`.

    `apart`: in a process of its own, where the system can fork one, which ends with ours however that is. If that
    process fails, or none can be had, the work is done in this one. Its temporary files are in a folder that is gone
    when it is.
    """

    def __init__(self, work: SideTask[M], apart: bool) -> None:
        self._work, self._apart = work, apart and hasattr(os, "fork")
        self._said: SimpleQueue[tuple[str, Any]] = SimpleQueue()
        self._end: tuple[str, Any] | None = None
        self._held = ExitStack()
        self._scratch = Scratch()
        self.arrived = Event()
        """Set when its process has said something, or ended."""

    def __enter__(self) -> "Beside[M]":
        if self._apart:
            try:
                self._held = self._begin()
            except (OSError, RuntimeError):  # the system has no process, pipe or thread left
                self._apart = False
        return self

    def __exit__(self, *error: object) -> None:
        self._held.close()

    def _begin(self) -> ExitStack:
        """Let a process begin, and return what ends it; raises `OSError` or `RuntimeError`, and leaves nothing then."""
        parent = os.getpid()
        with ExitStack() as begun:
            begun.enter_context(self._scratch)
            ours, theirs = Pipe(duplex=False)
            begun.callback(ours.close)
            self._reader = Thread(target=_read, args=(ours, self._put), daemon=True)
            with theirs:
                child = os.fork()
                if child == 0:
                    files_in(self._scratch.folder)
                    _serve(self._work, theirs, parent)
            begun.callback(_end_process, child, self._reader)
            self._reader.start()
            return begun.pop_all()

    def hear(self, take: Say[M]) -> None:
        """Take all that the work says, and return when it is done."""
        while self._apart:
            kind, message = self._end or self._said.get()
            if kind == DONE:
                return
            if kind != SAID:
                break
            take(message)
        self._work(take)

    def overhear(self, take: Say[M]) -> bool:
        """Take what the work has said by now, and return whether no process says more; the rest is to be heard."""
        while self._end is None and not self._said.empty():
            kind, message = self._said.get()
            if kind != SAID:
                self._end = kind, message
                break
            take(message)
        return self._end is not None or not self._apart

    def _put(self, said: tuple[str, Any]) -> None:
        self._said.put(said)
        self.arrived.set()


Heard = tuple[Beside[Any], Say[Any]]
"""Work beside ours, and what takes what it says."""


def hear_all(works: Sequence[Heard], others: Sequence[Heard] = ()) -> None:
    """Take what works say, as they say it, and return when all are done; of others take what they say meanwhile."""
    arrived = Event()
    for work, _ in (*works, *others):
        work.arrived = arrived
    while True:
        arrived.clear()
        for work, take in others:
            work.overhear(take)
        ended = [work.overhear(take) for work, take in works]
        if all(ended):
            break
        arrived.wait()
    for work, take in works:
        work.hear(take)


def step_back_if_apart() -> None:
    """Let the body go first from now on, if it is work beside one that calls this, in a process of its own."""
    if _apart:
        step_back()


def _serve(work: SideTask[Any], channel: Any, parent: int) -> None:
    """Do work in this process, which ends here; what it says goes to the parent."""
    global _apart  # noqa: PLW0603  # of a process that does nothing else
    _apart = True
    try:
        if die_with(parent):
            work(lambda message: channel.send((SAID, message)))
            channel.send((DONE, None))
    finally:
        os._exit(0)


def _end_process(child: int, reader: Thread) -> None:
    """End a process, and wait for whoever reads what it says."""
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    if reader.is_alive():
        reader.join()


def _read(channel: Any, put: Callable[[tuple[str, Any]], None]) -> None:
    """Read what is said until nothing more can be."""
    with channel:
        try:
            while True:
                put(channel.recv())
        except (EOFError, OSError, pickle.UnpicklingError):
            put(("", None))
