"""The line format of docs/language.md section 7: every fault by its code, in its order, and nothing that raises."""

import json
import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from exover.model.event import (
    Abort,
    AbortWaiting,
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
from exover.model.expression import TRUE
from exover.model.model import Latch, Model, Parameter, Request, Resource, Variable
from exover.model.types import Bool, Enum, Int, Real, Type
from exover.model.wire import MAX_DEPTH, action_json, answer_line, event_json
from exover.model.wire_reading import MAX_LINE, read_event

ZONE = Enum(("base", "dock", "field"))
EXACT = Int(-(2**62), 2**62)

MODEL = Model(
    name="demo",
    requests=(
        Request(
            "nd.goto",
            params=(Parameter("x", Real()), Parameter("n", Int(0, 9)), Parameter("where", ZONE)),
            results=(Parameter("dist", Real(0.0, 200.0)), Parameter("sure", Bool())),
            statuses=("blocked", "lost"),
            instances=2,
        ),
        Request("nd.stop"),
        Request("arm.turn", params=(Parameter("far", EXACT),)),
    ),
    variables=(
        Variable("battery", "poster", Int(0, 100), 100),
        Variable("nd.speed", "poster", Real(0.0, 2.0), 0.0, fallback=2.0),
        Variable("door", "poster", Enum(("open", "shut")), "open", fallback="open"),
        Variable("wild", "poster", Real(), 0.0, fallback=1.5),
        Variable("wide", "poster", Real(-1e300, 1e300), 0.0, fallback=0.0),
        Variable("count", "poster", EXACT, 0, fallback=0),
        Variable("estop", "poster", Bool(), False),
        Variable("arm.tool", "state", Bool(), False),
    ),
    latches=(Latch("alarm", TRUE, ("nd.stop",)),),
    resources=(Resource("power", 100, False, 100, ()), Resource("film", 4, True, 2, ())),
    rules=(),
    launches=(),
)


def code(line: str | bytes) -> str:
    event = read_event(MODEL, line)
    assert isinstance(event, Invalid), event
    assert event.detail
    return event.code


EVENTS: list[tuple[str, Event]] = [
    ('{"ask": "nd.stop"}', Ask("nd.stop")),
    ('{"ask": "nd.stop", "args": {}, "why": [{}]}', Ask("nd.stop")),
    ('  {"args": {"x": 1, "n": 2, "where": "dock"}, "ask": "nd.goto"}\r\n', Ask("nd.goto", (1.0, 2, "dock"))),
    ('{"ask": "nd.goto", "args": {"where": "base", "n": 2.0, "x": 1e2}}', Ask("nd.goto", (100.0, 2, "base"))),
    ('{"ask": "nd.goto", "args": {"x": -0.0, "n": 9e0, "where": "base"}}', Ask("nd.goto", (0.0, 9, "base"))),
    ('{"ask": "nd.goto", "args": {"x": 0.1, "x": 7, "n": 0, "where": "base"}}', Ask("nd.goto", (7.0, 0, "base"))),
    ('{"ask": "arm.turn", "args": {"far": 4611686018427387903.0}}', Ask("arm.turn", (2**62 - 1,))),
    ('{"ask": "nd.stop", "report": "nd.goto", "observe": 1, "abort": 1}', Ask("nd.stop")),
    ('{"abort": 1, "observe": 1, "report": "nd.stop", "outcome": "interrupted"}', Report("nd.stop", 0, "interrupted")),
    (
        '{"report": "nd.goto", "instance": 1.0, "outcome": "ok", "results": {"sure": true, "dist": 3}}',
        Report("nd.goto", 1, "ok", (3.0, True)),
    ),
    ('{"report": "nd.stop", "outcome": "ok"}', Report("nd.stop", 0, "ok")),
    ('{"report": "nd.stop", "outcome": "ok", "status": 7}', Report("nd.stop", 0, "ok")),
    ('{"report": "nd.goto", "outcome": "failed"}', Report("nd.goto", 0, "failed")),
    ('{"report": "nd.goto", "outcome": "failed", "results": 7}', Report("nd.goto", 0, "failed")),
    (
        '{"report": "nd.goto", "outcome": "failed", "status": "lost"}',
        Report("nd.goto", 0, "failed", status="lost"),
    ),
    ('{"report": "nd.goto", "outcome": "interrupted", "status": 1}', Report("nd.goto", 0, "interrupted")),
    ('{"observe": "battery", "value": 7}', Observe("battery", 7)),
    ('{"observe": "nd.speed", "value": 2}', Observe("nd.speed", 2.0)),
    ('{"observe": "nd.speed", "value": 2.1}', Observe("nd.speed", 2.0, broken=True)),
    ('{"observe": "nd.speed", "value": NaN}', Observe("nd.speed", 2.0, broken=True)),
    ('{"observe": "wild", "value": -Infinity}', Observe("wild", 1.5, broken=True)),
    ('{"observe": "wild", "value": 1e999}', Observe("wild", 1.5, broken=True)),
    ('{"observe": "wild", "value": -1%s}' % ("0" * 10_000), Observe("wild", 1.5, broken=True)),
    ('{"observe": "wild", "value": 1%s}' % ("0" * 308), Observe("wild", 1e308)),
    ('{"observe": "wild", "value": 1%s}' % ("0" * 309), Observe("wild", 1.5, broken=True)),
    ('{"observe": "wild", "value": 1e-999}', Observe("wild", 0.0)),
    ('{"observe": "door", "value": "ajar"}', Observe("door", "open", broken=True)),
    ('{"observe": "film", "value": 4}', Observe("film", 4)),
    ('{"abort": "nd.goto", "instance": 1}', Abort("nd.goto", 1)),
    ('{"abort": "nd.goto", "waiting": false}', Abort("nd.goto", 0)),
    ('{"abort": "nd.goto", "waiting": 1}', Abort("nd.goto", 0)),
    ('{"abort": "nd.goto", "waiting": true, "instance": "x"}', AbortWaiting("nd.goto")),
]


@pytest.mark.parametrize(("line", "event"), EVENTS)
def test_events_are_read(line: str, event: Event) -> None:
    for text in (line, line.encode(), b"\xef\xbb\xbf" + line.encode()):
        read = read_event(MODEL, text)
        assert read == event
        assert repr(read) == repr(event), "1 and 1.0 and true are equal, but not the same value"


FAULTS: list[tuple[str | bytes, str]] = [
    # what is no event at all
    ("", "bad-event"),
    ("ask nd.stop", "bad-event"),
    ("[]", "bad-event"),
    ("7", "bad-event"),
    ("null", "bad-event"),
    ("{}", "bad-event"),
    ('{"tick": 1}', "bad-event"),
    ('{"ask": "nd.stop"} {}', "bad-event"),
    ("{'ask': 1}", "bad-event"),
    (b'{"ask": "\xff"}', "bad-event"),
    (b"\x00\x01\x02", "bad-event"),
    ('{"ask": "nd.stop", "x": "\x01"}', "bad-event"),
    ('{"ask": "nd.stop"}' + " " * (MAX_LINE - 17), "bad-event"),
    ('{"ask": "nd.stop", "x": "' + "é" * (MAX_LINE // 2) + '"}', "bad-event"),
    ('{"ask": "nd.stop", "x": ' + "[" * MAX_DEPTH + "]" * MAX_DEPTH + "}", "bad-event"),
    ('{"a":' * 100_000, "bad-event"),
    ("[" * 1_000_000, "bad-event"),
    # the request or poster comes first
    ('{"ask": "nd.fly", "args": []}', "unknown-request"),
    ('{"ask": null}', "unknown-request"),
    ('{"ask": ["nd.stop"]}', "unknown-request"),
    ('{"ask": {}}', "unknown-request"),
    ('{"report": "nd.fly", "instance": true, "outcome": 1}', "unknown-request"),
    ('{"abort": "nd.fly", "instance": true}', "unknown-request"),
    ('{"observe": "rain"}', "unknown-poster"),
    ('{"observe": 1}', "unknown-poster"),
    ('{"observe": "arm.tool", "value": true}', "unknown-poster"),
    ('{"observe": "alarm", "value": true}', "unknown-poster"),
    ('{"observe": "power", "value": 1}', "unknown-poster"),
    # ask: the object, unknown arguments, then each parameter in order
    ('{"ask": "nd.stop", "args": []}', "bad-event"),
    ('{"ask": "nd.stop", "args": null}', "bad-event"),
    ('{"ask": "nd.goto"}', "missing-argument"),
    ('{"ask": "nd.stop", "args": {"x": 1}}', "unknown-argument"),
    ('{"ask": "nd.goto", "args": {"x": "?", "y": 1}}', "unknown-argument"),
    ('{"ask": "nd.goto", "args": {"x": "?", "n": 99}}', "wrong-type"),
    ('{"ask": "nd.goto", "args": {"x": NaN, "n": "?"}}', "out-of-range"),
    ('{"ask": "nd.goto", "args": {"n": "?"}}', "missing-argument"),
    ('{"ask": "nd.goto", "args": {"x": true, "n": 1, "where": "base"}}', "wrong-type"),
    ('{"ask": "nd.goto", "args": {"x": null, "n": 1, "where": "base"}}', "wrong-type"),
    ('{"ask": "nd.goto", "args": {"x": 1e400, "n": 1, "where": "base"}}', "out-of-range"),
    ('{"ask": "nd.goto", "args": {"x": 1%s, "n": 1, "where": "base"}}' % ("0" * 399), "out-of-range"),
    ('{"ask": "nd.goto", "args": {"x": -1%s, "n": 1, "where": "base"}}' % ("0" * 399), "out-of-range"),
    ('{"ask": "nd.goto", "args": {"x": 1, "n": 1.5, "where": "base"}}', "wrong-type"),
    ('{"ask": "nd.goto", "args": {"x": 1, "n": 1.00000000000000000000001, "where": "base"}}', "wrong-type"),
    ('{"ask": "nd.goto", "args": {"x": 1, "n": 1e-400, "where": "base"}}', "wrong-type"),
    ('{"ask": "nd.goto", "args": {"x": 1, "n": -0.5e-99999999999999999999, "where": "base"}}', "wrong-type"),
    ('{"ask": "nd.goto", "args": {"x": 1, "n": false, "where": "base"}}', "wrong-type"),
    ('{"ask": "nd.goto", "args": {"x": 1, "n": Infinity, "where": "base"}}', "out-of-range"),
    ('{"ask": "nd.goto", "args": {"x": 1, "n": NaN, "where": "base"}}', "out-of-range"),
    ('{"ask": "nd.goto", "args": {"x": 1, "n": -1, "where": "base"}}', "out-of-range"),
    ('{"ask": "nd.goto", "args": {"x": 1, "n": 10, "where": "base"}}', "out-of-range"),
    ('{"ask": "nd.goto", "args": {"x": 1, "n": 1e300, "where": "base"}}', "out-of-range"),
    ('{"ask": "nd.goto", "args": {"x": 1, "n": 1%s, "where": "base"}}' % ("0" * 10_000), "out-of-range"),
    ('{"ask": "nd.goto", "args": {"x": 1, "n": 1, "where": "moon"}}', "out-of-range"),
    ('{"ask": "nd.goto", "args": {"x": 1, "n": 1, "where": 1}}', "wrong-type"),
    ('{"ask": "nd.goto", "args": {"x": 1, "n": 1, "where": {}}}', "wrong-type"),
    ('{"ask": "nd.goto", "args": {"x": 1, "\\ud800": 1}}', "unknown-argument"),
    # report: instance, outcome, status, results
    ('{"report": "nd.goto", "instance": "0", "outcome": "?"}', "wrong-type"),
    ('{"report": "nd.goto", "instance": null, "outcome": "?"}', "wrong-type"),
    ('{"report": "nd.goto", "instance": true, "outcome": "?"}', "wrong-type"),
    ('{"report": "nd.goto", "instance": 0.5, "outcome": "?"}', "wrong-type"),
    ('{"report": "nd.goto", "instance": 2, "outcome": "?"}', "out-of-range"),
    ('{"report": "nd.goto", "instance": -1, "outcome": "?"}', "out-of-range"),
    ('{"report": "nd.goto"}', "bad-event"),
    ('{"report": "nd.goto", "outcome": "good"}', "bad-event"),
    ('{"report": "nd.goto", "outcome": ["ok"]}', "bad-event"),
    ('{"report": "nd.goto", "outcome": true}', "bad-event"),
    ('{"report": "nd.goto", "outcome": "failed", "status": "tired"}', "unknown-status"),
    ('{"report": "nd.goto", "outcome": "failed", "status": null}', "unknown-status"),
    ('{"report": "nd.goto", "outcome": "failed", "status": ["lost"]}', "unknown-status"),
    ('{"report": "nd.stop", "outcome": "failed", "status": "lost"}', "unknown-status"),
    ('{"report": "nd.goto", "outcome": "ok", "results": null}', "bad-event"),
    ('{"report": "nd.goto", "outcome": "ok"}', "missing-argument"),
    ('{"report": "nd.stop", "outcome": "ok", "results": {"a": 1}}', "unknown-argument"),
    ('{"report": "nd.goto", "outcome": "ok", "results": {"dist": 201}}', "out-of-range"),
    ('{"report": "nd.goto", "outcome": "ok", "results": {"dist": 1, "sure": 1}}', "wrong-type"),
    # observe: missing, type, range
    ('{"observe": "battery"}', "missing-argument"),
    ('{"observe": "nd.speed"}', "missing-argument"),
    ('{"observe": "battery", "value": "full"}', "wrong-type"),
    ('{"observe": "nd.speed", "value": "fast"}', "wrong-type"),
    ('{"observe": "battery", "value": 9.5}', "wrong-type"),
    ('{"observe": "battery", "value": 101}', "out-of-range"),
    ('{"observe": "estop", "value": 1}', "wrong-type"),
    ('{"observe": "estop", "value": NaN}', "wrong-type"),
    ('{"observe": "film", "value": 5}', "out-of-range"),
    ('{"observe": "film", "value": -1}', "out-of-range"),
    ('{"observe": "film", "value": true}', "wrong-type"),
    # abort: instance
    ('{"abort": "nd.goto", "instance": 2}', "out-of-range"),
    ('{"abort": "nd.goto", "instance": "all"}', "wrong-type"),
    ('{"abort": "nd.goto", "waiting": "true", "instance": 9}', "out-of-range"),
]


@pytest.mark.parametrize(("line", "expected"), FAULTS, ids=lambda value: str(value)[:60])
def test_faults_are_named(line: str | bytes, expected: str) -> None:
    assert code(line) == expected


def test_details_help() -> None:
    assert read_event(MODEL, '{"ask": "nd.gto"}') == Invalid(
        "unknown-request", "there is no request `nd.gto`; did you mean `nd.goto`?"
    )
    assert read_event(MODEL, '{"ask": "nd.goto", "args": {"x": 1, "n": 10}}') == Invalid(
        "out-of-range", "`n` of nd.goto is 10, not an integer in 0 .. 9"
    )


# ---- whatever comes ----

keys = st.sampled_from(
    ["ask", "report", "observe", "abort", "args", "results", "instance", "outcome", "status", "value", "waiting"]
)
words = st.sampled_from(
    ["nd.goto", "nd.stop", "arm.turn", "nd.speed", "wild", "count", "door", "film", "ok", "failed", "interrupted"]
)
leaves = words | st.none() | st.booleans() | st.integers() | st.floats() | st.text()
fields = st.sampled_from(["x", "n", "where", "far", "dist", "sure"])
values: st.SearchStrategy[Any] = st.recursive(
    leaves | st.integers(0, 3),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(fields | st.text(), inner, max_size=4),
)
objects = st.dictionaries(keys | st.text(), values, max_size=6)


@given(objects)
def test_every_object_is_an_event_or_a_fault(entries: dict[str, Any]) -> None:
    event = read_event(MODEL, json.dumps(entries))
    if isinstance(event, Invalid):
        assert event.code in {
            "bad-event", "unknown-request", "unknown-poster", "unknown-argument", "missing-argument", "wrong-type",
            "out-of-range", "unknown-status",
        }  # fmt: skip
        json.loads(answer_line(MODEL, 1, [event]).encode())
    else:
        assert read_event(MODEL, json.dumps(event_json(MODEL, event))) == event


@given(st.binary() | st.text())
def test_every_line_is_an_event_or_a_fault(line: str | bytes) -> None:
    assert isinstance(read_event(MODEL, line), Event | Invalid)


def of(kind: Type) -> st.SearchStrategy[Any]:
    match kind:
        case Bool():
            return st.booleans()
        case Int(low, high):
            return st.integers(low, high)
        case Real(low, high):
            bounds = (None if math.isinf(low) else low, None if math.isinf(high) else high)
            return st.floats(*bounds, allow_nan=False, allow_infinity=False)
        case Enum(names):
            return st.sampled_from(names)


@st.composite
def events(draw: st.DrawFn) -> Event:
    request = draw(st.sampled_from(MODEL.requests))
    slot = draw(st.integers(0, request.instances - 1))
    poster = draw(st.sampled_from([v for v in MODEL.variables if v.kind == "poster"]))
    args = tuple(draw(of(parameter.type)) for parameter in request.params)
    results = tuple(draw(of(parameter.type)) for parameter in request.results)
    choices: list[Event] = [
        Ask(request.name, args),
        Report(request.name, slot, "ok", results),
        Report(request.name, slot, "failed", status=draw(st.sampled_from([None, *request.statuses]))),
        Report(request.name, slot, "interrupted"),
        Observe(poster.name, draw(of(poster.type))),
        Observe("film", draw(st.integers(0, 4))),
        Abort(request.name, slot),
        AbortWaiting(request.name),
    ]
    if poster.fallback is not None:
        choices.append(Observe(poster.name, poster.fallback, broken=True))
    return draw(st.sampled_from(choices))


@given(events())
def test_events_survive_being_written_and_read(event: Event) -> None:
    line = json.dumps(event_json(MODEL, event), allow_nan=False)
    assert read_event(MODEL, line) == event


# ---- answers ----

ANSWERS = [
    (
        Launched("nd.goto", 1, (2.0, 3, "dock")),
        '{"launch": "nd.goto", "instance": 1, "args": {"x": 2, "n": 3, "where": "dock"}}',
    ),
    (
        Launched("arm.turn", 0, (-3,), "home", "go"),
        '{"launch": "arm.turn", "instance": 0, "args": {"far": -3}, "rule": "home", "because": "go"}',
    ),
    (Launched("nd.stop", 0, (), "home"), '{"launch": "nd.stop", "instance": 0, "args": {}, "rule": "home"}'),
    (Waits("nd.stop", "drive"), '{"wait": "nd.stop", "rule": "drive"}'),
    (Waits("nd.stop", "drive", ""), '{"wait": "nd.stop", "rule": "drive", "because": ""}'),
    (Rejected("nd.stop", "busy"), '{"reject": "nd.stop", "rule": "busy"}'),
    (Killed("nd.goto", 1, "x", "die Tür"), '{"kill": "nd.goto", "instance": 1, "rule": "x", "because": "die Tür"}'),
    (Violated("crush", "why"), '{"violation": "crush", "because": "why"}'),
    (Invalid("not-active"), '{"invalid": "not-active"}'),
    (Invalid("bad-event", 'a "\ud800"'), '{"invalid": "bad-event", "detail": "a \\"\\ud800\\""}'),
]


@pytest.mark.parametrize(("action", "text"), ANSWERS)
def test_answers_are_written(action: Any, text: str) -> None:
    line = answer_line(MODEL, 7, [action, action])
    assert line == f'{{"step": 7, "actions": [{text}, {text}]}}'
    assert json.loads(line.encode()) == {"step": 7, "actions": [action_json(MODEL, action)] * 2}


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (2.0, "2"),
        (-0.0, "0"),
        (0.1, "0.1"),
        (9e15, "9000000000000000"),
        (1e16, "1e+16"),
        (-1e300, "-1e+300"),
        (1e-7, "1e-07"),
    ],
)
def test_whole_reals_have_no_fraction(value: float, text: str) -> None:
    assert f'"x": {text},' in answer_line(MODEL, 1, [Launched("nd.goto", 0, (value, 3, "dock"))])
    assert json.loads(text) == value
