"""Exit statuses (docs/checks.md), and the refusal that ends a command with one of them."""

from collections.abc import Iterable
from enum import IntEnum


class ExitStatus(IntEnum):
    """The exit status of a command."""

    OK = 0
    VIOLATED = 1
    WRONG = 2
    UNKNOWN = 3
    FAULT = 4
    INTERRUPTED = 130
    """128 plus the number of SIGINT, as in shells."""
    TERMINATED = 143
    """128 plus the number of SIGTERM."""


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
    """Return the severest of these statuses, in the order of `SEVEREST`; OK if there are none."""
    return min(map(ExitStatus, statuses), key=SEVEREST.index, default=ExitStatus.OK)


class CliError(Exception):
    """The command cannot be carried out, for a reason outside exover; the text tells the user why."""
