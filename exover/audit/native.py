"""Calls the audit in C (`exover/runtime/audit.c`), compiled with the tables of a model, in this process."""

import ctypes
import struct
import tempfile
from collections.abc import Callable, Iterable, Sequence
from itertools import accumulate, chain
from pathlib import Path

from exover.audit.binary import LENGTH, RecordWriter
from exover.audit.mission import CODES, Noted
from exover.audit.sources import line_behind
from exover.audit.trail import ANSWERS, COUNTED, DIVERGENCES, KINDS, AuditRow, MissionFigures
from exover.emit.artefact import runtime_file
from exover.engines.compiler import NativeUnavailable, loaded
from exover.model.index import ModelIndex
from exover.model.model import Model, Parameter, Request
from exover.model.types import Bool, Enum, Int, Real, Type
from exover.ocrd.reasons import reasons
from exover.ocrd.tables import Tables
from exover.run.codec import ABORTED, OWN, Codec
from exover.run.native import NativeFault, compile_with

FLAGS = ("-std=c99", "-O3", "-pipe", "-shared", "-fPIC", "-DEXOVER_SCRUB=0")
"""Without scrubbing: an audit need not check its tables against memory faults in each step."""
MOST_NUMBERED = 65_000
"""The most requests, variables, or instances of a request: two bytes hold their numbers."""
MOST_VALUES = 256
DONE, ODD, FULL = range(3)
MOST = (1 << 64) - 1
BATCH = 2000
"""The most records of a line that C takes in one call; the rows it has found are fetched after each call."""
_ROW = struct.Struct("<Qd6i")
_INVALID = -100

Odd = Callable[[int, bytes, bytes], Noted | None]
"""Reads a line or record that C does not read: takes its number, its bytes, and the next line; None if it is blank."""


def compile_library(model: Model, tables: Tables, flags: Sequence[str] = FLAGS) -> bytes:
    """Return the bytes of a shared library that audits by these tables; raises `NativeUnavailable`."""
    if not _is_numbered(model):
        raise NativeUnavailable(f"the spec has more than {MOST_NUMBERED} of something, or {MOST_VALUES} arguments")
    with tempfile.TemporaryDirectory(prefix="exover-", ignore_cleanup_errors=True) as folder:
        (Path(folder) / "audit_lines.h").write_bytes(runtime_file("audit_lines.h"))
        return compile_with("audit.c", "audit.so", model, tables, Path(folder), flags).read_bytes()


def _is_numbered(model: Model) -> bool:
    values = [len(each) for request in model.requests for each in (request.params, request.results, request.statuses)]
    numbered = [len(model.requests), len(model.variables), *(request.instances for request in model.requests)]
    return max(numbered) <= MOST_NUMBERED and max(values) <= MOST_VALUES


class NativeAuditor:
    """Audits missions one after the other in C; raises `NativeUnavailable` if the library cannot be loaded."""

    def __init__(self, model: Model, tables: Tables, library: bytes) -> None:
        self._library = _load(library)
        self._writer = RecordWriter(model, Codec(model, tables))
        self._reasons = [reason.rule for reason in reasons(model)]
        self._requests = [request.name for request in model.requests]
        meta, texts, ends = _described(model, len(self._reasons))
        self._audit = self._library.audit_new(meta, texts, ends)
        if not self._audit:
            raise MemoryError
        self._rows = self._library.audit_rows(self._audit)
        self._tell: Callable[[AuditRow], None] = lambda row: None

    def close(self) -> None:
        """Free the memory of the audit."""
        self._library.audit_free(self._audit)

    def start(self, tell: Callable[[AuditRow], None], wants_asks: bool = False, most: int = MOST) -> None:
        """Begin a mission; `tell` gets at most `most` rows of it, asks among them if `wants_asks`."""
        self._tell = tell
        status = int(self._library.audit_start(self._audit, int(wants_asks), most))
        if status:
            raise NativeFault(f"the compiled checker refuses its tables: status {status}")

    def take(self, line: int, noted: Noted, timed: bool = True) -> None:
        """Take the items of a line that was read in Python, and its time iff `timed`; else the last time holds on."""
        records = list(self._writer.noted(noted))[0 if timed else 1 :]
        self._library.audit_at(self._audit, line)
        used = ctypes.c_size_t()
        for first in range(0, len(records), BATCH):
            data = b"".join(records[first : first + BATCH])
            self._library.audit_records(self._audit, data, len(data), 1, used)
            self._drain()

    def place(self) -> int:
        """Return the number of lines or records that were read."""
        return int(self._library.audit_place(self._audit))

    def lines(self, data: bytes, last: bool, odd: Odd) -> int:
        """Take the whole lines of a piece of the file, `last` iff it is the last; return the number of their bytes."""
        return self._pieces(
            data, odd, lambda at, size, used: self._library.audit_lines(self._audit, at, size, last, used), last
        )

    def records(self, data: bytes, odd: Odd) -> int:
        """Take the whole records of a piece of the file; return the number of their bytes."""
        call = self._library.audit_records
        return self._pieces(data, odd, lambda at, size, used: call(self._audit, at, size, 0, used))

    def _pieces(
        self,
        data: bytes,
        odd: Odd,
        call: Callable[[int, int, ctypes.c_size_t], int],
        last: bool | None = None,
    ) -> int:
        """Take the whole lines of a piece, or with `last` None its whole records; return the number of their bytes."""
        start = ctypes.cast(ctypes.c_char_p(data), ctypes.c_void_p).value
        assert start is not None
        used, at = ctypes.c_size_t(), 0
        while True:
            outcome = call(start + at, len(data) - at, used)
            at += used.value
            self._drain()
            if outcome == DONE:
                return at
            if outcome == ODD:
                size = self._odd_record(data, at, odd) if last is None else self._odd_line(data, at, odd, last)
                if not size:
                    return at
                at += size

    def _odd_record(self, data: bytes, at: int, odd: Odd) -> int:
        """Take a record that C does not read; return the number of its bytes."""
        size = LENGTH.size + int(LENGTH.unpack_from(data, at)[0])
        number = self.place() + 1
        noted = odd(number, data[at + LENGTH.size : at + size], b"")
        self._handed_in(number, noted, timed=noted is not None and not noted.items)
        return size

    def _odd_line(self, data: bytes, at: int, odd: Odd, last: bool) -> int:
        """Take a line that C does not read; return the number of its bytes, 0 if the line behind it is not read yet."""
        end = data.find(b"\n", at)
        size = (len(data) if end < 0 else end + 1) - at
        behind = line_behind(data, at + size, last)
        if behind is None:
            return 0
        number = self.place() + 1
        self._handed_in(number, odd(number, data[at : at + size], behind), timed=True)
        return size

    def _handed_in(self, number: int, noted: Noted | None, timed: bool) -> None:
        self._library.audit_at(self._audit, number)
        if noted is not None:
            self.take(number, noted, timed)

    # ---- what is found ----

    def _drain(self) -> None:
        count = self._library.audit_taken(self._audit)
        if not count:
            return
        for row in _ROW.iter_unpack(ctypes.string_at(self._rows, count * _ROW.size)):
            line, time, kind, request, instance, answer, rule, _ = row
            slot = None if instance in (-1, 0xFFFF) else instance
            why = "abort" if KINDS[kind] == "kept" and rule == ABORTED else self._rule(rule)
            self._tell(AuditRow(line, time, KINDS[kind], self._requests[request], slot, ANSWERS[answer], why))

    def _rule(self, number: int) -> str | None:
        if number <= _INVALID:
            return CODES[_INVALID - number - 1]
        return OWN[number] if number in OWN else None if number < 0 else self._reasons[number]

    def figures(self) -> MissionFigures:
        """Return the counts of the mission; raises `NativeFault` if the checker is faulty."""
        fault = self._library.audit_fault(self._audit)
        if fault:
            raise NativeFault(f"the compiled checker found a fault: status {fault}")
        figures = MissionFigures()
        numbers = iter(self._counts())
        for name in COUNTED:
            setattr(figures, name, next(numbers))
        next(numbers)
        for kind in DIVERGENCES:
            figures.diverged[kind] = next(numbers)
        for name in self._requests:
            for answer in ANSWERS[:4]:
                figures.asks[name, answer] = next(numbers)
        for number, rule in enumerate(self._reasons):
            figures.used[rule] += next(numbers) if number else 0 * next(numbers)
        return figures.plain()

    def _counts(self) -> Sequence[int]:
        size = len(COUNTED) + len(KINDS) + 4 * len(self._requests) + len(self._reasons)
        return list(self._library.audit_counts(self._audit)[:size])


# ---- the library ----


class _Names(list[bytes]):
    """The names of a model, numbered from 0."""

    def number(self, texts: Iterable[str]) -> int:
        """Append names, and return the number of the first."""
        first = len(self)
        self.extend(text.encode("utf-8", "surrogateescape") for text in texts)
        return first


def _described(
    model: Model, reason_count: int
) -> tuple[ctypes.Array[ctypes.c_int64], bytes, ctypes.Array[ctypes.c_int64]]:
    """Return a model as the arguments of `audit_new`: its numbers, its names joined, and the end of each name."""
    names, index = _Names(), ModelIndex(model)
    posters = [(Parameter(each.name, each.type), 0, number) for number, each in index.posters]
    stocks = [(Parameter(each.name, Int(0, each.capacity)), 1, k) for k, each in enumerate(index.consumables)]
    rows = [_request_numbers(names, request) for request in model.requests]
    rows += [_parameter_numbers(names, *each) for each in (*posters, *stocks)]
    params = sum(len(request.params) + len(request.results) for request in model.requests)
    slots = sum(request.instances for request in model.requests)
    counts = [len(model.requests), len(posters) + len(stocks), reason_count, slots, params, len(names)]
    numbers = [*counts, *chain.from_iterable(rows)]
    ends = list(accumulate(map(len, names)))
    return (ctypes.c_int64 * len(numbers))(*numbers), b"".join(names), (ctypes.c_int64 * len(ends))(*ends)


def _request_numbers(names: _Names, request: Request) -> list[int]:
    sizes = [request.instances, len(request.params), len(request.results), len(request.statuses)]
    numbers = [names.number([request.name]), *sizes, names.number(request.statuses)]
    for each in (*request.params, *request.results):
        numbers += _parameter_numbers(names, each)
    return numbers


def _parameter_numbers(names: _Names, parameter: Parameter, stock: int = 0, number: int = 0) -> list[int]:
    kind = parameter.type
    numbers = [names.number([parameter.name]), *_range(kind)]
    return [*numbers, names.number(kind.values if isinstance(kind, Enum) else ()), stock, number]


def _range(kind: Type) -> tuple[int, int, int]:
    """Return the number of a kind of type, and its least and greatest value."""
    match kind:
        case Bool():
            return 0, 0, 1
        case Int(low, high):
            return 1, low, high
        case Real(low, high):
            return 2, _bits(low), _bits(high)
        case Enum(values):
            return 3, 0, len(values) - 1


def _bits(real: float) -> int:
    bits: int = struct.unpack("<q", struct.pack("<d", real))[0]
    return bits


def _load(library: bytes) -> ctypes.CDLL:
    """Return the loaded library, its functions declared."""

    def make(folder: Path) -> Path:
        (folder / "audit.so").write_bytes(library)
        return folder / "audit.so"

    audits = loaded(make, "cannot load the compiled audit")
    audit, size, number = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_uint64
    used = ctypes.POINTER(size)
    numbers = ctypes.POINTER(ctypes.c_int64)
    for name, result, arguments in (
        ("audit_new", audit, [numbers, ctypes.c_char_p, numbers]),
        ("audit_free", None, [audit]),
        ("audit_start", ctypes.c_int, [audit, ctypes.c_int, number]),
        ("audit_fault", ctypes.c_int, [audit]),
        ("audit_lines", ctypes.c_int, [audit, ctypes.c_void_p, size, ctypes.c_int, used]),
        ("audit_records", ctypes.c_int, [audit, ctypes.c_void_p, size, ctypes.c_int, used]),
        ("audit_line", ctypes.c_long, [audit, ctypes.c_char_p, size, ctypes.c_char_p, size]),
        ("audit_at", None, [audit, number]),
        ("audit_place", number, [audit]),
        ("audit_taken", number, [audit]),
        ("audit_rows", audit, [audit]),
        ("audit_counts", ctypes.POINTER(number), [audit]),
    ):
        function = getattr(audits, name)
        function.restype, function.argtypes = result, arguments
    return audits
