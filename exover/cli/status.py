"""Exit statuses (docs/checks.md), and the refusal that ends a command with one of them."""

from collections.abc import Iterable
from enum import IntEnum


class Status(IntEnum):
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
    Status.TERMINATED,
    Status.INTERRUPTED,
    Status.FAULT,
    Status.WRONG,
    Status.VIOLATED,
    Status.UNKNOWN,
    Status.OK,
)


def severest(statuses: Iterable[int]) -> Status:
    """Return the status of a command that ended so in each of its parts: the first of `SEVEREST` that is one."""
    return min(map(Status, statuses), key=SEVEREST.index, default=Status.OK)


class Refused(Exception):
    """The command cannot be carried out, and it is not our fault; the text tells the user why."""
