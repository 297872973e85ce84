"""A time limit, by a signal, for searches that do not look at the clock themselves."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from math import inf
from time import process_time
from types import FrameType

AGAIN = 1.0
"""The seconds after which `Late` is raised again, in case something has caught it."""


class Late(Exception):
    """The time is over."""


@contextmanager
def bounded(deadline: float) -> Iterator[None]:
    """Raise `Late` in the body, between two instructions, once the processor time of the process is `deadline`.

    What the body was changing may be half done. Without such signals, or in another thread, nothing is interrupted.
    """
    usable = hasattr(signal, "ITIMER_PROF") and threading.current_thread() is threading.main_thread()
    if deadline == inf or not usable:
        yield
        return
    before = signal.signal(signal.SIGPROF, _late)
    try:
        signal.setitimer(signal.ITIMER_PROF, max(deadline - process_time(), 1e-6), AGAIN)
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def _late(number: int, frame: FrameType | None) -> None:
    raise Late
