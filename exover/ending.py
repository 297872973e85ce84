"""The signals that end a command."""

import signal

HANGUP: int | None = getattr(signal, "SIGHUP", None)
"""What processes get when their terminal is closed; Windows has none."""
ENDING = tuple(each for each in (signal.SIGINT, signal.SIGTERM, HANGUP) if each is not None)
"""Signals after which a command cleans up and ends."""


def leave_ending_to_parent() -> None:
    """Take SIGTERM alone, by which a parent ends this process: what a terminal sends, it sends to the parent, too."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    for number in set(ENDING) - {signal.SIGTERM}:
        signal.signal(number, signal.SIG_IGN)
