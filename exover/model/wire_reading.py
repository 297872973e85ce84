"""Reading events from JSON lines (docs/language.md section 7).

Reading any line returns an event or the `Invalid` that answers it. The engines find the faults that depend on the
state (`not-active`, `nothing-to-abort`).
"""

import json
import math
from collections.abc import Callable, Iterable
from decimal import Decimal
from typing import assert_never

from exover.diagnostics import did_you_mean, quote
from exover.model.event import Abort, AbortWaiting, Args, Ask, Event, Invalid, Observe, Report
from exover.model.model import Model, Parameter
from exover.model.types import Bool, Enum, Int, Real, Type, Value, contains
from exover.model.wire import MAX_DEPTH, MAX_DIGITS, Json, as_double, is_too_deep, number

MAX_LINE = 1 << 20
"""Bytes of the longest line that is read, its end left out; a longer one is a `bad-event`."""
TOO_LONG = MAX_LINE + len(b"\r\n")
"""A line is longer than MAX_LINE if this many bytes hold no line feed."""
LONG_LINE = Invalid("bad-event", f"the line is longer than {MAX_LINE} bytes")
"""What a line is that is longer than MAX_LINE."""

DEEP_LINE = Invalid("bad-event", "the line is nested too deep")
"""What a line is that is nested more than MAX_DEPTH levels deep."""


class NoBool(int):
    """A number that a binary record has for a bool, neither 0 nor 1: out of range, which no JSON value of a bool is."""


_TINY = Decimal("1e-400")
"""A positive number that rounds to the double 0 but is not whole."""


def is_blank(line: str | bytes) -> bool:
    """Return whether a line holds nothing but blanks of JSON, which are fewer than `strip` takes away."""
    return not (line.strip(" \t\r\n") if isinstance(line, str) else line.strip(b" \t\r\n"))


def read_event(model: Model, line: str | bytes) -> Event | Invalid:
    """Return the event of a line, or the first of its faults in the order of docs/language.md section 7."""
    entries = read_object(line)
    return entries if isinstance(entries, Invalid) else read_entries(model, entries)


def read_entries(model: Model, entries: Json) -> Event | Invalid:
    """Return the event of an object, or the first of its faults, as `read_event` does for a line with this object."""
    for kind, read in _READERS.items():
        if kind in entries:
            return read(model, entries)
    return Invalid("bad-event", "none of ask, report, observe, abort is there")


def read_object(line: str | bytes) -> Json | Invalid:
    """Return the JSON object of a line, or the `bad-event` if it holds none."""
    if 4 * len(line) > MAX_LINE and _size(line) > MAX_LINE:  # a character has up to four bytes
        return LONG_LINE
    try:
        text = (line.decode() if isinstance(line, bytes) else line).removeprefix("\ufeff")
        found = _DECODER.decode(text.rstrip("\r\n"))
    except UnicodeDecodeError as error:
        return Invalid("bad-event", f"the line is not UTF-8: {error.reason} at byte {error.start + 1}")
    except json.JSONDecodeError as error:
        reason = error.msg[:1].lower() + error.msg[1:]
        return Invalid("bad-event", f"the line is not JSON: {reason}, column {error.colno}")
    except RecursionError:
        return DEEP_LINE
    if text.count("[") + text.count("{") > MAX_DEPTH and is_too_deep(found):
        return DEEP_LINE
    if not isinstance(found, dict):
        return Invalid("bad-event", f"the line is {shown(found)}, not an object")
    return found


def _size(line: str | bytes) -> int:
    """Return the length of a line in bytes, without its line end."""
    data = line.encode(errors="surrogatepass") if isinstance(line, str) else line
    return len(data.rstrip(b"\r\n"))


def _whole(text: str) -> int | float:
    # Python refuses to read integers of more than some thousand digits, and needs quadratic time for the others.
    if len(text) > MAX_DIGITS:
        return -math.inf if text.startswith("-") else math.inf
    return int(text)


def _fraction(text: str) -> Decimal | float:
    # A Decimal is exact, so no fraction is rounded away where an integer is required. Decimal may refuse the exponents
    # of numbers that a double rounds to 0 or infinity; one representative stands for all of these.
    value = float(text)
    if value == 0 and set("123456789") & set(text.lower().partition("e")[0]):
        return _TINY
    return Decimal(text) if 0 < abs(value) < math.inf else value


_DECODER = json.JSONDecoder(parse_int=_whole, parse_float=_fraction)


def _ask(model: Model, entries: Json) -> Event | Invalid:
    name = _request(model, entries["ask"])
    if isinstance(name, Invalid):
        return name
    args = _values(name, "parameter", model.request[name].params, entries.get("args", {}))
    return args if isinstance(args, Invalid) else Ask(name, args)


def _report(model: Model, entries: Json) -> Event | Invalid:
    name = _request(model, entries["report"])
    if isinstance(name, Invalid):
        return name
    slot = _slot(model, name, entries)
    if isinstance(slot, Invalid):
        return slot
    request = model.request[name]
    match entries.get("outcome"):
        case "ok":
            results = _values(name, "result", request.results, entries.get("results", {}))
            return results if isinstance(results, Invalid) else Report(name, slot, "ok", results)
        case "failed":
            status = entries.get("status")
            if "status" in entries and not (isinstance(status, str) and status in request.statuses):
                known = f"it fails as {', '.join(request.statuses)}" if request.statuses else "it declares none"
                return Invalid("unknown-status", f"{shown(status)} is no status of {name}: {known}")
            return Report(name, slot, "failed", status=status)
        case "interrupted":
            return Report(name, slot, "interrupted")
        case other:
            found = shown(other) if "outcome" in entries else "missing"
            return Invalid("bad-event", f"the outcome is {found}, not one of `ok`, `failed`, `interrupted`")


def _observe(model: Model, entries: Json) -> Event | Invalid:
    name = entries["observe"]
    if not isinstance(name, str) or name not in model.observable:
        return _unknown("unknown-poster", "poster or consumable resource", name, model.observable)
    kind = model.observable[name]
    if "value" not in entries:
        return Invalid("missing-argument", f"`value` is missing: {name} reads {domain(kind)}")
    value = _value(kind, entries["value"], name)
    if not isinstance(value, Invalid):
        return Observe(name, value)
    fallback = model.variable[name].fallback if name in model.variable else None
    if value.code == "out-of-range" and fallback is not None:
        return Observe(name, fallback, broken=True)
    return value


def _abort(model: Model, entries: Json) -> Event | Invalid:
    name = _request(model, entries["abort"])
    if isinstance(name, Invalid):
        return name
    if entries.get("waiting") is True:
        return AbortWaiting(name)
    slot = _slot(model, name, entries)
    return slot if isinstance(slot, Invalid) else Abort(name, slot)


_READERS: dict[str, Callable[[Model, Json], Event | Invalid]] = {
    "ask": _ask,
    "report": _report,
    "observe": _observe,
    "abort": _abort,
}


def _request(model: Model, found: object) -> str | Invalid:
    if isinstance(found, str) and found in model.request:
        return found
    return _unknown("unknown-request", "request", found, model.request)


def _slot(model: Model, name: str, entries: Json) -> int | Invalid:
    kind = Int(0, model.request[name].instances - 1)
    value = _value(kind, entries.get("instance", 0), f"the instance of {name}")
    return value if isinstance(value, Invalid) else int(value)


def _values(name: str, word: str, parameters: tuple[Parameter, ...], found: object) -> Args | Invalid:
    """Return the values of an object in the order of the parameters, or the first fault.

    `word` is "parameter" or "result", for messages. The common case is decided here, without messages.
    """
    if isinstance(found, dict) and len(found) == len(parameters):
        each = [(parameter.type, found.get(parameter.name)) for parameter in parameters]
        values = tuple([value for kind, one in each if (value := _fitting(kind, one)) is not None])
        if len(values) == len(parameters):
            return values
    return _named_values(name, word, parameters, found)


def _named_values(name: str, word: str, parameters: tuple[Parameter, ...], found: object) -> Args | Invalid:
    """Return the same as `_values`, parameter by parameter."""
    if not isinstance(found, dict):
        return Invalid("bad-event", f"the {word}s of {name} are {shown(found)}, not an object")
    known = [parameter.name for parameter in parameters]
    for key in found:
        if key not in known:
            return _unknown("unknown-argument", word, key, known, f"{name} has")
    values: list[Value] = []
    for parameter in parameters:
        if parameter.name not in found:
            return Invalid("missing-argument", f"{name} lacks `{parameter.name}`, {domain(parameter.type)}")
        value = _value(parameter.type, found[parameter.name], f"`{parameter.name}` of {name}")
        if isinstance(value, Invalid):
            return value
        values.append(value)
    return tuple(values)


def _value(kind: Type, found: object, subject: str) -> Value | Invalid:
    """Return a JSON value as a value of this type (a real as the nearest `float`, never -0.0), or the fault."""
    value = _fitting(kind, found)
    if value is not None:
        return value
    code = "wrong-type" if _typed(kind, found) is None else "out-of-range"
    return Invalid(code, f"{subject} is {shown(found)}, not {domain(kind)}")


def _fitting(kind: Type, found: object) -> Value | None:
    """Return a JSON value as a value of this type, None if it is not in its domain."""
    value = _typed(kind, found)
    return value if value is not None and contains(kind, value) else None


def _typed(kind: Type, found: object) -> Value | None:
    """Return a JSON value as the Python type of `kind`, in its domain or not; None if it has another type."""
    match kind:
        case Real() | Int():
            if isinstance(found, bool) or not isinstance(found, (int, float, Decimal)):
                return None
            if isinstance(kind, Real):
                return as_double(found)
            if isinstance(found, float) and not math.isfinite(found):
                return found
            return int(found) if found == int(found) else None
        case Bool():
            return found if isinstance(found, bool | NoBool) else None
        case Enum():
            return found if isinstance(found, str) else None
        case _:
            assert_never(kind)


# ---- details ----


def _unknown(code: str, word: str, found: object, known: Iterable[str], there_is: str = "there is") -> Invalid:
    hint = did_you_mean(found, known) if isinstance(found, str) else ""
    return Invalid(code, f"{there_is} no {word} {shown(found)}" + (f"; {hint}" if hint else ""))


def domain(kind: Type) -> str:
    """Return a type in words, for messages."""
    match kind:
        case Bool():
            return "true or false"
        case Int(low, high):
            return f"an integer in {low} .. {high}"
        case Real(low, high):
            bounded = math.isfinite(low) or math.isfinite(high)
            return f"a number in {number(low)} .. {number(high)}" if bounded else "a finite number"
        case Enum(names):
            return f"one of {', '.join(names)}"
        case _:
            assert_never(kind)


def shown(found: object) -> str:
    """Return a JSON value in words, short enough for a message."""
    match found:
        case None:
            return "null"
        case bool():
            return "true" if found else "false"
        case str():
            return quote(found)
        case list():
            return "a list"
        case dict():
            return "an object"
        case _:
            text = str(found)
            return text if len(text) <= 40 else f"{text[:40]}…"
