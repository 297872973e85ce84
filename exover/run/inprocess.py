"""The emitted C as a shared library, called in this process: an engine that answers in microseconds."""

import ctypes
import tempfile
from collections.abc import Iterator
from pathlib import Path

from exover.bounds.sizes import actions_per_event
from exover.engines.compiler import NativeUnavailable
from exover.model.event import Action, Event
from exover.model.model import Model
from exover.ocrd.tables import Tables
from exover.run.codec import BITS, ActionNumbers, Codec
from exover.run.native import NativeFault, compile_with

LIBRARY_FLAGS = ("-std=c99", "-O1", "-pipe", "-shared", "-fPIC")
HEAD = 6
"""Numbers of an answer before its values."""


class InProcessEngine:
    """The emitted C of a model as an engine in this process, at first in the initial state.

    Raises `NativeUnavailable` where it cannot be compiled or loaded. One engine belongs to one thread at a time.
    """

    def __init__(self, model: Model, tables: Tables) -> None:
        self._codec = Codec(model, tables)
        self._library = _load(model, tables)
        words = (self._library.library_bytes() + 7) // 8
        self._memory = (ctypes.c_uint64 * words)()
        self._host = ctypes.addressof(self._memory)
        most = max((max(len(request.params), len(request.results)) for request in model.requests), default=0)
        self._said = (ctypes.c_int64 * ((actions_per_event(tables) + 1) * (HEAD + most)))()
        self._numbers = (ctypes.c_int32 * 4)()
        self._values = (ctypes.c_uint64 * max(most, 1))()
        status = self._library.library_start(self._host)
        if status:
            raise NativeFault(f"the compiled checker refuses its tables: status {status}")

    def step(self, event: Event) -> tuple[Action, ...]:
        """Take a well-formed event and return the actions that answer it; a faulty checker rejects for `faulty`."""
        letter, numbers, values = self._codec.event(event)
        self._numbers[: len(numbers)] = list(numbers)
        self._values[: len(values)] = list(values)
        sent = self._numbers, self._values, len(values)
        count = self._library.library_step(self._host, letter.encode(), *sent, self._said)
        return tuple([self._codec.action(found, event) for found in self._answers(count)])

    @property
    def fault(self) -> int:
        """0, or why everything is denied, as `enum exover_status` numbers it."""
        return int(self._library.library_fault(self._host))

    def _answers(self, count: int) -> Iterator[ActionNumbers]:
        said, place = self._said, 0
        for _ in range(count):
            kind, request, slot, reason, launch_rule, arity = said[place : place + HEAD]
            place += HEAD
            values = [bits % BITS for bits in said[place : place + arity]]
            place += arity
            yield ActionNumbers(kind, request, slot, reason, launch_rule, values)


def _load(model: Model, tables: Tables) -> ctypes.CDLL:
    """Return the library; its file is gone as soon as it is loaded."""
    try:
        with tempfile.TemporaryDirectory(prefix="exover-", ignore_cleanup_errors=True) as folder:
            path = compile_with("library.c", "checker.so", model, tables, Path(folder), LIBRARY_FLAGS)
            library = ctypes.CDLL(str(path))
    except OSError as error:
        raise NativeUnavailable(f"cannot compile and load the checker: {error}") from error
    host, size = ctypes.c_void_p, ctypes.c_size_t
    library.library_bytes.restype = size
    library.library_start.argtypes = library.library_fault.argtypes = [host]
    numbers, values, said = (ctypes.POINTER(kind) for kind in (ctypes.c_int32, ctypes.c_uint64, ctypes.c_int64))
    library.library_step.argtypes = [host, ctypes.c_char, numbers, values, size, said]
    library.library_step.restype = size
    return library
