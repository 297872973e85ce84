"""Converts events and answers to and from the numbers of the emitted code; `exover.h` says what they mean."""

import math
import struct
from collections.abc import Sequence
from functools import cache
from typing import NamedTuple, assert_never

from exover.model.event import (
    INVALID_CODES,
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
from exover.model.index import ModelIndex
from exover.model.model import Model, Parameter
from exover.model.types import Int, Real, Value, from_ordinal, ordinal
from exover.ocrd.reasons import reasons
from exover.ocrd.tables import Tables
from exover.ocrd.vector import OUTCOMES

LAUNCH, WAIT, REJECT, KILL, VIOLATION, INVALID = 0x1E76, 0x4BDC, 0x45AA, 0x2F5B, 0x7455, 0x1369
"""The numbers of the kinds of actions in exover.h."""
UNSAID, SUPERSEDED, ABORTED, FAULTY = -1, -2, -3, -4
"""Stand in for the number of a reason; `UNSAID` for that of anything else that an action does not say, too."""
OWN = {SUPERSEDED: "superseded", ABORTED: "aborted", FAULTY: "faulty"}
C_CODES = tuple(code for code in INVALID_CODES if code != "wrong-type")
"""The codes of `invalid` in the order of `enum exover_invalid`, from 1; in C no value is of a wrong type."""
_WORD = struct.Struct("=Q")
_LEVEL = struct.Struct("=q")


class EventNumbers(NamedTuple):
    """An event: its letter in `runner.c`, its numbers, and its values as in the memory of C, 8 bytes each."""

    letter: str
    numbers: tuple[int, ...]
    values: bytes = b""

    @property
    def bits(self) -> tuple[int, ...]:
        """The 64 bits of each value as an unsigned number."""
        return tuple(bits for (bits,) in _WORD.iter_unpack(self.values))


class ActionNumbers(NamedTuple):
    """An action in the numbers of exover.h; `values`: the arguments of a launch as in the memory of C."""

    kind: int
    request: int
    slot: int
    reason: int
    launch_rule: int
    values: bytes | memoryview = b""


class ValueLayout:
    """Converts the values of some parameters to and from their bytes in the memory of C, 8 each."""

    def __init__(self, params: Sequence[Parameter]) -> None:
        self._struct = struct.Struct("=" + "".join("d" if isinstance(each.type, Real) else "q" for each in params))
        self._params = params
        self._plain = all(isinstance(each.type, Int | Real) for each in params)
        """Whether values need no conversion to numbers: none is a bool or of an enum."""

    def pack(self, values: Args) -> bytes:
        """Return the bytes of values."""
        return self._struct.pack(*(values if self._plain else map(_number, self._params, values)))

    def unpack(self, data: bytes | memoryview) -> Args:
        """Return the values in bytes."""
        numbers = self._struct.unpack(data)
        return numbers if self._plain else tuple(map(_value, self._params, numbers))


class Codec:
    """Converts the events and actions of a model to and from the numbers of its tables."""

    def __init__(self, model: Model, tables: Tables) -> None:
        self._model = model
        self._tables = tables
        self._reasons = reasons(model)
        index = ModelIndex(model)
        self._request, self._variable, self._stock = index.request, index.reading, index.stock
        self._args = {each.name: ValueLayout(each.params) for each in model.requests}
        self._results = {each.name: ValueLayout(each.results) for each in model.requests}
        self._readings = [ValueLayout([Parameter(each.name, each.type)]) for each in model.variables]
        self._answer = cache(self._action)

    def event(self, event: Event) -> EventNumbers:
        """Return a well-formed event as numbers."""
        match event:
            case Ask(name, args):
                return EventNumbers("a", (self._request[name],), self._args[name].pack(args))
            case Report(name, slot, outcome, results, status):
                code = -1 if status is None else self._model.request[name].statuses.index(status)
                numbers = (self._request[name], slot, OUTCOMES.index(outcome), code)
                return EventNumbers("r", numbers, self._results[name].pack(results) if outcome == "ok" else b"")
            case Observe(name, value, _) if name in self._stock:
                return EventNumbers("l", (self._stock[name],), _LEVEL.pack(value))
            case Observe(name, value, broken):
                number = self._variable[name]
                outside = self._outside(number) if broken else b""
                return EventNumbers("o", (number,), outside or self._readings[number].pack((value,)))
            case Abort(name, slot):
                return EventNumbers("k", (self._request[name], slot))
            case AbortWaiting(name):
                return EventNumbers("w", (self._request[name],))
            case _:
                assert_never(event)

    def untold(self, event: Event) -> tuple[Action, ...]:
        """Return the action `invalid` that the checker cannot give itself, for a broken reading of a range that has all
        numbers of 64 bits: it is told the `else` value then. For other events return no action.
        """
        if not isinstance(event, Observe) or not event.broken:
            return ()
        return () if self._outside(self._variable[event.name]) else (_invalid("out-of-range", event),)

    def _outside(self, variable: int) -> bytes:
        """Return the bytes of a reading out of range, for which the checker takes the `else` value itself; none if all
        numbers of 64 bits are in range.
        """
        if isinstance(self._model.variables[variable].type, Real):
            return struct.pack("=d", math.nan)
        row = self._tables.variables[variable]
        if row.high < (1 << 63) - 1:
            return _LEVEL.pack(row.high + 1)
        return _LEVEL.pack(row.low - 1) if row.low > -(1 << 63) else b""

    def action(self, found: ActionNumbers, event: Event) -> Action:
        """Return the action of these numbers, an answer to the event; raises `ValueError` if its kind is unknown."""
        kind, request, slot, reason, required, values = found
        if kind == LAUNCH:
            name = self._model.requests[request].name
            rule, because = self._reason(reason) if reason != UNSAID else (None, None)
            return Launched(name, slot, self._args[name].unpack(values), rule, because, self._origin(required))
        if kind == INVALID:
            return _invalid(C_CODES[reason - 1], event)
        return self._answer(kind, request, slot, reason, required)

    def _action(self, kind: int, request: int, slot: int, reason: int, required: int) -> Action:
        """Return the action of these numbers, neither a launch nor `invalid`; cached, since there are few of them."""
        if kind == VIOLATION:
            return Violated(*self._reason(reason))
        name, launch_rule = self._model.requests[request].name, self._origin(required)
        if kind == KILL:
            return Killed(name, slot, *(("abort", None) if reason == ABORTED else self._reason(reason)))
        if kind == WAIT:
            return Waits(name, *self._reason(reason), launch_rule)
        if kind != REJECT:
            raise ValueError(f"there is no action {kind:#x}")
        return Rejected(name, *self._reason(reason), launch_rule)

    def _origin(self, launch_rule: int) -> str | None:
        return None if launch_rule == UNSAID else self._reasons[launch_rule].rule

    def _reason(self, index: int) -> tuple[str, str | None]:
        if index in OWN:
            return OWN[index], None
        reason = self._reasons[index]
        return reason.rule, reason.because


def _invalid(code: str, event: Event) -> Invalid:
    match event:
        case Observe(_, value, True):
            return Invalid(code, f"taken as {value}")
        case Report(name, slot) | Abort(name, slot):
            return Invalid(code, f"slot {slot} of {name} is idle")
        case AbortWaiting(name):
            return Invalid(code, f"nothing waits at {name}")
        case _:
            return Invalid(code)


def _number(parameter: Parameter, value: Value) -> int | float:
    return float(value) if isinstance(parameter.type, Real) else ordinal(parameter.type, value)


def _value(parameter: Parameter, number: int | float) -> Value:
    return number if isinstance(parameter.type, Real) else from_ordinal(parameter.type, int(number))
