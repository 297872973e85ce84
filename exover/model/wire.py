"""Writing events and answers as JSON lines (docs/language.md section 7); `wire_reading` reads them."""

import json
import math
from collections.abc import Iterable, Mapping
from decimal import Decimal
from typing import Any, assert_never

from exover.model.event import (
    Abort,
    AbortWaiting,
    Action,
    Args,
    Ask,
    Event,
    Invalid,
    Killed,
    Launched,
    Observe,
    Rejected,
    Report,
    Violated,
    Waits,
)
from exover.model.model import Model, Parameter
from exover.model.types import Bool, Enum, Int, Real, Type, Value

MAX_DIGITS = 400
"""Characters of the longest integer that is read exactly; the largest double has 309 digits, so no domain has more."""
WHOLE = 10**16
"""Below it a whole double is printed as an integer; from it on Python prints an exponent and no fraction."""

MAX_DEPTH = 200
"""The most levels of objects and lists; how many can be read and written again depends on the version of Python."""

Json = dict[str, Any]


def is_too_deep(found: object) -> bool:
    """Return whether lists and objects of JSON are nested more than `MAX_DEPTH` levels deep."""
    level = [found]
    for _ in range(MAX_DEPTH):
        level = [inner for outer in level for inner in _inside(outer) if isinstance(inner, dict | list)]
    return bool(level)


def _inside(outer: object) -> Iterable[object]:
    return outer.values() if isinstance(outer, dict) else outer if isinstance(outer, list) else ()


def number(value: float) -> int | float:
    """Return the number that JSON prints for a double: an int if it is whole and below `WHOLE`, so 0 for -0.0."""
    return int(value) if abs(value) < WHOLE and value.is_integer() else value


def as_double(number: int | float | Decimal) -> float:
    """Return the double nearest to a number, never -0.0; an infinity if it is beyond the largest."""
    try:
        return float(number) + 0.0  # -0.0 becomes 0.0
    except OverflowError:
        return math.inf if number > 0 else -math.inf


def indented(found: object) -> str:
    """Return an object as indented JSON with a final newline; raises `ValueError` for NaN and infinities."""
    return escaped(json.dumps(found, ensure_ascii=False, allow_nan=False, indent=1)) + "\n"


def escaped(text: str) -> str:
    """Return a JSON text that UTF-8 can encode: lone surrogates, which a string may hold, become `\\udxxx`."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def answer_line(model: Model, step: int, actions: Iterable[Action]) -> str:
    """Return the answer to the event of this step, one line without its newline."""
    answer = {"step": step, "actions": [action_json(model, action) for action in actions]}
    return escaped(json.dumps(answer, ensure_ascii=False))


def action_json(model: Model, action: Action) -> Json:
    """Return an action as the object of docs/language.md section 7, its keys in that order."""
    match action:
        case Launched(name, slot, args, rule, because, launch_rule):
            named = {"args": _named(model.request[name].params, args)} | ({"rule": rule} if rule else {})
            return {"launch": name, "instance": slot} | named | _text(because) | _origin(launch_rule)
        case Waits(name, rule, because, launch_rule):
            return {"wait": name, "rule": rule} | _text(because) | _origin(launch_rule)
        case Rejected(name, rule, because, launch_rule):
            return {"reject": name, "rule": rule} | _text(because) | _origin(launch_rule)
        case Killed(name, slot, rule, because):
            return {"kill": name, "instance": slot, "rule": rule} | _text(because)
        case Violated(rule, because):
            return {"violation": rule} | _text(because)
        case Invalid(code, detail):
            return {"invalid": code} | ({"detail": detail} if detail else {})
        case _:
            assert_never(action)


def _text(because: str | None) -> Json:
    return {} if because is None else {"because": because}


def _origin(launch_rule: str | None) -> Json:
    return {} if launch_rule is None else {"launch_rule": launch_rule}


def event_json(model: Model, event: Event) -> Json:
    """Return an event as an object that `read_event` reads as this event.

    A broken `Observe` no longer has its reading; some value outside the poster's range is written instead.
    """
    match event:
        case Ask(name, args):
            return {"ask": name, "args": _named(model.request[name].params, args)}
        case Report(name, slot, "ok", results):
            ending = {"report": name, "instance": slot, "outcome": "ok"}
            declared = model.request[name].results
            return ending | ({"results": _named(declared, results)} if declared else {})
        case Report(name, slot, outcome, _, status):
            ending = {"report": name, "instance": slot, "outcome": outcome}
            return ending | ({"status": status} if status is not None else {})
        case Observe(name, value, broken):
            return {"observe": name, "value": _outside(model.variable[name].type) if broken else _plain(value)}
        case Abort(name, slot):
            return {"abort": name, "instance": slot}
        case AbortWaiting(name):
            return {"abort": name, "waiting": True}
        case _:
            assert_never(event)


def _named(parameters: tuple[Parameter, ...], values: Args) -> Mapping[str, Value]:
    return {parameter.name: _plain(value) for parameter, value in zip(parameters, values, strict=True)}


def _plain(value: Value) -> Value:
    return number(value) if isinstance(value, float) else value


def _outside(kind: Type) -> int | str:
    """Return a reading outside the domain of a type, read as out of range; raises `ValueError` for a bool."""
    match kind:
        case Int(_, high):
            return high + 1
        case Real(_, high):
            beyond = math.floor(high) + 1 if math.isfinite(high) else 10**MAX_DIGITS
            return beyond if as_double(beyond) > high else 10**MAX_DIGITS
        case Enum():
            return "?"  # no name of the language
        case Bool():
            raise ValueError("every reading of a bool is in its domain or of another type")
        case _:
            assert_never(kind)
