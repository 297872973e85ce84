"""Limits of a command: time, number of processes, memory of each."""

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from mmap import PAGESIZE
from time import monotonic
from traceback import clear_frames
from types import FrameType

from exover.dataclass import dataclass
from exover.raised import is_raised

AGAIN = 0.05
"""Seconds after which an alarm is repeated: an exception raised by one may be lost, in a finalizer for instance; and
those between two looks at the memory that is taken."""

INTERRUPTED = "interrupted"
"""The reason of questions without an answer after the user has pressed Ctrl-C."""


NO_MEMORY = "not enough memory"
"""The reason of questions without an answer where the system gives no more memory."""


class TimeUp(Exception):
    """The time limit of a command is reached."""


class MemoryUp(MemoryError):
    """The memory limit of a command is reached, which the message names."""


def memory_reason(error: BaseException) -> str:
    """Return the reason of what has no answer for an exception that says that there is no memory."""
    return str(error) if isinstance(error, MemoryUp) else NO_MEMORY


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
def interrupted(limits: Limits, of_memory: bool = False) -> Iterator[None]:
    """Raise `TimeUp` in the body when the time is over, as soon as the interpreter is between two instructions.

    So a long call of C code is not ended. Without alarm signals (Windows) nothing is interrupted. Exceptions of
    finalizers are not reported once the time is over. `of_memory`: raise `MemoryUp` when this process takes more
    address space than one may (on Linux only). The system is not asked to refuse more: where memory ends in a deep
    recursion, Python 3.11 crashes.
    """
    memory = limits.memory if of_memory and sys.platform == "linux" else None
    if (limits.seconds is None and memory is None) or not hasattr(signal, "setitimer"):
        yield
        return
    over: Exception | None = None
    tell = sys.unraisablehook

    def ring(number: int, frame: FrameType | None) -> None:
        nonlocal over
        if memory is not None and limits.left > 0:
            if _address_space() <= memory << 20:
                return
            over = MemoryUp(limits.no_memory)
        else:
            over = TimeUp()
        raise over

    def tell_in_time(error: "sys.UnraisableHookArgs") -> None:
        if over is None:
            tell(error)

    before = signal.signal(signal.SIGALRM, ring)
    sys.unraisablehook = tell_in_time
    try:
        first = limits.left if memory is None else min(limits.left, AGAIN)
        signal.setitimer(signal.ITIMER_REAL, max(first, 1e-6), AGAIN)
        yield
    except Exception as error:
        signal.setitimer(signal.ITIMER_REAL, 0)
        if over is None or not is_raised(type(over), error):
            raise
        clear_frames(error.__traceback__)
        raise type(over)(*over.args) from None
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
        sys.unraisablehook = tell


def _address_space() -> int:
    """Return the bytes of address space that this process takes (on Linux)."""
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[0]) * PAGESIZE
