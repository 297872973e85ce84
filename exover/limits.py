"""Limits of a command: time, number of processes, memory of each."""

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from time import monotonic
from traceback import clear_frames
from types import FrameType

from exover.dataclass import dataclass
from exover.raised import is_raised

AGAIN = 0.05
"""Seconds after which an alarm is repeated: an exception raised by one may be lost, in a finalizer for instance."""

INTERRUPTED = "interrupted"
"""The reason of questions without an answer after the user has pressed Ctrl-C."""


NO_MEMORY = "not enough memory"
"""The reason of questions without an answer where the system gives no more memory."""


class TimeUp(Exception):
    """The time limit of a command is reached."""


@dataclass(frozen=True, slots=True)
class Limits:
    """At most `jobs` worker processes; `seconds` in all, until `deadline` on the clock of `monotonic`.

    `memory`: MiB that each worker may take. If `jobs` is 0, this process answers itself, without limits.
    """

    jobs: int = 0
    seconds: float | None = None
    deadline: float = float("inf")
    memory: int | None = None

    @property
    def reason(self) -> str:
        """The reason of questions without an answer when the time is over; empty if time is not limited."""
        return "" if self.seconds is None else f"time limit of {self.seconds:g} s"

    @property
    def no_memory(self) -> str:
        """The reason of questions whose worker needed more memory; empty if memory is not limited."""
        return "" if self.memory is None else f"memory limit of {self.memory} MiB"

    @property
    def left(self) -> float:
        """The seconds that are left, negative when the time is over."""
        return self.deadline - monotonic()


NO_LIMITS = Limits()


def limits_from(started: float, jobs: int, seconds: float | None, memory: int | None = None) -> Limits:
    """Return the limits of a command that `started` at this time on the clock of `monotonic`."""
    return Limits(jobs, seconds, float("inf") if seconds is None else started + seconds, memory)


@contextmanager
def interrupted(limits: Limits) -> Iterator[None]:
    """Raise `TimeUp` in the body when the time is over, as soon as the interpreter is between two instructions.

    So a long call of C code is not ended. Without alarm signals (Windows) nothing is interrupted. Exceptions of
    finalizers are not reported once the time is over.
    """
    if limits.seconds is None or not hasattr(signal, "setitimer"):
        yield
        return
    over, tell = False, sys.unraisablehook

    def ring(number: int, frame: FrameType | None) -> None:
        nonlocal over
        over = True
        raise TimeUp

    def tell_in_time(error: "sys.UnraisableHookArgs") -> None:
        if not over:
            tell(error)

    before = signal.signal(signal.SIGALRM, ring)
    sys.unraisablehook = tell_in_time
    try:
        signal.setitimer(signal.ITIMER_REAL, max(limits.left, 1e-6), AGAIN)
        yield
    except Exception as error:
        signal.setitimer(signal.ITIMER_REAL, 0)
        if not over or not is_raised(TimeUp, error):
            raise
        clear_frames(error.__traceback__)
        raise TimeUp from None
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
        sys.unraisablehook = tell
