"""Exit statuses (docs/checks.md), and the refusal that ends a command with one of them."""

from collections.abc import Iterable
from enum import IntEnum


class ExitStatus(IntEnum):
    """How a command ends."""

    OK = 0
    VIOLATED = 1
    WRONG = 2
    UNKNOWN = 3
    FAULT = 4
    INTERRUPTED = 130
    """128 and the number of SIGINT, as shells have it."""
    TERMINATED = 143
    """128 and the number of SIGTERM."""


SEVEREST = (
    ExitStatus.TERMINATED,
    ExitStatus.INTERRUPTED,
    ExitStatus.FAULT,
    ExitStatus.WRONG,
    ExitStatus.VIOLATED,
    ExitStatus.UNKNOWN,
    ExitStatus.OK,
)


def severest(statuses: Iterable[int]) -> ExitStatus:
    """Return the status of a command that ended so in each of its parts: the first of `SEVEREST` that is one."""
    return min(map(ExitStatus, statuses), key=SEVEREST.index, default=ExitStatus.OK)


class CliError(Exception):
    """The command cannot be carried out, and it is not our fault; the text tells the user why."""
