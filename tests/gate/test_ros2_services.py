"""The proxy of ROS 2 without DDS: services, topics, launch rules, and what a binding can be served."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rosbags", reason="the extra exover[ros2] is not installed")

from exover.gate.fields import UnreadableField
from exover.gate.ros2 import cdr
from exover.gate.ros2.checking import mistakes, unmade
from exover.gate.ros2.files import finder
from exover.gate.ros2.interfaces import Interfaces, UnknownType
from exover.gate.ros2.names import Port
from tests.gate.carts import binding_of, model_of
from tests.gate.ros_middle import RosMiddle, known, yard
from tests.gate.yard import BIND

HALT, DRIVE = "/gated/halt", "/gated/drive"
RESPONSE = "yard_msgs/srv/Halt_Response"
LAUNCHING = """spec yard;
module base {
    poster battery: real in 0 .. 1 = 1 else 0;
    request drive(x: real in -10 .. 10);
}
launch home: base.drive(-1.5) when base.battery < 0.2;
"""
LAUNCHING_BIND = "\n".join(BIND.split("\n[request")[0:2]).replace('."base.drive"]', '[request."base.drive"]')


def answers(yard: RosMiddle) -> list[tuple[int, Mapping[str, Any]]]:
    """Return what clients of the service were answered, and to whom."""
    return [(peer, dict(yard.types.read(RESPONSE, data[20:]))) for data, peer in yard.got("outer", "/halt", "call")]


def halted(yard: RosMiddle, success: bool) -> None:
    """Let the server answer what it was asked."""
    ((asked, _),) = yard.got("inner", HALT, "call")
    yard.serve(HALT, "call", asked, yard.types.write(RESPONSE, [(("success",), success), (("message",), "it says")]))


@pytest.mark.parametrize("success", [True, False])
def test_a_call_goes_through_and_is_answered_as_it_is(success: bool) -> None:
    yard = RosMiddle().ready()
    yard.client("/halt", "call", b"\5", peer=3)
    halted(yard, success)
    assert answers(yard) == [(3, {"success": success, "message": "it says"})]
    assert yard.journal[-1]["event"]["outcome"] == ("ok" if success else "failed")


def test_a_call_waits_without_an_answer_until_its_way_is_clear() -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    yard.take_goal(DRIVE)
    yard.client("/halt", "call", b"\5")
    assert not yard.got("inner", HALT, "call") and not answers(yard)
    assert yard.got("inner", DRIVE, "cancel_goal")
    yard.end(DRIVE, cdr.CANCELED)
    halted(yard, True)
    assert len(answers(yard)) == 1


def test_a_refusal_is_what_the_binding_says() -> None:
    yard = RosMiddle().ready()
    yard.client("/halt", "call", b"\5")
    yard.client("/halt", "call", b"\5", peer=4)
    assert answers(yard) == [(4, {"success": False, "message": "refused by busy"})]


def test_a_service_cannot_be_cancelled_and_its_death_is_told() -> None:
    yard = RosMiddle().ready()
    yard.client("/halt", "call", b"\5")
    yard.proxy.client_gone(1)
    assert yard.alarms() == ["refuses-to-stop"] and yard.gate.state.slots["base.halt", 0].phase == "stopping"
    yard.proxy.servers("service", HALT, frozenset())
    yard.client("/halt", "call", b"\5", peer=2)
    assert answers(yard)[-1][1]["message"].startswith("refused by unavailable")
    yard.proxy.servers("service", HALT, frozenset({"server"}))
    assert yard.gate.state.slots["base.halt", 0].lost  # the same process: it may be at it still
    yard.proxy.servers("service", HALT, frozenset())
    yard.proxy.servers("service", HALT, frozenset({"another"}))
    assert not yard.gate.state.slots


def test_a_call_whose_server_dies_is_answered() -> None:
    yard = RosMiddle().ready()
    yard.client("/halt", "call", b"\5")
    yard.proxy.servers("service", HALT, frozenset())
    assert answers(yard) == [(1, {"success": False, "message": "refused by unavailable: its module is not there"})]


def test_an_answer_that_comes_after_the_network_was_cut_says_that_the_call_has_ended() -> None:
    yard = RosMiddle().ready()
    yard.client("/halt", "call", b"\5")
    (asked,) = yard.got("inner", HALT, "call")
    answer = yard.types.write(RESPONSE, [(("success",), True)])
    yard.proxy.servers("service", HALT, frozenset())
    yard.serve(HALT, "call", asked[0], answer)  # of a server that is not there, nothing is believed
    yard.proxy.servers("service", HALT, frozenset({"server"}))
    assert yard.gate.state.slots["base.halt", 0].lost
    yard.serve(HALT, "call", asked[0], answer)
    assert not yard.gate.state.slots and len(answers(yard)) == 1
    yard.client("/halt", "call", b"\5")
    halted(yard, True)
    assert answers(yard)[-1][1]["success"]


def test_a_topic_is_a_poster() -> None:
    yard = RosMiddle().ready()

    def battery(level: float) -> None:
        body = yard.types.write("yard_msgs/msg/Battery", [(("level",), level)])
        yard.proxy.take(Port("inner", "/battery", "message"), cdr.topic(body))

    battery(5.0)
    assert yard.journal[-1]["event"] == {"observe": "base.battery", "value": pytest.approx(0.05)}
    before = len(yard.journal)
    battery(5.0)
    assert len(yard.journal) == before  # nothing new
    battery(float("nan"))
    assert yard.journal[-1]["actions"][0]["invalid"] == "out-of-range"  # and is read as its `else` value
    assert yard.accepted("/drive", yard.drive(1)) is False
    yard.now = 60
    yard.proxy.tick()
    assert yard.alarms()[-1] == "blind"


def test_a_launch_rule_makes_a_goal_of_the_gate() -> None:
    from exover.gate.gate import Gate
    from exover.gate.ros2.proxy import Ros2Proxy
    from exover.ocrd.machine import Machine
    from exover.pipeline import build

    model, bind = model_of(LAUNCHING), LAUNCHING_BIND
    sent: list[tuple[Port, bytes, int]] = []
    gate = Gate(model, binding_of(bind, model), Machine(model, build(model).tables), lambda: 0.0, lambda entry: None)
    made = (lambda: cdr.NEVER), (lambda: b"i" * 16), b"the gate"
    proxy = Ros2Proxy(gate, known(), lambda *each: sent.append(each), print, *made)
    proxy.start()
    proxy.servers("action", DRIVE, frozenset({"server"}))
    question = sent.pop()[1]
    answer = cdr.service(question[4:20], cdr.cancel_reply(0, ()))
    proxy.take(Port("inner", DRIVE, "status"), cdr.topic(cdr.statuses(())))
    proxy.take(Port("inner", DRIVE, "cancel_goal"), answer)
    level = known().write("yard_msgs/msg/Battery", [(("level",), 10.0)])
    proxy.take(Port("inner", "/battery", "message"), cdr.topic(level))
    port, data, _ = sent.pop()
    assert port.part == "send_goal" and data[20:36] == b"i" * 16
    assert known().read("yard_msgs/action/Drive_Goal", data[36:])["x"] == -1.5


# ---- types and names ----


def told(bind: str, apart: bool = False) -> list[str]:
    return list(mistakes(binding_of(bind, yard().model), known(), apart))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('inner = "/gated/drive"', "", "`/drive` is the outer name as well"),
        ('inner = "/gated/drive"', 'inner = "/gated/re ach"', "`/gated/re ach` is no name of ROS 2"),
        ('type = "yard_msgs/action/Drive"', 'type = "yard_msgs/msg/Drive"', "as in package/action/Name"),
        ('type = "yard_msgs/action/Drive"', 'type = "yard_msgs/action/Fly"', "yard_msgs/action/Fly is found nowhere"),
        ('status = "error_code"', 'status = "code"', "yard_msgs/action/Drive_Result has no field `code`"),
        ('field = "side"', 'field = "hand.side"', "yard_msgs/action/Reach_Goal has no field `hand.side`"),
        ("success = false,", "failed = true,", "yard_msgs/srv/Halt_Response has no field `failed`"),
        (
            "success = false,",
            'success = "false",',
            "`success` of yard_msgs/srv/Halt_Response is of another type than 'false'",
        ),
        ("success = false,", "success = 0,", "`success` of yard_msgs/srv/Halt_Response is of another type than 0"),
        ('message = "{reason}"', "message = 3", "`message` of yard_msgs/srv/Halt_Response is of another type than 3"),
        (
            '/reach"\n',
            '/reach"\nwhen = { side = 1 }\n',
            "`side` of yard_msgs/action/Reach_Goal is of another type than 1",
        ),
        ('field = "level"', 'field = "cells.0"', "yard_msgs/msg/Battery has no field `cells.0`"),
        ('topic = "/battery"', 'tool = "battery"', "the watch battery is a tool of MCP"),
        ('inner = "/gated/reach"', 'inner = "/gated/drive"', "has two outer names"),
    ],
)
def test_a_binding_that_cannot_be_served(old: str, new: str, message: str) -> None:
    assert old in BIND
    (said,) = told(BIND.replace(old, new, 1))
    assert message in said


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("float64", ""),
        ("int8", "`x` of a_msgs/action/Drive_Goal is of another type than -1.5"),
        ("string", "`x` of a_msgs/action/Drive_Goal is of another type than -1.5"),
        ("float64[]", "`x` of a_msgs/action/Drive_Goal is of another type than -1.5"),
    ],
)
def test_the_call_of_a_launch_rule_is_one_of_its_type(kind: str, said: str) -> None:
    model = model_of(LAUNCHING)
    types = Interfaces({"a_msgs/action/Drive": f"{kind} x\n---\nint32 error_code\nfloat64 metres\n---\n"}.get)
    binding = binding_of(LAUNCHING_BIND.replace("yard_msgs/action/Drive", "a_msgs/action/Drive"), model)
    types.load("a_msgs/action/Drive")
    told = list(unmade(model, binding, types))
    assert told == [f"home: {said}"] * bool(said)


@pytest.mark.parametrize(
    ("base", "kind", "values", "said"),
    [
        ("uint8", "{left, right}", '{ "0" = "left", "1" = "right" }', "is uint8, and `x` is read from one of 0, 1"),
        ("uint8", "{left, right}", "", "is uint8, and `x` is read from one of left, right"),
        ("bool", "{left, right}", '{ true = "left", false = "right" }', ""),
        ("string", "bool", "{ on = true, off = false }", ""),
        ("string", "bool", "", "is string, and `x` is read from true or false"),
        ("bool", "bool", "{ on = true, off = false }", "is bool, and `x` is read from one of on, off"),
        ("bool", "int in 0 .. 1", "", "is bool, and `x` is read from an integer in 0 .. 1"),
        ("int8", "real in 0 .. 1", "", ""),
        ("int8[]", "real in 0 .. 1", "", "is no number, bool or text, and `x` is read from a number in 0 .. 1"),
    ],
)
def test_a_field_that_never_has_a_value_of_its_type_is_told(base: str, kind: str, values: str, said: str) -> None:
    types = Interfaces({"a_msgs/action/Drive": f"{base} x\n---\nint32 error_code\nfloat64 metres\n---\n"}.get)
    model = model_of(LAUNCHING.split("launch")[0].replace("real in -10 .. 10", kind))
    bind = LAUNCHING_BIND.replace("yard_msgs/action/Drive", "a_msgs/action/Drive")
    if values:
        bind += f'\narguments = {{ x = {{ field = "x", values = {values} }} }}\n'
    told = [each for each in mistakes(binding_of(bind, model), types, False) if "`x`" in each]
    assert len(told) == bool(said) and all(
        f"base.drive: `x` of a_msgs/action/Drive_Goal {said}" in each for each in told
    )


def test_definitions_may_have_lines_as_on_windows() -> None:
    types = Interfaces({"a_msgs/srv/X": "bool a\r\n---\r\nuint8 code\r\n"}.get)
    types.load("a_msgs/srv/X")
    assert types.has("a_msgs/srv/X_Request", ("a",)) and types.has("a_msgs/srv/X_Response", ("code",))


def test_names_may_be_the_same_in_domains_of_their_own() -> None:
    assert not told(BIND.replace('inner = "/gated/drive"', ""), apart=True)


def test_types_are_looked_for_in_folders_and_prefixes(tmp_path: Path) -> None:
    folder = tmp_path / "share" / "a_msgs" / "msg"
    folder.mkdir(parents=True)
    (folder / "Deep.msg").write_text("uint8 MANY=3\nFlat[] flats\nstring<=4[2] names\nfloat64[<=3] numbers 1\n")
    (folder / "Flat.msg").write_text("geometry_msgs/PoseStamped pose\n")
    types = Interfaces(finder(["/nowhere"], {"AMENT_PREFIX_PATH": f"/nowhere:{tmp_path}"}))
    types.load("a_msgs/msg/Deep")
    assert types.has("a_msgs/msg/Deep", ("flats", "0", "pose", "pose", "position", "x"))
    assert not types.has("a_msgs/msg/Deep", ("flats", "pose"))
    body = types.write("a_msgs/msg/Deep", [(("names", "1"), "four")])
    assert types.read("a_msgs/msg/Deep", body)["names"] == ["", "four"]
    with pytest.raises(UnreadableField):
        types.write("a_msgs/msg/Deep", [(("flats", "0", "pose"), 1)])


@pytest.mark.parametrize("value", [256, -1, 1 << 62])
def test_a_number_that_its_field_cannot_have_is_not_written(value: int) -> None:
    types = Interfaces({"a_msgs/srv/X": "---\nuint8 code\n"}.get)
    types.load("a_msgs/srv/X")
    with pytest.raises(UnreadableField):
        types.write("a_msgs/srv/X_Response", [(("code",), value)])
    bind = BIND.replace("yard_msgs/srv/Halt", "a_msgs/srv/X")
    bind = bind.replace('success = false, message = "{reason}"', f"code = {value}")
    bind = bind[: bind.index('[request."base.halt".report]')] + bind[bind.index('[request."arm.reach"]') :]
    (said,) = [each for each in mistakes(binding_of(bind, yard().model), types, False) if "base.halt" in each]
    assert said.startswith("base.halt: a_msgs/srv/X_Response: ")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("int32 a\n---\n", "lines `---`"),
        ("int32 5x\n---\n---\n", "is no definition"),
        ("other_msgs/Thing a\n---\n---\n", "other_msgs/msg/Thing is found nowhere"),
        ("wstring a\n---\n---\n", "a wstring, which"),
    ],
)
def test_types_that_are_none(text: str, why: str) -> None:
    types = Interfaces({"a_msgs/action/X": text}.get)
    with pytest.raises(UnknownType, match=why):
        types.load("a_msgs/action/X")


def test_a_type_that_is_a_part_of_itself() -> None:
    types = Interfaces({"a_msgs/msg/X": "Y y", "a_msgs/msg/Y": "X[] x"}.get)
    with pytest.raises(UnknownType, match="part of itself"):
        types.load("a_msgs/msg/X")
