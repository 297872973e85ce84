"""A side task that runs in a forked process beside its caller, or in the caller's own where that is not possible."""

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
"""Passes messages to `Say`. They are its only effect: what it changes in memory may be that of another process."""
DONE, SAID = "done", "said"
_apart = False
"""Whether this process is one that `Beside` has forked."""


class Beside(Generic[M]):
    """A side task that runs while the body of this context does other work; `hear` waits for its end.

    `apart`: in a process of its own, if the system can fork one, which is killed when this context or the caller's
    process ends. If that process fails or cannot be had, `hear` does the work in the caller's process. The temporary
    files of the process are in a folder that is removed with it.
    """

    def __init__(self, work: SideTask[M], apart: bool) -> None:
        self._work, self._apart = work, apart and hasattr(os, "fork")
        self._said: SimpleQueue[tuple[str, Any]] = SimpleQueue()
        self._end: tuple[str, Any] | None = None
        self._held = ExitStack()
        self._scratch = Scratch()
        self.arrived = Event()
        """Set when its process has sent a message, or ended."""

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
        """Start the process, and return the stack that ends it; raises `OSError` or `RuntimeError`, leaving nothing."""
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
        """Pass all further messages to `take`, and return when the work is done.

        If its process has failed, do the work here, all over again.
        """
        while self._apart:
            kind, message = self._end or self._said.get()
            if kind == DONE:
                return
            if kind != SAID:
                break
            take(message)
        self._work(take)

    def overhear(self, take: Say[M]) -> bool:
        """Pass the messages that have arrived to `take`; return whether no process sends more. `hear` is still due."""
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
"""A side task, and the function that takes its messages."""


def hear_all(works: Sequence[Heard], others: Sequence[Heard] = ()) -> None:
    """Pass on the messages of `works` as they arrive until all are done, and those of `others` arriving meanwhile."""
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
    """Lower the priority of this process if it is one that `Beside` has forked, so that its parent runs first."""
    if _apart:
        step_back()


def _serve(work: SideTask[Any], channel: Any, parent: int) -> None:
    """Do the work in this process, send its messages to the parent, and exit."""
    global _apart  # noqa: PLW0603  # of a process that does nothing else
    _apart = True
    try:
        if die_with(parent):
            work(lambda message: channel.send((SAID, message)))
            channel.send((DONE, None))
    finally:
        os._exit(0)


def _end_process(child: int, reader: Thread) -> None:
    """Kill a process, and wait for the thread that reads its messages."""
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    if reader.is_alive():
        reader.join()


def _read(channel: Any, put: Callable[[tuple[str, Any]], None]) -> None:
    """Pass messages from the channel to `put` until it closes or fails, then a mark of the end."""
    with channel:
        try:
            while True:
                put(channel.recv())
        except (EOFError, OSError, pickle.UnpicklingError):
            put(("", None))
