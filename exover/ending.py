"""The signals that end a command."""

import signal

ENDING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Signals after which a command cleans up and ends. SIGHUP comes when a terminal is closed; Windows has none."""


def heeded() -> set[int]:
    """Return those of `ENDING` that this process does not ignore; under `nohup` it ignores SIGHUP."""
    return {number for number in ENDING if signal.getsignal(number) != signal.SIG_IGN}


def leave_ending_to_parent() -> None:
    """Take SIGTERM alone, by which a parent ends this process: what a terminal sends, it sends to the parent, too."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    for number in set(ENDING) - {signal.SIGTERM}:
        signal.signal(number, signal.SIG_IGN)
