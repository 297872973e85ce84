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
EVENTS = range(5)
"""The kinds of records that are events: ask, report, observation, abort of an instance, abort of what waits."""
OBSERVE = 2
LISTEN = 5
MOST_ACTIONS = 0xFFFF
"""The most actions of an answer that is a record."""
_ACTION = struct.Struct("<BHHIIB")
_HEAD = struct.Struct("<QH")


class RecordCodec:
    """The binary records of one model."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._requests = ModelIndex(model).request

    @cached_property
    def _rules(self) -> dict[tuple[str, str | None], int]:
        named = [(each.rule, each.because) for each in reasons(self._model)]
        return {each: number for number, each in enumerate(dict.fromkeys([*((own, None) for own in NO_RULES), *named]))}

    @cached_property
    def _origins(self) -> dict[str, int]:
        """The number of each launch rule, by name."""
        return {each.name: self._rules[each.name, each.because] for each in self._model.launches}

    @cached_property
    def _told(self) -> dict[str, list[Json]]:
        """What the description says of the requests and observables."""
        return {
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
            "observables": _described(self._model.observable.items()),
        }

    def description(self) -> bytes:
        """Return the description that says what the numbers stand for: a JSON object as text."""
        told = {
            "spec": self._model.name,
            "sha256": digest(self._model).hex(),
            **self._told,
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
        if kind not in EVENTS:
            return Invalid("bad-event", f"there is no kind {kind} of event")
        known = self._told["observables" if kind == OBSERVE else "requests"]
        if number < len(known):
            return event_entries(kind, known[number], record)
        if kind == OBSERVE:
            return Invalid("unknown-poster", f"there is no observable {number}")
        return Invalid("unknown-request", f"there is no request {number}")

    # ---- answers ----

    def answer(self, step: int, actions: Sequence[Action]) -> bytes:
        """Return the record of the actions that answer the event of a step."""
        return _HEAD.pack(step, len(actions)) + b"".join(map(self._action, actions))

    def _action(self, action: Action) -> bytes:
        match action:
            case Launched(name, slot, args, rule, because, origin):
                number = NO_RULE if rule is None else self._rules[rule, because]
                values = (packed(param.type, value) for param, value in zip(self._params(name), args, strict=True))
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


def event_entries(kind: int, known: Json, record: bytes) -> Json:
    """Return the record of an event as the object of a JSON line; `known`: the description of what it is about.

    Raises `struct.error` if the record is too short.
    """
    name = known["name"]
    match kind:
        case 0:
            return {"ask": name, "args": values_in(known["args"], record[3:])}
        case 1:
            slot, outcome, status = struct.unpack_from("<xxxHBH", record)
            found = {"report": name, "instance": slot, "outcome": _name(ENDINGS, outcome)}
            if status != NO_NUMBER:
                found["status"] = _name(known["statuses"], status)
            return found | ({"results": values_in(known["results"], record[8:])} if outcome == 0 else {})
        case 2:
            return {"observe": name, "value": _value(known, record[3:])}
        case 3:
            return {"abort": name, "instance": struct.unpack_from("<xxxH", record)[0]}
        case _:
            return {"abort": name, "waiting": True}


def values_in(described: Sequence[Json], data: bytes) -> Json:
    """Return the values of described parameters, by name; raises `struct.error` if there are fewer bytes."""
    return {each["name"]: _value(each, data[8 * number :]) for number, each in enumerate(described)}


def _value(described: Json, data: bytes) -> Any:
    """Return a value as in JSON; a number outside its type gives a value outside it."""
    if described["type"] == "real":
        return struct.unpack_from("<d", data)[0]
    number: int = struct.unpack_from("<q", data)[0]
    if described["type"] == "bool":
        return bool(number) if number in (0, 1) else NoBool(number)
    return _name(described["values"], number) if described["type"] == "enum" else number


def _name(names: Sequence[str], number: int) -> str:
    """Return the name of this number; if there is none, `#` and the number, which is no name of the language."""
    return names[number] if 0 <= number < len(names) else f"#{number}"


def _described(fields: Iterable[tuple[str, Type]]) -> list[Json]:
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


def says_listen(record: bytes) -> bool | None:
    """Return whether a record turns listening on, None if it does not turn it on or off."""
    return {b"\5\0": False, b"\5\1": True}.get(record[:2])


def packed(kind: Type, value: Value) -> bytes:
    """Return the eight bytes of a value: a real as a double (IEEE 754), any other as its ordinal, signed."""
    return struct.pack("<d", float(value)) if isinstance(kind, Real) else struct.pack("<q", ordinal(kind, value))
