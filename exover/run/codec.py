"""Events and answers as the numbers that the emitted code takes and gives; `exover.h` says what they mean."""

import math
from collections.abc import Sequence
from typing import NamedTuple, assert_never

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
from exover.model.index import ModelIndex
from exover.model.model import Model, Parameter
from exover.model.types import Real, Type, Value, from_ordinal
from exover.ocrd.reasons import reasons
from exover.ocrd.tables import Tables
from exover.ocrd.vector import OUTCOMES
from exover.run.values import packed, unpacked

LAUNCH, WAIT, REJECT, KILL, VIOLATION, INVALID = 0x1E76, 0x4BDC, 0x45AA, 0x2F5B, 0x7455, 0x1369
"""The kinds of actions in exover.h."""
NO_REASON, SUPERSEDED, ABORTED, FAULTY = -1, -2, -3, -4
OWN = {SUPERSEDED: "superseded", ABORTED: "aborted", FAULTY: "faulty"}
CODES = (
    "bad-event",
    "unknown-request",
    "unknown-poster",
    "unknown-argument",
    "missing-argument",
    "out-of-range",
    "unknown-status",
    "not-active",
    "nothing-to-abort",
)
BITS = 1 << 64


class EventNumbers(NamedTuple):
    """An event: a letter as in `runner.c`, its numbers, and the 64 bits of each of its values."""

    letter: str
    numbers: tuple[int, ...]
    values: tuple[int, ...] = ()


class ActionNumbers(NamedTuple):
    """An action as exover.h has it; of a launch with the bits of its arguments."""

    kind: int
    request: int
    slot: int
    reason: int
    launch_rule: int
    values: Sequence[int] = ()


class Codec:
    """Between the events and actions of a model and the numbers of its tables."""

    def __init__(self, model: Model, tables: Tables) -> None:
        self._model = model
        self._tables = tables
        self._reasons = reasons(model)
        index = ModelIndex(model)
        self._request, self._variable, self._stock = index.request, index.reading, index.stock

    def event(self, event: Event) -> EventNumbers:
        """Return a well-formed event as numbers."""
        match event:
            case Ask(name, args):
                return EventNumbers("a", (self._request[name],), _values(self._model.request[name].params, args))
            case Report(name, slot, outcome, results, status):
                request = self._model.request[name]
                code = -1 if status is None else request.statuses.index(status)
                numbers = (self._request[name], slot, OUTCOMES.index(outcome), code)
                return EventNumbers("r", numbers, _values(request.results, results) if outcome == "ok" else ())
            case Observe(name, value, _) if name in self._stock:
                return EventNumbers("l", (self._stock[name],), (int(value) % BITS,))
            case Observe(name, value, broken):
                number = self._variable[name]
                kind = self._model.variables[number].type
                bits = self._broken(number) if broken else _bits(kind, value)
                return EventNumbers("o", (number,), (bits,))
            case Abort(name, slot):
                return EventNumbers("k", (self._request[name], slot))
            case AbortWaiting(name):
                return EventNumbers("w", (self._request[name],))
            case _:
                assert_never(event)

    def _broken(self, variable: int) -> int:
        """Return a reading that is out of range; the checker itself takes its fallback for it."""
        kind, row = self._model.variables[variable].type, self._tables.variables[variable]
        if isinstance(kind, Real):
            return _bits(kind, math.nan)
        return (row.high + 1 if row.high < (1 << 63) - 1 else row.low - 1) % BITS

    def action(self, found: ActionNumbers, event: Event) -> Action:
        """Return an action that answers an event; raises `ValueError` if it is none."""
        kind, request, slot, reason, required, values = found
        if kind == INVALID:
            return _invalid(CODES[reason - 1], event)
        if kind == VIOLATION:
            return Violated(*self._reason(reason))
        name = self._model.requests[request].name
        launch_rule = None if required == NO_REASON else self._reasons[required].rule
        if kind == LAUNCH:
            args = tuple(map(_value, self._model.requests[request].params, values))
            rule, because = self._reason(reason) if reason != NO_REASON else (None, None)
            return Launched(name, slot, args, rule, because, launch_rule)
        if kind == KILL:
            return Killed(name, slot, *(("abort", None) if reason == ABORTED else self._reason(reason)))
        if kind == WAIT:
            return Waits(name, *self._reason(reason), launch_rule)
        if kind != REJECT:
            raise ValueError(f"there is no action {kind:#x}")
        return Rejected(name, *self._reason(reason), launch_rule)

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


def _values(params: Sequence[Parameter], values: Args) -> tuple[int, ...]:
    return tuple(map(_bits, (each.type for each in params), values))


def _bits(kind: Type, value: Value) -> int:
    return int.from_bytes(packed(kind, value), "little")


def _value(parameter: Parameter, bits: int) -> Value:
    number = unpacked(parameter.type, bits.to_bytes(8, "little"))
    return number if isinstance(parameter.type, Real) else from_ordinal(parameter.type, int(number))
