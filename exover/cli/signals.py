"""Ctrl-C and SIGTERM that end the command even if they come while Python swallows exceptions."""

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from threading import Timer

AGAIN = 0.05
"""Seconds after which a signal is sent again."""
SIGNALS = {KeyboardInterrupt: signal.SIGINT, SystemExit: signal.SIGTERM}
"""The signals, by the exception that Python raises for each."""


@contextmanager
def persistent_signals() -> Iterator[None]:
    """Send a signal again that comes while an object is freed in the body: Python swallows exceptions there."""
    tell, timers = sys.unraisablehook, list["Timer"]()

    def send_again(error: "sys.UnraisableHookArgs") -> None:
        number = SIGNALS.get(error.exc_type)
        if number is None:
            tell(error)
            return
        from threading import Timer

        timers.append(Timer(AGAIN, _send, [number]))
        timers[-1].daemon = True
        timers[-1].start()

    sys.unraisablehook = send_again
    try:
        yield
    finally:
        sys.unraisablehook = tell
        for timer in timers:
            timer.cancel()


def _send(number: int) -> None:
    """Send a signal to the main thread, so that it interrupts a system call where the system supports that."""
    from threading import main_thread

    thread = main_thread().ident
    if hasattr(signal, "pthread_kill") and thread is not None:
        signal.pthread_kill(thread, number)
    else:
        signal.raise_signal(number)
