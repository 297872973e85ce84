"""Events and answers as binary records, which have numbers where JSON lines have names (docs/serve.md)."""

import json
import struct
from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import Any, assert_never

from exover.model.canonical import digest
from exover.model.event import (
    ENDINGS,
    INVALID_CODES,
    NO_RULES,
    Action,
    Event,
    Invalid,
    Killed,
    Launched,
    Rejected,
    Violated,
    Waits,
)
from exover.model.index import ModelIndex
from exover.model.model import Model, Parameter
from exover.model.types import Bool, Enum, Int, Real, Type, Value, ordinal
from exover.model.wire import Json
from exover.model.wire_reading import NoBool, read_entries
from exover.ocrd.reasons import reasons

NO_NUMBER = 0xFFFF
NO_RULE = 0xFFFF_FFFF
LISTEN = 5
MOST_ACTIONS = 0xFFFF
"""The most actions of an answer that is a record."""
_ACTION = struct.Struct("<BHHIIB")
_HEAD = struct.Struct("<QH")


class RecordCodec:
    """The binary records of one model."""

    def __init__(self, model: Model) -> None:
        self._model = model
        index = ModelIndex(model)
        self._requests = index.request
        self._observables: list[tuple[str, Type]] = [(each.name, each.type) for _, each in index.posters]
        self._observables += [(each.name, Int(0, each.capacity)) for each in index.consumables]

    @cached_property
    def _rules(self) -> dict[tuple[str, str | None], int]:
        named = [(each.rule, each.because) for each in reasons(self._model)]
        return {each: number for number, each in enumerate(dict.fromkeys([*((own, None) for own in NO_RULES), *named]))}

    @cached_property
    def _origins(self) -> dict[str, int]:
        """The number of each launch rule, by name."""
        return {each.name: self._rules[each.name, each.because] for each in self._model.launches}

    def description(self) -> bytes:
        """Return the description that says what the numbers stand for: a JSON object as text."""
        told = {
            "spec": self._model.name,
            "sha256": digest(self._model).hex(),
            "requests": [
                {
                    "name": each.name,
                    "instances": each.instances,
                    "args": _described((param.name, param.type) for param in each.params),
                    "results": _described((param.name, param.type) for param in each.results),
                    "statuses": list(each.statuses),
                }
                for each in self._model.requests
            ],
            "observables": _described(self._observables),
            "rules": [{"rule": rule} | ({} if text is None else {"because": text}) for rule, text in self._rules],
            "codes": list(INVALID_CODES),
        }
        return json.dumps(told).encode()

    # ---- events ----

    def event(self, record: bytes) -> Event | Invalid:
        """Return the event of a record, or its first fault."""
        try:
            entries = self._entries(record)
        except struct.error:
            return Invalid("bad-event", f"the record of {len(record)} bytes is too short")
        return entries if isinstance(entries, Invalid) else read_entries(self._model, entries)

    def _entries(self, record: bytes) -> Json | Invalid:
        """Return a record as the object of a JSON line, or its fault; raises `struct.error` if it is too short."""
        kind, number = struct.unpack_from("<BH", record)
        rest = record[3:]
        if kind not in (0, 1, 2, 3, 4):
            return Invalid("bad-event", f"there is no kind {kind} of event")
        if kind == 2:
            return self._observed(number, rest)
        if number >= len(self._model.requests):
            return Invalid("unknown-request", f"there is no request {number}")
        request = self._model.requests[number]
        match kind:
            case 0:
                return {"ask": request.name, "args": _values(request.params, rest)}
            case 1:
                slot, outcome, status = struct.unpack_from("<HBH", rest)
                found = {"report": request.name, "instance": slot, "outcome": name_of(ENDINGS, outcome)}
                if status != NO_NUMBER:
                    found["status"] = name_of(request.statuses, status)
                return found | ({"results": _values(request.results, rest[5:])} if outcome == 0 else {})
            case 3:
                return {"abort": request.name, "instance": struct.unpack_from("<H", rest)[0]}
            case _:
                return {"abort": request.name, "waiting": True}

    def _observed(self, number: int, rest: bytes) -> Json | Invalid:
        if number >= len(self._observables):
            return Invalid("unknown-poster", f"there is no observable {number}")
        name, kind = self._observables[number]
        return {"observe": name, "value": _value(kind, rest)}

    # ---- answers ----

    def answer(self, step: int, actions: Sequence[Action]) -> bytes:
        """Return the record of the actions that answer the event of a step."""
        return _HEAD.pack(step, len(actions)) + b"".join(map(self._action, actions))

    def _action(self, action: Action) -> bytes:
        match action:
            case Launched(name, slot, args, rule, because, origin):
                number = NO_RULE if rule is None else self._rules[rule, because]
                values = (_packed(param.type, value) for param, value in zip(self._params(name), args, strict=True))
                return _ACTION.pack(0, self._requests[name], slot, number, self._origin(origin), 0) + b"".join(values)
            case Waits(name, rule, because, origin):
                kind, slot, number = 1, NO_NUMBER, self._rules[rule, because]
                return _ACTION.pack(kind, self._requests[name], slot, number, self._origin(origin), 0)
            case Rejected(name, rule, because, origin):
                kind, slot, number = 2, NO_NUMBER, self._rules[rule, because]
                return _ACTION.pack(kind, self._requests[name], slot, number, self._origin(origin), 0)
            case Killed(name, slot, rule, because):
                return _ACTION.pack(3, self._requests[name], slot, self._rules[rule, because], NO_RULE, 0)
            case Violated(rule, because):
                return _ACTION.pack(4, NO_NUMBER, NO_NUMBER, self._rules[rule, because], NO_RULE, 0)
            case Invalid(code):
                return _ACTION.pack(5, NO_NUMBER, NO_NUMBER, NO_RULE, NO_RULE, INVALID_CODES.index(code))
            case _:
                assert_never(action)

    def _params(self, name: str) -> tuple[Parameter, ...]:
        return self._model.request[name].params

    def _origin(self, rule: str | None) -> int:
        return NO_RULE if rule is None else self._origins[rule]


def _described(fields: Iterable[tuple[str, Type]]) -> list[dict[str, Any]]:
    return [{"name": name} | _type(kind) for name, kind in fields]


def _type(kind: Type) -> dict[str, Any]:
    match kind:
        case Bool():
            return {"type": "bool"}
        case Int(low, high):
            return {"type": "int", "low": low, "high": high}
        case Enum(values):
            return {"type": "enum", "values": list(values)}
        case Real():
            return {"type": "real"}
        case _:
            assert_never(kind)


def _values(params: Sequence[Parameter], data: bytes) -> dict[str, Any]:
    return {param.name: _value(param.type, data[8 * number :]) for number, param in enumerate(params)}


def _value(kind: Type, data: bytes) -> Any:
    """Return a value as in JSON; a number outside its type gives a value outside it."""
    number = _unpacked(kind, data)
    match kind:
        case Bool():
            return bool_of(int(number))
        case Enum(values):
            return name_of(values, int(number))
        case _:
            return number


def says_listen(record: bytes) -> bool | None:
    """Return whether a record turns listening on, None if it does not turn it on or off."""
    return {b"\5\0": False, b"\5\1": True}.get(record[:2])


def bool_of(number: int) -> bool | NoBool:
    """Return the bool that a record has as this number; `NoBool` if it has none."""
    return bool(number) if number in (0, 1) else NoBool(number)


def name_of(names: Sequence[str], number: int) -> str:
    """Return the name of this number; if there is none, `#` and the number, which is no name of the language."""
    return names[number] if 0 <= number < len(names) else f"#{number}"


def _packed(kind: Type, value: Value) -> bytes:
    """Return the eight bytes of a value: a real as a double (IEEE 754), any other as its ordinal, signed."""
    return struct.pack("<d", float(value)) if isinstance(kind, Real) else struct.pack("<q", ordinal(kind, value))


def _unpacked(kind: Type, data: bytes) -> float | int:
    """Return the real or the ordinal in the first eight bytes; raises `struct.error` if there are fewer."""
    number: float | int = struct.unpack_from("<d" if isinstance(kind, Real) else "<q", data)[0]
    return number
