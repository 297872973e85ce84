"""An engine that calls the emitted C in this process, as a shared library; it answers in microseconds."""

import ctypes
import struct
from collections.abc import Iterator
from pathlib import Path

from exover.bounds.sizes import actions_per_event
from exover.engines.compiler import loaded
from exover.model.event import Action, Event
from exover.model.model import Model
from exover.ocrd.tables import Tables
from exover.run.codec import ActionNumbers, Codec
from exover.run.native import NativeFault, compile_with

LIBRARY_FLAGS = ("-std=c99", "-O0", "-pipe", "-shared", "-fPIC")
"""Optimized code takes 0.6 s longer to compile, and an answer with its part in Python 2.7 in place of 2.9 us."""
_EVENT = tuple(struct.Struct(f"={2 + count}i") for count in range(5))
"""Layouts of an event by how many numbers it has, at most four: letter, count of values, numbers."""
_VALUES = 24
"""Offset in bytes of the values of an event."""
_HEAD = struct.Struct("=6q")
"""The numbers of an action before its values."""
_STATUS = struct.Struct("=q")
_WORD = 8


class InProcessEngine:
    """The emitted C of a model as an engine in this process, at first in the initial state.

    Raises `NativeUnavailable` where it cannot be compiled or loaded. One engine belongs to one thread at a time.
    """

    def __init__(self, model: Model, tables: Tables) -> None:
        self._codec = Codec(model, tables)
        self._library = _load(model, tables)
        words = (self._library.library_bytes() + 7) // 8
        most = max((max(len(request.params), len(request.results)) for request in model.requests), default=0)
        self._memory = (ctypes.c_uint64 * words)()
        sent = (ctypes.c_uint64 * (_VALUES // _WORD + max(most, 1)))()
        said = (ctypes.c_uint64 * (1 + (actions_per_event(tables) + 1) * (_HEAD.size // _WORD + most)))()
        self._host, *self._places = (ctypes.addressof(each) for each in (self._memory, sent, said))
        self._sent, self._said = memoryview(sent).cast("B"), memoryview(said).cast("B")
        self.fault = 0
        """0, or the `enum exover_status` for which everything is denied."""
        status = self._library.library_start(self._host)
        if status:
            raise NativeFault(f"the compiled checker refuses its tables: status {status}")

    def step(self, event: Event) -> tuple[Action, ...]:
        """Take a well-formed event and return the actions that answer it; a faulty checker rejects asks as `faulty`."""
        letter, numbers, values = self._codec.event(event)
        _EVENT[len(numbers)].pack_into(self._sent, 0, ord(letter), len(values) // _WORD, *numbers)
        self._sent[_VALUES : _VALUES + len(values)] = values
        count = self._library.library_step(self._host, *self._places)
        (self.fault,) = _STATUS.unpack_from(self._said)
        return (*self._codec.untold(event), *(self._codec.action(found, event) for found in self._answers(count)))

    def _answers(self, count: int) -> Iterator[ActionNumbers]:
        said, place = self._said, _STATUS.size
        for _ in range(count):
            kind, request, slot, reason, launch_rule, arity = _HEAD.unpack_from(said, place)
            begin = place + _HEAD.size
            place = begin + arity * _WORD
            yield ActionNumbers(kind, request, slot, reason, launch_rule, said[begin:place])


def _load(model: Model, tables: Tables) -> ctypes.CDLL:
    """Return the library, compiled and loaded, its functions declared."""

    def make(folder: Path) -> Path:
        return compile_with("library.c", "checker.so", model, tables, folder, LIBRARY_FLAGS)

    library = loaded(make, "cannot compile and load the checker")
    host, size = ctypes.c_void_p, ctypes.c_size_t
    library.library_bytes.restype = size
    library.library_start.argtypes = [host]
    library.library_step.argtypes = [host, host, host]
    library.library_step.restype = size
    return library
