"""Writes missions as binary records, and reads those that `audit.c` does not (docs/audit.md, "Binary missions")."""

import json
import math
import struct
from collections.abc import Iterator, Sequence
from typing import Any, BinaryIO, assert_never

from exover.audit.mission import (
    CODES,
    Item,
    KillDeed,
    LaunchDeed,
    LostLines,
    Noted,
    RejectDeed,
    ToldMark,
    Unread,
    Void,
    WaitDeed,
    read_noted,
    read_recorded,
    read_time,
)
from exover.model.event import ENDINGS, Abort, AbortWaiting, Ask, Event, Invalid, Observe, Report
from exover.model.index import ModelIndex
from exover.model.model import Model, Parameter
from exover.model.types import Real, Value
from exover.model.wire import Json
from exover.model.wire_reading import MAX_LINE
from exover.run.codec import Codec
from exover.run.records import EVENTS, NO_NUMBER, OBSERVE, RecordCodec, event_entries, packed, says_listen, values_in

MAGIC = b"EXO1"
LAUNCH, KILL, WAIT, REJECT, TOLD, TIME = range(6, 12)
BAD_ASK, BAD_LAUNCH, BAD_REPORT, BAD_EVENT, BAD_DEED, BAD_LINE, LOST, VOID = range(16, 24)
"""Kinds of records that are in no file: they tell `audit.c` of items that only the Python reader knows."""
LENGTH = struct.Struct("<I")
MOST_DESCRIPTION = 16 << 20


class NoMission(Exception):
    """The file is no mission; the text says why."""


class RecordWriter:
    """Writes the items of a mission as records with the numbers of a model, each behind its length."""

    def __init__(self, model: Model, codec: Codec | None = None) -> None:
        self._model = model
        self._codec = codec
        self._requests = ModelIndex(model).request
        self._observables = {name: number for number, name in enumerate(model.observable)}

    def record(self, item: Item) -> bytes:
        """Return the record of an item."""
        data = self._record(item)
        return LENGTH.pack(len(data)) + data

    def noted(self, noted: Noted) -> Iterator[bytes]:
        """Yield the records of a line's time and items, in this order."""
        yield time_record(noted.time)
        for item in noted.items:
            yield self.record(item)

    def _record(self, item: Item) -> bytes:
        match item:
            case Ask() | Report() | Observe() | Abort() | AbortWaiting():
                return self._event(item)
            case LaunchDeed(name, instance, args):
                head = struct.pack("<BHHB", LAUNCH, self._requests[name], instance, args is not None)
                return head + _packed(self._model.request[name].params, args or ())
            case KillDeed(name, instance):
                return struct.pack("<BHH", KILL, self._requests[name], instance)
            case WaitDeed(name):
                return struct.pack("<BH", WAIT, self._requests[name])
            case RejectDeed(name):
                return struct.pack("<BH", REJECT, self._requests[name])
            case ToldMark():
                return bytes([TOLD])
            case LostLines(lines):
                return struct.pack("<BQ", LOST, lines)
            case Void():
                return bytes([VOID])
            case Unread(fault, kind, name, instance):
                return self._unread(fault, kind, name, instance)
            case _:
                assert_never(item)

    def _event(self, event: Event) -> bytes:
        match event:
            case Ask(name, args):
                return struct.pack("<BH", 0, self._requests[name]) + _packed(self._model.request[name].params, args)
            case Report(name, slot, outcome, results, status):
                request = self._model.request[name]
                number = NO_NUMBER if status is None else request.statuses.index(status)
                head = struct.pack("<BHHBH", 1, self._requests[name], slot, ENDINGS.index(outcome), number)
                return head + (_packed(request.results, results) if outcome == "ok" else b"")
            case Observe(name, value, broken):
                head = struct.pack("<BH", 2, self._observables[name])
                if broken and self._codec:
                    return head + struct.pack("<Q", *self._codec.event(event).bits)
                return head + self._reading(name, value, broken)
            case Abort(name, slot):
                return struct.pack("<BHH", 3, self._requests[name], slot)
            case AbortWaiting(name):
                return struct.pack("<BH", 4, self._requests[name])
            case _:
                assert_never(event)

    def _reading(self, name: str, value: Value, broken: bool) -> bytes:
        if name not in self._model.variable:
            return struct.pack("<q", int(value))
        kind = self._model.variable[name].type
        if broken:
            return struct.pack("<d", math.nan) if isinstance(kind, Real) else struct.pack("<q", (1 << 63) - 1)
        return packed(kind, value)

    def _unread(self, fault: Invalid, kind: str, name: str | None, instance: int | None) -> bytes:
        code = CODES.index(fault.code) + 1
        slot = NO_NUMBER if instance is None else instance
        if name is None:
            return bytes([{"event": BAD_EVENT, "deed": BAD_DEED}.get(kind, BAD_LINE)])
        number = {"ask": BAD_ASK, "launch": BAD_LAUNCH, "report": BAD_REPORT}[kind]
        return struct.pack("<BHHB", number, self._requests[name], slot, code)


def time_record(time: float) -> bytes:
    """Return the record that gives the time, in seconds, of the records behind it."""
    return LENGTH.pack(9) + struct.pack("<Bd", TIME, time)


def _packed(params: Sequence[Parameter], values: Sequence[Value]) -> bytes:
    return b"".join(packed(param.type, value) for param, value in zip(params, values, strict=False))


class MissionWriter:
    """Writes a mission to a file, item by item; raises `OSError`."""

    def __init__(self, model: Model, file: BinaryIO) -> None:
        self._writer = RecordWriter(model)
        self._file = file
        description = RecordCodec(model).description()
        file.write(MAGIC + LENGTH.pack(len(description)) + description)

    def write(self, item: Item) -> None:
        """Write an item; `LostLines`, `Void` and `Unread` have no record in a file and raise `ValueError`."""
        if isinstance(item, LostLines | Void | Unread):
            raise ValueError(f"{type(item).__name__} has no record")
        self._file.write(self._writer.record(item))

    def at(self, time: float) -> None:
        """Write the time, in seconds, of the items that follow."""
        self._file.write(time_record(time))


class RecordReader:
    """Reads the records of a file with this description as items of a model. Raises `NoMission`."""

    def __init__(self, model: Model, description: bytes) -> None:
        self._model = model
        self._time = math.nan
        try:
            self._told = json.loads(description)
            self._requests: list[Json] = self._told["requests"]
            self._observables: list[Json] = self._told["observables"]
            for each in self._requests:
                [_type_of(param) for param in (*each["args"], *each["results"])]
                list(each["name"]), list(each["statuses"])
            [_type_of(each) for each in self._observables]
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            raise NoMission("its first record is no description of a spec") from error
        own = json.loads(RecordCodec(model).description())
        self.same = all(_numbers(self._told[key]) == _numbers(own[key]) for key in ("requests", "observables"))
        """Whether the numbers of the description have the same meaning in the model."""

    def read(self, record: bytes) -> Noted:
        """Return the items of a record, with the time of the last time record."""
        try:
            noted = self._read(record)
            self._time = self._time if noted.items else noted.time
            return Noted(noted.items, self._time, noted.fault)
        except struct.error:
            return Noted((Unread(Invalid("bad-event", f"the record of {len(record)} bytes is too short")),))

    def _read(self, record: bytes) -> Noted:
        if not record:
            raise struct.error
        kind = record[0]
        if kind == TOLD:
            return Noted((ToldMark(),))
        if says_listen(record) is not None:
            return Noted(())
        if kind == TIME:
            (time,) = struct.unpack_from("<xd", record)
            return Noted(()) if math.isnan(time) else Noted((), *read_time(time))
        if kind not in (*EVENTS, LAUNCH, KILL, WAIT, REJECT):
            return Noted((Unread(Invalid("bad-event", f"there is no kind {kind} of record")),))
        number = struct.unpack_from("<xH", record)[0]
        known, what = (self._observables, "poster") if kind == OBSERVE else (self._requests, "request")
        if number >= len(known):
            unknown = Invalid(f"unknown-{what}", f"its description has no {what} {number}")
            return Noted((Unread(unknown, "deed" if kind >= LAUNCH else "event"),))
        entries = self._entries(kind, known[number], record)
        if kind >= LAUNCH:
            return read_noted(self._model, entries)
        return Noted((read_recorded(self._model, entries),))

    def _entries(self, kind: int, known: Json, record: bytes) -> Json:
        """Return a record as the object of a JSON line."""
        name = known["name"]
        match kind:
            case 6:
                slot, given = struct.unpack_from("<xxxHB", record)
                found = {"launch": name, "instance": slot}
                return found | ({"args": values_in(known["args"], record[6:])} if given else {})
            case 7:
                return {"kill": name, "instance": struct.unpack_from("<xxxH", record)[0]}
            case 8:
                return {"wait": name}
            case 9:
                return {"reject": name}
            case _:
                return event_entries(kind, known, record)


def read_description(file: BinaryIO) -> bytes:
    """Return the description at the start of a file; raises `NoMission`."""
    head = file.read(len(MAGIC) + LENGTH.size)
    if head[: len(MAGIC)] != MAGIC or len(head) < len(MAGIC) + LENGTH.size:
        raise NoMission("it does not begin as one, with EXO1 and a description")
    (length,) = LENGTH.unpack_from(head, len(MAGIC))
    description = file.read(length) if length <= MOST_DESCRIPTION else b""
    if len(description) < length or length > MOST_DESCRIPTION:
        raise NoMission("its description is cut short")
    return description


def split(data: bytes) -> tuple[list[bytes], bytes]:
    """Return the whole records of some bytes, without their lengths, and the rest of the bytes."""
    found, at = [], 0
    while len(data) - at >= LENGTH.size:
        (length,) = LENGTH.unpack_from(data, at)
        end = at + LENGTH.size + length
        if length > MAX_LINE or end > len(data):
            break
        found.append(data[at + LENGTH.size : end])
        at = end
    return found, data[at:]


def refuse_overlong(rest: bytes) -> None:
    """Raise `NoMission` if the record that begins here is longer than `MAX_LINE`."""
    if len(rest) >= LENGTH.size:
        (length,) = LENGTH.unpack_from(rest)
        if length > MAX_LINE:
            raise NoMission(f"a record of {length} bytes, and at most {MAX_LINE} are read")


def _numbers(described: Any) -> Any:
    """Return a description without ranges of numbers: they do not change the number of a value."""
    match described:
        case dict():
            return {key: _numbers(value) for key, value in described.items() if key not in ("low", "high")}
        case list():
            return [_numbers(each) for each in described]
        case _:
            return described


def _type_of(described: Json) -> str:
    kind = str(described["type"])
    if kind not in ("bool", "int", "enum", "real") or not isinstance(described["name"], str):
        raise ValueError(kind)
    if kind == "enum" and not all(isinstance(value, str) for value in described["values"]):
        raise ValueError(kind)
    return kind
