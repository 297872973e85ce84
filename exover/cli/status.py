"""Exit statuses (docs/checks.md), and the refusal that ends a command with one of them."""

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


class Refused(Exception):
    """The command cannot be carried out, and it is not our fault; the text tells the user why."""
