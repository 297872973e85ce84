"""Ctrl-C and SIGTERM, which get out of whatever they come in."""

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
"""By what Python raises for it."""


@contextmanager
def persistent_signals() -> Iterator[None]:
    """Send signals again that come while an object is freed in the body: what is raised there does not get out."""
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
    """Send a signal to the main thread, whose waiting it ends where the system can do that."""
    from threading import main_thread

    thread = main_thread().ident
    if hasattr(signal, "pthread_kill") and thread is not None:
        signal.pthread_kill(thread, number)
    else:
        signal.raise_signal(number)
