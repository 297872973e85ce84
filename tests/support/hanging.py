"""A call that does not return for minutes, as one into a library may."""

import ctypes
import inspect
import signal


def hang() -> None:
    """Stay in one call of C code for minutes; no signal handler of Python runs meanwhile, and no other thread."""
    handled = {number for number in signal.valid_signals() if callable(signal.getsignal(number))}
    signal.pthread_sigmask(signal.SIG_BLOCK, handled)
    ctypes.PyDLL(None).sleep(300)


HANG = f"import ctypes, signal\n{inspect.getsource(hang)}"
"""The same as the beginning of a program."""
