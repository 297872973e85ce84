"""Replays a black box: reads its steps as events of a spec, and asks the reference interpreter (docs/runtime.md)."""

import json
import struct
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from typing import TypeVar

from exover.model.event import Action, Invalid, Killed, Launched, Observe, Rejected, Violated, Waits
from exover.model.index import ModelIndex
from exover.model.model import Model, Parameter
from exover.model.replayed import BareAction, Replayed
from exover.model.types import Bool, Enum, Int, Real, Value, from_ordinal
from exover.model.wire import MAX_DIGITS, Json, number
from exover.model.wire_reading import is_blank, read_event
from exover.ocrd.reasons import reasons
from exover.ocrd.vector import OUTCOMES
from exover.run import box
from exover.run.box import BoxStep
from exover.run.codec import ABORTED, C_CODES, FAULTY, INVALID, KILL, LAUNCH, OWN, REJECT, UNSAID, VIOLATION, WAIT
from exover.run.simulate import ReferenceEngine

NO_NAME = "?"
"""Stands for a number that has no name in the spec; it is no name of the language."""
VERBS = {
    LAUNCH: "launch",
    WAIT: "wait",
    REJECT: "reject",
    KILL: "kill",
    VIOLATION: "violation",
    INVALID: "invalid",
}
FAULTS = (
    "PATH",
    "ACTIONS",
    "PASSES",
    "DECISION",
    "CHANNELS",
    "INDEX",
    "STATE",
    "TABLES",
    "CHECKER",
    "REENTRY",
    "ANSWERS",
)
FIRST_FAULT = 15
T = TypeVar("T")


def replay(model: Model, run: Sequence[BoxStep], before: Iterable[bytes] = ()) -> tuple[Replayed, ...]:
    """Return the steps of a run with the recorded and the expected answers.

    `before`: the event lines from loading to the first step. If there are too few, no answers are expected.
    """
    engine = ReferenceEngine(model)
    missing = box.earlier(run[0].number)
    lines = list(islice((line for line in before if not is_blank(line)), missing))
    for line in lines:
        event = read_event(model, line)
        if not isinstance(event, Invalid):
            engine.step(event)
    return tuple(_steps(model, run, engine if len(lines) == missing else None))


def _steps(model: Model, run: Iterable[BoxStep], engine: ReferenceEngine | None) -> Iterator[Replayed]:
    names = [reason.rule for reason in reasons(model)]
    for step in run:
        broken = _broken_bool(model, step)
        event = {"observe": broken.name, "value": broken.value} if broken else event_of(model, step)
        read = broken or read_event(model, json.dumps(event))
        actions = (read,) if isinstance(read, Invalid) else engine.step(read) if engine else ()
        recorded = tuple(_recorded(model, names, answer) for answer in step.answers)
        expected = tuple(map(_said, actions)) if engine else None
        yield Replayed(
            step.number, event, read, None if step.fault is None else recorded, expected, _fault(step.fault or 0)
        )


def _broken_bool(model: Model, step: BoxStep) -> Observe | None:
    """Return the broken reading of a bool, neither 0 nor 1, which JSON cannot say, with its `else` value; else None."""
    variable = _at(model.variables, step.words[0]) if step.what == box.OBSERVE else None
    if variable is None or variable.fallback is None or not isinstance(variable.type, Bool) or not step.values:
        return None
    return None if step.values[0] in (0, 1) else Observe(variable.name, variable.fallback, True)


def _fault(status: int) -> str | None:
    if FIRST_FAULT <= status < FIRST_FAULT + len(FAULTS):
        return f"EXOVER_FAULT_{FAULTS[status - FIRST_FAULT]}"
    return f"status {status}" if status else None


# ---- answers ----


def _recorded(model: Model, names: Sequence[str], answer: Sequence[int]) -> BareAction:
    kind, request, slot, reason, launch_rule = answer
    verb = VERBS.get(kind, NO_NAME)
    if kind == INVALID:
        plain = (request, slot, launch_rule) == (UNSAID, UNSAID, UNSAID)
        return BareAction(verb if plain and 0 < reason <= len(C_CODES) else NO_NAME)
    own = {UNSAID: None, **OWN, FAULTY: "the checker is faulty"} | ({ABORTED: "abort"} if kind == KILL else {})
    rule = own[reason] if reason in own else _at(names, reason) or NO_NAME
    subject = _at(model.requests, request)
    name = None if request == UNSAID else subject.name if subject else NO_NAME
    origin = None if launch_rule == UNSAID else _at(names, launch_rule) or NO_NAME
    return BareAction(verb, name, None if slot == UNSAID else slot, rule, origin)


def _said(action: Action) -> BareAction:
    match action:
        case Launched(name, slot, _, rule, _, launch_rule):
            return BareAction("launch", name, slot, rule, launch_rule)
        case Waits(name, rule, _, launch_rule):
            return BareAction("wait", name, None, rule, launch_rule)
        case Rejected(name, rule, _, launch_rule):
            return BareAction("reject", name, None, rule, launch_rule)
        case Killed(name, slot, rule):
            return BareAction("kill", name, slot, rule)
        case Violated(rule):
            return BareAction("violation", None, None, rule)
        case Invalid():
            return BareAction("invalid")


# ---- events ----


def event_of(model: Model, step: BoxStep) -> Json:
    """Return the event of a step as JSON; what is no event for the checker is none for `read_event` either."""
    match step.what:
        case box.OBSERVE | box.LEVEL:
            return _reading(model, step)
        case box.REPORT:
            return _report(model, step)
        case _:
            request = _at(model.requests, step.words[0])
            name = request.name if request else NO_NAME
            if step.what == box.ASK:
                return {"ask": name, "args": _named(request.params if request else (), step)}
            return {"abort": name} | ({"instance": step.words[1]} if step.what == box.ABORT else {"waiting": True})


def _reading(model: Model, step: BoxStep) -> Json:
    if step.what == box.LEVEL:
        stock = _at(ModelIndex(model).consumables, step.words[0])
        found = Parameter(stock.name, Int(0, stock.capacity)) if stock else None
    else:
        variable = _at(model.variables, step.words[0])
        found = Parameter(variable.name, variable.type) if variable and variable.kind == "poster" else None
    if found is None or not step.values:
        return {"observe": found.name if found else NO_NAME}
    return {"observe": found.name, "value": _value(found, step.values[0])}


def _report(model: Model, step: BoxStep) -> Json:
    """Return a report as JSON; one with a status that is no failure, which the checker refuses, has no outcome."""
    subject, slot, outcome, status = step.words
    request = _at(model.requests, subject)
    told = outcome if status == UNSAID or OUTCOMES[outcome : outcome + 1] == ("failed",) else UNSAID
    ending = OUTCOMES[told] if 0 < told < len(OUTCOMES) else NO_NAME
    found: Json = {"report": request.name if request else NO_NAME, "instance": slot, "outcome": ending}
    if request and ending == "ok" and (request.results or step.count):
        return found | {"results": _named(request.results, step)}
    unknown = status != UNSAID and request is not None
    return found | ({"status": _at(request.statuses, status) or NO_NAME} if unknown and request else {})


def _named(parameters: Sequence[Parameter], step: BoxStep) -> Json:
    """Return the values by name; if there are more than parameters, `NO_NAME` stands for the others."""
    found: Json = {p.name: _value(p, bits) for p, bits in zip(parameters, step.values, strict=False)}
    return found | ({NO_NAME: 0} if step.count > len(parameters) else {})


def _value(parameter: Parameter, bits: int) -> Value:
    """Return a value as in JSON; a number outside the type gives a value outside it."""
    integer = bits - (bits >> 63 << 64)
    match parameter.type:
        case Real():
            real: float = struct.unpack("<d", struct.pack("<Q", bits))[0]
            return number(real) if abs(real) < float("inf") else 10**MAX_DIGITS
        case Enum(values) if not 0 <= integer < len(values):
            return NO_NAME
        case Bool() if integer not in (0, 1):
            return integer
        case kind:
            return from_ordinal(kind, integer)


def _at(things: Sequence[T], index: int) -> T | None:
    return things[index] if 0 <= index < len(things) else None
