"""The man in the middle, message by message: hostile ones, and what each side is told."""

import json
from typing import Any

import pytest

from exover.gate.mcp.lines import LineCutter
from tests.gate.carts import BIND, SPEC, model_of
from tests.gate.middle import IDLE, Middle

MOVE = {"command": "move", "speed_percent": 50}
MOVING = {"base": {"phase": "moving", "metres": 0, "speed_mm": 500}, "paint": 5}
ARRIVED = {"base": {"phase": "arrived", "metres": 2, "speed_mm": 0}, "paint": 5}
OK = {"content": [{"type": "text", "text": "done"}]}
FAILED = {**OK, "isError": True}


def rule(response: dict[str, Any]) -> str:
    assert response["result"]["isError"] is True
    return str(response["result"]["_meta"]["exover/rule"])


def test_everything_is_denied_until_the_watch_has_answered() -> None:
    middle = Middle()
    middle.call(1, "brake")
    assert rule(middle.client_got()[0]) == "starting" and not middle.server_got()
    middle.ready()
    middle.call(2, "brake")
    (call,) = middle.server_got()
    assert call["params"]["name"] == "brake" and call["id"] != 2 and not middle.client_got()
    middle.answer(call, OK)
    assert middle.client_got() == [{"jsonrpc": "2.0", "id": 2, "result": OK}]


def test_what_runs_at_the_start_is_stopped_first() -> None:
    middle = Middle().ready(MOVING)
    (halt,) = middle.server_got()
    assert halt["params"]["arguments"] == {"command": "halt"} and middle.alarms() == ["stray"]
    middle.call(1, "brake")
    assert rule(middle.client_got()[0]) == "starting"
    middle.watched(IDLE)
    middle.call(2, "brake")
    assert len(middle.server_got()) == 1


def test_a_motion_that_is_only_started_ends_when_the_watch_says_so() -> None:
    middle = Middle().ready(ARRIVED)
    middle.call("m", "drive", MOVE)
    (start,) = middle.server_got()
    middle.watched(ARRIVED)  # of the motion before
    middle.answer(start, OK)
    assert middle.client_got()[0]["id"] == "m"
    assert ("base.move", 0) in middle.gate.state.slots
    middle.watched(MOVING)
    middle.watched(ARRIVED)
    assert ("base.move", 0) not in middle.gate.state.slots
    assert middle.journal[-1] == {
        "event": {"report": "base.move", "instance": 0, "outcome": "ok", "results": {"distance": 2}},
        "actions": [],
    }


def test_a_status_that_nobody_knows_ends_nothing() -> None:
    middle = Middle().ready()
    middle.call(1, "drive", MOVE)
    middle.answer(middle.server_got()[0], OK)
    for _ in range(2):
        middle.watched({"base": {"phase": ["moving"], "speed_mm": 0}, "paint": 5})
    assert ("base.move", 0) in middle.gate.state.slots and middle.alarms() == ["unknown-status"]


def test_a_failure_has_its_name() -> None:
    middle = Middle().ready()
    middle.call(1, "drive", MOVE)
    middle.answer(middle.server_got()[0], OK)
    middle.watched(MOVING)
    middle.watched({"base": {"phase": "bumper", "speed_mm": 0}, "paint": 5})
    assert middle.journal[-1]["event"] == {
        "report": "base.move",
        "instance": 0,
        "outcome": "failed",
        "status": "blocked",
    }


def test_a_reading_that_is_not_there_is_told_once_where_nothing_stands_for_it() -> None:
    middle = Middle(model=model_of(SPEC.replace("else 2", ""))).ready()
    for base in ({}, {}, {"speed_mm": "fast"}, {"speed_mm": 500}, {}):
        middle.watched({**IDLE, "base": {"phase": "halted", "metres": 0, **base}})
    details = [each["detail"] for each in middle.journal if "alarm" in each]
    missing, text = "base.speed: `base.speed_mm` is missing", "base.speed: `base.speed_mm` is no number"
    assert middle.alarms() == ["invalid"] * 3 and details == [missing, text, missing]
    worst = Middle().ready()
    worst.watched({**IDLE, "base": {"phase": "halted", "metres": 0}})
    assert not worst.alarms() and worst.journal[-1]["event"] == {"observe": "base.speed", "value": 3}


def test_a_watch_that_is_silent_reads_the_worst() -> None:
    middle = Middle().ready()
    middle.now += 0.1
    middle.proxy.tick()
    middle.now += 2
    middle.proxy.tick()
    assert middle.alarms() == ["blind"]
    broken = [entry for entry in middle.journal if entry.get("actions", [{}])[:1] == [
        {"invalid": "out-of-range", "detail": "taken as 2.0"}
    ]]  # fmt: skip
    assert len(broken) == 1
    (poll,) = middle.server_got()[-1:]
    middle.answer(poll, {"content": [], "structuredContent": IDLE})
    assert middle.journal[-2]["event"] == {"observe": "base.speed", "value": 0}


@pytest.mark.parametrize("begin", [(), ("initialize",)])
def test_a_client_that_does_not_begin_its_session_switches_no_poster_off(begin: tuple[str, ...]) -> None:
    bind = BIND.replace('start = "idle"', 'start = "idle"\nclient-death = "leave"').replace("started = true\n", "")
    bind = bind[: bind.index('[request."base.move".report]')] + bind[bind.index('[request."base.stop"]') :]
    middle = Middle(bind)
    for method in begin:
        middle.client({"id": "i", "method": method, "params": {}})
        middle.answer(middle.server_got()[0], {})
        middle.client_got()
    assert middle.gate.state.started and middle.proxy.due == 2.0
    middle.call(1, "grip", {"force": 1})
    assert rule(middle.client_got()[0]) == "starting" and middle.journal[-1]["rule"] == "starting"
    middle.now = 2.0
    middle.proxy.tick()
    assert middle.alarms() == ["blind"]
    assert middle.journal[-1]["actions"] == [{"invalid": "out-of-range", "detail": "taken as 2.0"}]
    middle.call(2, "grip", {"force": 1})
    assert rule(middle.client_got()[0]) == "starting" and not middle.server_got()
    middle.ready()
    middle.call(3, "grip", {"force": 1})
    assert [call["params"]["name"] for call in middle.server_got()] == ["grip"] and middle.alarms() == ["blind"]


def test_two_calls_of_one_id_do_not_mix() -> None:
    middle = Middle().ready()
    middle.call(1, "grip", {"force": 1})
    middle.call(1, "grip", {"force": 2})
    middle.call("1", "grip", {"force": 3})
    first, second = middle.server_got()
    (refused,) = middle.client_got()
    assert refused["id"] is None and refused["error"]["code"] == -32600
    middle.answer(second, {**OK, "n": 3})
    middle.answer(first, {**OK, "n": 1})
    assert [(each["id"], each["result"]["n"]) for each in middle.client_got()] == [("1", 3), (1, 1)]
    middle.answer(first, OK)
    middle.server({"id": 999, "result": {}})
    assert not middle.client_got() and len([each for each in middle.complaints if "dropped" in each]) == 2


@pytest.mark.parametrize(
    ("line", "code"),
    [
        (b"{", -32700),
        (b"\xff\xfe", -32700),
        (b'{"jsonrpc": "2.0", "id": 1, "method": "x", "params": {"a": NaN}}', -32700),
        (b'{"jsonrpc": "2.0", "id": 1, "method": "x", "params": {"a": 1e999}}', -32700),
        (b'{"jsonrpc": "2.0", "id": 1, "method": "x", "params": {"a": ' + b"9" * 5000 + b"}}", -32700),
        (b'{"jsonrpc": "2.0", "id": 1, "method": "tools/call", "method": "ping"}', -32600),
        (b"[" * 100_000, -32700),
        (b'{"jsonrpc": "2.0", "id": 1, "method": "x", "params": ' + b'{"a":' * 200 + b"[]" + b"}" * 201, -32700),
        (b'[{"jsonrpc": "2.0", "id": 1, "method": "ping"}]', -32600),
        (b"3", -32600),
        (b'{"id": 1, "method": "ping"}', -32600),
        (b'{"jsonrpc": "2.0", "id": null, "method": "ping"}', -32600),
        (b'{"jsonrpc": "2.0", "id": true, "method": "ping"}', -32600),
        (b'{"jsonrpc": "2.0", "id": 1}', -32600),
        (b'{"jsonrpc": "2.0", "id": 1, "result": {}, "error": {}}', -32600),
        (b'{"jsonrpc": "2.0", "id": 1, "method": "tools/call"}', -32602),
        (b'{"jsonrpc": "2.0", "id": 1, "method": "tools/call", "params": {"name": "grip", "arguments": 3}}', -32602),
        (b'{"jsonrpc": "2.0", "id": 1, "method": "' + b"x" * (5 << 20) + b'"}', -32600),
    ],
)
def test_a_bad_message_is_answered_and_not_passed(line: bytes, code: int) -> None:
    middle = Middle().ready()
    middle.proxy.from_client(line)
    (answer,) = middle.client_got()
    assert answer["error"]["code"] == code and not middle.server_got()
    middle.proxy.from_server(line if b"tools/call" not in line else b"?")
    assert not middle.client_got()


def test_what_is_not_nested_too_deep_is_passed() -> None:
    middle = Middle().ready()
    params: dict[str, Any] = {}
    for _ in range(198):
        params = {"a": params}
    middle.client({"id": 1, "method": "x", "params": params})
    middle.client({"id": 2, "method": "x", "params": {"a": [[]] * 300}})
    assert [len(json.dumps(call["params"])) > 900 for call in middle.server_got()] == [True, True]


def test_a_long_line_is_cut_and_what_follows_is_read() -> None:
    cutter = LineCutter(10)
    found = [line for part in (b"ab\nx", b"y" * 100, b"z" * 100 + b"\nc", b"d\n\n") for line in cutter.feed(part)]
    assert found == [b"ab", b"x" + b"y" * 10, b"cd", b""]


@pytest.mark.parametrize(
    ("name", "arguments", "expected"),
    [
        ("grip", {"force": 3.5}, "wrong-type"),
        ("grip", {"force": "3"}, "wrong-type"),
        ("grip", {"force": 11}, "out-of-range"),
        ("grip", {"force": 10**300}, "out-of-range"),
        ("grip", {"force": None}, "wrong-type"),
        ("grip", {}, "unreadable"),
        ("reach", {"hand": "left"}, "unreadable"),
        ("drive", {"command": "move", "speed_percent": True}, "unreadable"),
        ("drive", {"command": "move", "speed_percent": 1e308}, "out-of-range"),
        ("drive", {"command": "MOVE"}, "unbound"),
        ("self_destruct", {}, "unbound"),
    ],
)
def test_a_call_that_cannot_be_read_is_refused(name: str, arguments: dict[str, Any], expected: str) -> None:
    middle = Middle().ready()
    middle.call(1, name, arguments)
    assert rule(middle.client_got()[0]) == expected and not middle.server_got()
    assert middle.journal[-1]["rule"] == expected


@pytest.mark.parametrize(
    ("params", "refused"),
    [
        ({"name": "brake", "arguments": {}}, "base.stop"),
        ({"name": "drive", "arguments": MOVE}, "base.move"),
        ({"name": "drive", "arguments": {"command": "halt"}}, "drive"),
        ({"name": "release", "arguments": {}}, "release"),
        ({"name": "get_state"}, "get_state"),
        ({"name": ["brake"], "arguments": 3}, "tools/call"),
    ],
)
def test_a_call_without_an_id_does_not_reach_the_server(params: dict[str, Any], refused: str) -> None:
    middle = Middle().ready()
    middle.client({"method": "tools/call", "params": params})
    assert not middle.server_got() and not middle.client_got()
    assert middle.complaints == ["a message of the client was dropped: 'tools/call' without an id"]
    assert middle.journal[-1] == {
        "refused": refused,
        "rule": "unreadable",
        "because": "it has no id, so it cannot be answered",
    }
    middle.call(1, "brake")
    assert [call["params"]["name"] for call in middle.server_got()] == ["brake"]


def test_what_wants_an_answer_and_has_no_id_is_dropped() -> None:
    middle = Middle().ready()
    decided = list(middle.journal)
    for method in ("resources/read", "tasks/result", "tools/call/", "Tools/Call", "initialize"):
        middle.client({"method": method, "params": {"name": "brake", "arguments": {}}})
    assert not middle.server_got() and not middle.client_got() and middle.journal == decided
    assert len(middle.complaints) == 5
    middle.client({"method": "notifications/roots/list_changed"})
    assert [each["method"] for each in middle.server_got()] == ["notifications/roots/list_changed"]


def test_a_notification_with_an_id_is_refused() -> None:
    middle = Middle().ready()
    middle.call("g", "grip", {"force": 1})
    (call,) = middle.server_got()
    middle.client({"id": 4, "method": "notifications/cancelled", "params": {"requestId": call["id"]}})
    (answer,) = middle.client_got()
    assert (answer["id"], answer["error"]["code"]) == (4, -32600) and not middle.server_got()


def test_a_call_as_a_task_is_refused() -> None:
    middle = Middle().ready()
    middle.call(1, "brake", {}, task={"ttl": 60000})
    assert rule(middle.client_got()[0]) == "unreadable" and not middle.server_got()


def test_a_call_that_waits_says_so_and_has_a_deadline() -> None:
    middle = Middle().ready()
    middle.call(1, "drive", MOVE)
    middle.answer(middle.server_got()[0], OK)
    middle.client_got()
    middle.call(2, "reach", {"hand": "l"}, _meta={"progressToken": "t"})
    (progress,) = middle.client_got()
    assert progress["params"]["progressToken"] == "t" and "arm.reach.wait.1" in progress["params"]["message"]
    middle.watched(MOVING)
    middle.now += 30
    middle.proxy.tick()
    late = [each for each in middle.client_got() if each.get("id") == 2]
    assert rule(late[0]) == "deadline" and not middle.gate.state.places


def test_a_client_cancels_only_what_is_its_own() -> None:
    middle = Middle().ready()
    middle.call(101, "get_state")
    middle.call(102, "reach", {"hand": "l"})
    passed, carried = middle.server_got()
    for id in (passed["id"], carried["id"], 77, None, [1], "102"):
        middle.client({"method": "notifications/cancelled", "params": {"requestId": id}})
    assert not [each for each in middle.server_got() if each["method"] == "notifications/cancelled"]
    middle.client({"method": "notifications/cancelled", "params": {"requestId": 101}})
    (cancelled,) = middle.server_got()
    assert cancelled["params"]["requestId"] == passed["id"]
    middle.client({"method": "notifications/cancelled", "params": {"requestId": 102}})
    (stow,) = middle.server_got()
    assert stow["params"]["name"] == "stow" and ("arm.reach", 0) in middle.gate.state.slots
    middle.answer(stow, OK)
    assert ("arm.reach", 0) not in middle.gate.state.slots and not middle.client_got()


def test_a_module_that_refuses_to_stop_stays_active() -> None:
    middle = Middle().ready()
    middle.call(1, "reach", {"hand": "l"})
    middle.client({"method": "notifications/cancelled", "params": {"requestId": 1}})
    middle.answer(middle.server_got()[-1], FAILED)
    assert middle.alarms() == ["refuses-to-stop"] and middle.gate.state.slots["arm.reach", 0].phase == "stopping"
    middle.now += 5
    middle.proxy.tick()
    assert "does-not-stop" in middle.alarms() and ("arm.reach", 0) in middle.gate.state.slots
    middle.call(2, "reach", {"hand": "l"})
    assert rule(middle.client_got()[0]) == "busy"


def test_the_answer_to_a_stop_ends_no_later_launch() -> None:
    middle = Middle().ready()
    stops = []
    for id in (1, 2):
        middle.call(id, "reach", {"hand": "l"})
        (reach,) = middle.server_got()
        middle.client({"method": "notifications/cancelled", "params": {"requestId": id}})
        stops += middle.server_got()
        if id == 1:
            middle.answer(reach, OK)  # it has ended by itself, before its stop is answered
            assert ("arm.reach", 0) not in middle.gate.state.slots
    middle.answer(stops[0], OK)
    assert ("arm.reach", 0) in middle.gate.state.slots
    middle.answer(stops[1], OK)
    assert ("arm.reach", 0) not in middle.gate.state.slots


def test_what_the_watch_was_asked_before_a_launch_says_nothing_of_it() -> None:
    bind = BIND.replace('{ command = "halt" } }', '{ command = "halt" }, ends = true }')
    middle = Middle(bind).ready(ARRIVED)
    middle.call(1, "drive", MOVE)
    middle.answer(middle.server_got()[0], OK)
    middle.watched(MOVING)
    before = middle.polled()
    middle.call(2, "brake")
    (halt,) = middle.server_got()
    middle.answer(halt, OK)
    (brake,) = middle.server_got()
    middle.answer(brake, OK)
    middle.call(3, "drive", MOVE)
    (drive,) = middle.server_got()
    middle.shown(before, MOVING)  # as the first drive did
    middle.watched(ARRIVED)  # the second does not move yet
    assert ("base.move", 0) in middle.gate.state.slots
    middle.answer(drive, OK)
    middle.watched(MOVING)
    middle.watched(ARRIVED)
    assert ("base.move", 0) not in middle.gate.state.slots and not middle.alarms()


def test_a_level_is_what_the_watch_shows_also_where_a_report_has_raised_it() -> None:
    gives = SPEC.replace("instances 2;", "instances 2 { produces paint 3; }")
    middle = Middle(model=model_of(gives.replace("stop() {", "stop() { consumes paint 1;"))).ready({**IDLE, "paint": 0})
    middle.call(1, "grip", {"force": 3})
    (grip,) = middle.server_got()
    middle.answer(grip, {"content": []})
    middle.watched({**IDLE, "paint": 0})  # nothing was filled in, whatever was reported
    middle.watched({**IDLE, "paint": 0})
    observed = [entry["event"] for entry in middle.journal if entry.get("event", {}).get("observe") == "paint"]
    assert observed == 2 * [{"observe": "paint", "value": 0}]  # once more than it was shown anew
    middle.call(2, "brake")
    assert not middle.server_got() and "refused by paint" in json.dumps(middle.client_got())


def test_what_ran_when_the_watch_was_asked_is_no_stray_once_it_has_ended() -> None:
    middle = Middle(BIND.replace('{ command = "halt" } }', '{ command = "halt" }, ends = true }')).ready(ARRIVED)
    middle.call(1, "drive", MOVE)
    middle.answer(middle.server_got()[0], OK)
    before = middle.polled()
    middle.call(2, "brake")
    (halt,) = middle.server_got()
    middle.answer(halt, OK)
    middle.shown(before, MOVING)
    assert not middle.alarms()
    middle.watched(MOVING)
    assert middle.alarms() == ["stray"]


def test_only_the_latest_call_of_a_watch_is_heard() -> None:
    middle = Middle().ready()
    middle.call(1, "drive", MOVE)
    (drive,) = middle.server_got()
    first = middle.polled()
    middle.answer(drive, OK)
    second = middle.polled(after=2)
    middle.shown(first, {**ARRIVED, "paint": 1})
    assert ("base.move", 0) in middle.gate.state.slots and middle.gate.state.readings == {}
    middle.shown(second, {**MOVING, "paint": 2})
    middle.shown(first, {**ARRIVED, "paint": 1})
    assert ("base.move", 0) in middle.gate.state.slots
    read = [each["event"]["value"] for each in middle.journal if each.get("event", {}).get("observe") == "paint"]
    assert read[-1] == 2 and 1 not in read
    assert middle.complaints.count("an answer of the server was dropped: nobody waits for it") == 2


def test_a_killed_call_is_told_its_rule() -> None:
    bind = BIND.replace("started = true\n", "").replace('[request."base.move".report]', "[request.x]")
    bind = bind[: bind.index("[request.x]")] + bind[bind.index('[request."base.stop"]') :]
    bind = bind.replace('{ command = "halt" } }', '{ command = "halt" }, ends = true }')
    middle = Middle(bind).ready()
    middle.call(1, "drive", MOVE)
    middle.call(2, "brake")
    _, halt = middle.server_got()
    middle.answer(halt, OK)
    (stopped,) = middle.client_got()
    assert stopped["id"] == 1 and rule(stopped) == "base.stop.interrupts.base.move"
    assert middle.server_got()[0]["params"]["name"] == "brake"


def test_input_that_a_tool_wants_ends_its_call() -> None:
    middle = Middle().ready()
    middle.call(1, "brake")
    wants = {"resultType": "input_required", "requestState": "s"}
    middle.answer(middle.server_got()[0], wants)
    assert middle.client_got()[0]["result"] == wants and not middle.gate.state.slots
    assert middle.journal[-1]["event"]["outcome"] == "interrupted"


def test_requests_of_the_server_get_ids_of_the_gate() -> None:
    middle = Middle().ready()
    middle.server({"id": 1, "method": "roots/list"})
    (asked,) = middle.client_got()
    middle.client({"id": 1 if asked["id"] != 1 else 2, "result": {"roots": ["forged"]}})
    assert not middle.server_got()
    middle.client({"id": asked["id"], "result": {"roots": []}})
    assert middle.server_got() == [{"jsonrpc": "2.0", "id": 1, "result": {"roots": []}}]
    middle.server({"id": "x", "method": "roots/list"})
    number = middle.client_got()[0]["id"]
    middle.server({"method": "notifications/cancelled", "params": {"requestId": "x"}})
    assert middle.client_got()[0]["params"]["requestId"] == number


def test_methods_may_be_denied() -> None:
    middle = Middle(BIND.replace('spec = "cart"', 'spec = "cart"\nmethods = "deny"')).ready()
    middle.client({"id": 1, "method": "resources/read", "params": {"uri": "x"}})
    middle.client({"id": 2, "method": "ping"})
    assert middle.client_got()[0]["error"]["code"] == -32601
    assert [each["method"] for each in middle.server_got()] == ["ping"]


def test_when_the_server_is_gone_everybody_is_told() -> None:
    middle = Middle().ready()
    middle.call(1, "drive", MOVE)
    middle.call(2, "get_state")
    middle.call(3, "reach", {"hand": "l"})
    middle.client_got()
    middle.proxy.server_gone()
    answers = {each["id"]: each for each in middle.client_got()}
    assert rule(answers[1]) == rule(answers[3]) == "unavailable" and answers[2]["error"]["code"] == -32000
    middle.call(4, "get_state")
    middle.call(5, "brake")
    middle.proxy.tick()
    answers = {each["id"]: each for each in middle.client_got()}
    assert answers[4]["error"]["code"] == -32000 and rule(answers[5]) == "unavailable"
    assert middle.gate.state.slots["base.move", 0].lost


@pytest.mark.parametrize(
    "wrong", [{"error": None}, {"error": "x"}, {"result": OK, "error": {}}, {"result": OK, "error": 1}]
)
def test_an_answer_that_is_none_ends_nothing(wrong: dict[str, Any]) -> None:
    middle = Middle().ready()
    middle.call(1, "reach", {"hand": "l"})
    (reach,) = middle.server_got()
    middle.server({"id": reach["id"], **wrong})
    assert ("arm.reach", 0) in middle.gate.state.slots and not middle.client_got()
    assert middle.complaints == [
        "a message of the server was dropped: the message is no request, notification or response"
    ]
    middle.answer(reach, OK)
    assert ("arm.reach", 0) not in middle.gate.state.slots


def test_a_flood_is_held_back() -> None:
    middle = Middle().ready()
    for number in range(1100):
        middle.call(number, "get_state")
    assert len(middle.server_got()) == 1000 and len(middle.client_got()) == 100


def test_a_launch_rule_makes_a_call_of_its_own() -> None:
    model = model_of(SPEC.replace("resource paint", "launch go: base.move(0.5) when level(paint) < 2;\nresource paint"))
    middle = Middle(BIND, model).ready()
    middle.watched({**IDLE, "paint": 1})
    (own,) = middle.server_got()
    assert own["params"] == {"name": "drive", "arguments": {"speed_percent": 50, "command": "move"}}
    middle.answer(own, OK)
    middle.watched(MOVING)
    assert not middle.client_got() and ("base.move", 0) in middle.gate.state.slots


def test_whatever_either_side_says_the_gate_goes_on() -> None:
    """Messages with parts taken out or replaced, from both sides."""
    base: list[dict[str, Any]] = [
        {
            "id": 7,
            "method": "tools/call",
            "params": {"name": "drive", "arguments": MOVE, "_meta": {"progressToken": 1}},
        },
        {"id": 8, "method": "tools/list", "params": {}},
        {"method": "notifications/cancelled", "params": {"requestId": 7}},
        {"id": 5, "result": {"tools": [{"name": "drive"}, 3, {"name": []}]}},
        {"id": 6, "result": {"content": [{"text": "{"}, 3, {"text": 4}], "isError": "no"}},
        {"id": 9, "error": {"code": 1, "message": "x"}},
    ]
    odd: list[Any] = [None, True, -1, 1e300, "x" * 100, [], {}, [[1]], {"name": {"a": 1}}]
    middle = Middle().ready()
    for body in base:
        for key in body:
            for value in odd:
                changed = {**body, key: value}
                middle.client(changed)
                middle.server(changed)
        for key in body.get("params", {}):
            for value in odd:
                middle.client({**body, "params": {**body["params"], key: value}})
                middle.server({**body, "params": {**body["params"], key: value}})
    for line in middle.server_got() + middle.client_got():
        assert json.dumps(line)


def test_what_stops_is_sent_as_a_stateless_session_wants_it() -> None:
    meta = {"io.modelcontextprotocol/protocolVersion": "é"}
    middle = Middle().ready()
    middle.call(1, "grip", {"force": 1}, _meta={**meta, "progressToken": 1})
    middle.server_got()
    middle.client({"method": "notifications/cancelled", "params": {"requestId": 1}})
    (stop,) = middle.server_got()
    assert stop == {
        "jsonrpc": "2.0",
        "method": "tools/call",
        "params": {"name": "open", "arguments": {}, "_meta": meta},
        "id": stop["id"],
    }
