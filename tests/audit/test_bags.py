"""Bags of ROS 2 as missions: statuses, introspected services and topics by a binding, and what a bag does not tell."""

from pathlib import Path
from typing import TYPE_CHECKING
from unittest.mock import patch

import pytest

from exover.audit.auditor import Job, MissionAuditor
from exover.audit.result import MissionResult
from exover.gate.reading import read_binding
from exover.model.event import Report
from exover.pipeline import build, load
from exover.source import Source

pytest.importorskip("rosbags")
from rosbags.rosbag2 import ReaderError

from exover.audit.bags import Bag
from tests.audit.bags import BagWriter, definition

if TYPE_CHECKING:
    from exover.gate.binding import Binding
    from exover.model.model import Model

SPEC = """spec yard;
poster wind: int in 0 .. 40 = 0 else 40;
module hoist {
    request lift(load: real in 0 .. 12) fails (slipped) { check light: load <= 8 or wind <= 5; }
    request turn() returns (angle: real in 0 .. 360);
}
module slew { request park() fails (blocked) instances 2; request rest(); }
mutex one: hoist.lift, hoist.turn;
mutex still: slew.park, hoist.turn;
"""
BINDING = """
[gate]
spec = "yard"
start = "idle"
[watch.weather]
topic = "/wind"
type = "yard/msg/Wind"
[request."hoist.lift"]
action = "/lift"
type = "yard/action/Lift"
[request."hoist.turn"]
action = "/turn"
type = "yard/action/Turn"
[request."slew.park"]
service = "/park"
refused = { success = false }
type = "yard/srv/Park"
report = { status = "success", ok = [true], failed = [false] }
[request."slew.rest"]
service = "/rest"
refused = { success = false, message = "{reason}" }
type = "std_srvs/srv/Trigger"
[poster.wind]
watch = "weather"
field = { field = "metres_per_second", scale = 1 }
"""
EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = 2, 3, 4, 5, 6


def bound(text: str = BINDING, spec: str = SPEC) -> "tuple[Model, Binding]":
    model = load(Source("yard.exo", spec)).model
    assert model is not None
    text = text.replace('field = { field = "metres_per_second", scale = 1 }', 'field = "metres_per_second"')
    binding, told = read_binding(Source("yard.bind.toml", text), model)
    assert binding is not None, told
    return model, binding


def audit(path: Path) -> MissionResult:
    model, binding = bound()
    return MissionAuditor(Job(model, build(model).tables, binding=binding)).audit(str(path), path.name)


def short(found: MissionResult) -> list[tuple[object, ...]]:
    return [(row.line, row.time, row.kind, row.request, row.instance, row.answer, row.rule) for row in found.rows]


@pytest.mark.parametrize("plugin", ("mcap", "sqlite3"))
def test_goals_with_arguments(tmp_path: Path, plugin: str) -> None:
    with BagWriter(tmp_path / "bag", plugin) as bag:
        bag.wind(12)
        bag.goal(1, 3.5)
        bag.accept(1)
        bag.status("/lift", g1=EXECUTING)
        bag.status("/turn", g2=EXECUTING)  # beside the lift
        bag.status("/turn", g2=ABORTED)
        bag.status("/lift", g1=SUCCEEDED)
        bag.goal(3, 11.0)  # too much in this wind, and no response was recorded
        bag.status("/lift", g1=SUCCEEDED, g3=EXECUTING)
        bag.status("/lift", g1=SUCCEEDED, g3=CANCELED)
        bag.goal(4, 11.5)
        bag.accept(4, False)  # the server refuses it itself
    found = audit(tmp_path / "bag")
    assert not found.error and not found.mistakes
    assert short(found) == [
        (5, 5.0, "launched", "hoist.turn", 0, "reject", "one"),
        (9, 9.0, "launched", "hoist.lift", 0, "reject", "hoist.lift.light"),
    ]
    assert found.figures.asks == {
        ("hoist.lift", "launch"): 1,
        ("hoist.lift", "reject"): 2,
    }
    assert found.notes == (
        "it has no arguments of the goals of /turn: /turn/_action/send_goal/_service_event was not recorded",
        "it has no topic of the service /park",
        "it has no topic of the service /rest",
    )


@pytest.mark.parametrize("late", (0, 1, 2))
def test_a_status_may_stand_before_its_goal(tmp_path: Path, late: int) -> None:
    """Topics reach a recorder one by one, so what was sent first may have the later time stamp."""
    with BagWriter(tmp_path / "bag") as bag:
        bag.wind(12)
        for step in (lambda: bag.goal(1, 11.0), lambda: bag.accept(1))[: 2 - late]:
            step()
        bag.status("/lift", g1=EXECUTING)
        bag.status("/lift", g1=SUCCEEDED)
        bag.status("/lift")  # it is forgotten
        for step in (lambda: bag.goal(1, 11.0), lambda: bag.accept(1))[2 - late :]:
            step()
    found = audit(tmp_path / "bag")
    line = 4 - late
    assert short(found) == [(line, line, "launched", "hoist.lift", 0, "reject", "hoist.lift.light")]
    assert found.figures.asks == {("hoist.lift", "reject"): 1} and not found.figures.undecided


def test_goals_without_arguments_are_undecided(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as bag:
        bag.status("/lift", g1=EXECUTING)
        bag.status("/lift", g1=SUCCEEDED)
        bag.status("/turn", g2=EXECUTING)
        bag.status("/turn", g2=SUCCEEDED)
    found = audit(tmp_path / "bag")
    assert not found.rows and found.figures.undecided == 1
    assert (
        "it has no arguments of the goals of /lift: /lift/_action/send_goal/_service_event was not recorded"
        in found.notes
    )
    assert "1 launch undecided: no arguments are recorded" in found.notes
    assert "it has no results of hoist.turn: its ends are taken as failed" in found.notes


def test_results_that_come_behind_the_statuses(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as bag:
        for goal, status, code in ((1, SUCCEEDED, 0), (2, ABORTED, 7), (3, SUCCEEDED, 7), (4, CANCELED, 0)):
            bag.status("/turn", **{f"g{goal}": EXECUTING})
            bag.status("/turn", **{f"g{goal}": status})
            bag.turned(goal, status, 45.5, code)
        bag.status("/turn", g5=EXECUTING)
        bag.turned(5, 0, 1.0)  # it is not known, so that is no result
        bag.status("/turn", g5=SUCCEEDED)
    binding = BINDING.replace(
        'type = "yard/action/Turn"',
        'type = "yard/action/Turn"\nreport = { status = "error_code", ok = [0], fails = { stuck = [7] }, '
        'results = { angle = "degrees" } }',
    )
    model, read = bound(binding, SPEC.replace("in 0 .. 360);", "in 0 .. 360) fails (stuck);"))
    bag_ = Bag(model, read, str(tmp_path / "bag"))
    ends = [(number, item) for number, noted in bag_.messages() for item in noted.items if isinstance(item, Report)]
    assert ends == [
        (2, Report("hoist.turn", 0, "ok", (45.5,))),
        (4, Report("hoist.turn", 0, "failed", (), "stuck")),
        (6, Report("hoist.turn", 0, "failed", (), "stuck")),
        (8, Report("hoist.turn", 0, "interrupted")),
        (10, Report("hoist.turn", 0, "failed")),
    ]
    assert "it has no results of hoist.turn: its ends are taken as failed" in list(bag_.notes())


def test_a_cancel_and_goals_that_had_ended_before(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as bag:
        bag.status("/turn", g9=SUCCEEDED, g8=EXECUTING)
        bag.status("/turn", g9=SUCCEEDED, g8=CANCELING)
        bag.status("/turn", g9=SUCCEEDED, g8=CANCELED)
        bag.status("/turn", g8=CANCELED, g7=SUCCEEDED)  # so short that it was not seen running
        bag.status("/turn", g6=EXECUTING, g5=EXECUTING)  # two at once, and the spec has one instance
    found = audit(tmp_path / "bag")
    assert [row[2:] for row in short(found)] == [
        ("stopped", "hoist.turn", 0, "none", None),
        ("launched", "hoist.turn", None, "invalid", "out-of-range"),
    ]


def test_services(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as bag:
        bag.park(1)
        bag.park(2)
        bag.status("/turn", g1=EXECUTING)
        bag.parked(1, True)
        bag.parked(2, False)
        bag.status("/turn", g2=EXECUTING)
        bag.park(3)
    found = audit(tmp_path / "bag")
    assert [row[2:] for row in short(found)] == [
        ("launched", "hoist.turn", 0, "reject", "still"),
        ("launched", "hoist.turn", None, "invalid", "out-of-range"),
    ]
    assert found.figures.asks == {("slew.park", "launch"): 3}


def test_a_service_that_has_only_started_ends_where_its_watch_shows_it(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as bag:
        bag.wind(0)
        bag.park(1)
        bag.parked(1, True)
        bag.wind(0)  # it may be about what was before
        bag.wind(1)
        bag.wind(9)  # it says nothing
        bag.wind(2)
        bag.park(2)
        bag.wind(1)
        bag.parked(2, True)
        bag.wind(0)
        bag.park(3)
        bag.parked(3, True)
        bag.wind(0)
        bag.wind(0)
    report = 'watch = "weather", status = "metres_per_second", running = [1], ok = [0], fails = { blocked = [2] }'
    binding = BINDING.replace(
        'report = { status = "success", ok = [true], failed = [false] }', f"started = true\nreport = {{ {report} }}"
    )
    model, read = bound(binding, SPEC.replace("(blocked) instances 2", "(blocked)"))
    messages = Bag(model, read, str(tmp_path / "bag")).messages()
    ends = [(number, item) for number, noted in messages for item in noted.items if isinstance(item, Report)]
    assert ends == [
        (8, Report("slew.park", 0, "failed", (), "blocked")),
        (13, Report("slew.park", 0, "ok")),
        (18, Report("slew.park", 0, "ok")),
    ]


def test_names_in_a_binding_may_leave_out_the_slash_at_the_head(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as bag:
        bag.wind(9)
        bag.goal(1, 9.0)
        bag.accept(1)
        bag.status("/lift")
        bag.park(1)
        bag.parked(1, True)
    model, binding = bound(BINDING.replace('= "/', '= "'))
    found = MissionAuditor(Job(model, build(model).tables, binding=binding)).audit(str(tmp_path / "bag"), "bag")
    assert found.figures.asks == {("hoist.lift", "reject"): 1, ("slew.park", "launch"): 1}
    assert found.notes == ("it has no topic of the action /turn", "it has no topic of the service /rest")


def test_readings(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as bag:
        bag.wind(3)
        bag.wind(1000)
        bag.wind(2.5)
        bag.goal(1, 9.0)
        bag.accept(1)
    found = audit(tmp_path / "bag")
    assert found.figures.invalid == 2
    assert [(mistake.line, mistake.text[:10]) for mistake in found.mistakes] == [(3, "wrong-type")]
    assert found.figures.asks == {("hoist.lift", "reject"): 1}  # the wind reads its `else` value


@pytest.mark.parametrize("plugin", ("mcap", "sqlite3"))
def test_truncated_bags(tmp_path: Path, plugin: str) -> None:
    with BagWriter(tmp_path / "bag", plugin) as bag:
        for speed in range(300):
            bag.wind(speed % 40)
    (file,) = (path for path in (tmp_path / "bag").iterdir() if path.suffix in (".mcap", ".db3"))
    whole = file.read_bytes()
    for size in (0, 5, len(whole) // 2, len(whole) - 60):
        file.write_bytes(whole[:size])
        found = audit(file)
        assert found.error.startswith("it is no mission: ") or found.mistakes, size


def test_messages_of_another_type_than_is_read_are_mistakes(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as bag:
        other = bag.make("yard/msg/Wind", metres_per_second=1.0)
        for topic in ("_action/status", "_action/send_goal/_service_event", "_action/get_result/_service_event"):
            bag.write(f"/turn/{topic}", "yard/msg/Wind", other)
        bag.write("/park/_service_event", "yard/msg/Wind", other)
        bag.goal(1, 3.5)
        bag.accept(1)
    found = audit(tmp_path / "bag")
    assert [(each.line, each.text) for each in found.mistakes] == [
        (1, "wrong-type: /turn/_action/get_result/_service_event is of yard/msg/Wind: there is no field `info`"),
        (1, "wrong-type: /turn/_action/status is of yard/msg/Wind: there is no field `status_list`"),
        (2, "wrong-type: /turn/_action/send_goal/_service_event is of yard/msg/Wind: there is no field `info`"),
        (3, "wrong-type: /park/_service_event is of yard/msg/Wind: there is no field `info`"),
    ]
    assert (found.error, found.figures.events) == ("", 1)
    assert found.figures.asks == {("hoist.lift", "launch"): 1}


@pytest.mark.parametrize(
    ("old", "new", "says"),
    (
        ("uint8[16] uuid", "uint8[16] uuit", "there is no field `status_list.goal_info.goal_id.uuid`"),
        ("uint8[16] uuid", "uint8 uuid\nuint8[15] more", "`status_list.goal_info.goal_id.uuid` is no list"),
        ("int8 status", "bool[1] status", "`status_list.status` is no int"),
    ),
)
def test_statuses_that_are_defined_otherwise_are_mistakes(tmp_path: Path, old: str, new: str, says: str) -> None:
    with BagWriter(tmp_path / "bag", define=lambda kind: definition(kind).replace(old, new)) as bag:
        bag.wind(3)
        bag.status("/turn", g1=EXECUTING)
    found = audit(tmp_path / "bag")
    kind = "action_msgs/msg/GoalStatusArray"
    assert [(each.line, each.text) for each in found.mistakes] == [
        (2, f"wrong-type: /turn/_action/status is of {kind}: {says}")
    ]
    assert found.figures.events == 1


@pytest.mark.parametrize(
    ("written", "says"),
    (
        ("float64 metres\n!\n# of\n# many lines", "the definition of its type `yard/msg/Wind` cannot be read"),
        ("floa464 metres_per_second", "it does not fit the definition of its type `yard/msg/Wind`"),
        ("string[] names", "it does not fit the definition of its type `yard/msg/Wind`"),
    ),
)
def test_a_definition_that_does_not_serve_is_told_in_a_line(tmp_path: Path, written: str, says: str) -> None:
    with BagWriter(
        tmp_path / "bag", define=lambda kind: written if kind == "yard/msg/Wind" else definition(kind)
    ) as bag:
        bag.goal(1, 3.5)
        bag.accept(1)
        bag.wind(3)
    assert [(each.line, each.text) for each in audit(tmp_path / "bag").mistakes] == [
        (3, f"the message behind 2 cannot be read: {says}")
    ]


def test_results_that_cannot_be_read_are_a_mistake(tmp_path: Path) -> None:
    kind = "yard/action/Turn_GetResult_Event"
    with BagWriter(tmp_path / "bag", define=lambda asked: "!" if asked == kind else definition(asked)) as bag:
        bag.wind(3)
        bag.turned(1, SUCCEEDED, 1.0)
    found = audit(tmp_path / "bag")
    says = f"the message behind 0 cannot be read: the definition of its type `{kind}` cannot be read"
    assert [(each.line, each.text) for each in found.mistakes] == [(1, f"bad-event: of the results of goals, {says}")]
    assert found.figures.events == 1


@pytest.mark.parametrize(
    ("raised", "says"),
    (
        (MemoryError(), "it is damaged"),
        (KeyError("ros2lsg"), "it is damaged"),
        (PermissionError(13, "Permission denied"), "Permission denied"),
        (ReaderError("File magic is invalid.\nMore."), "File magic is invalid."),
        (ReaderError("x" * 500), "x" * 160 + "…"),
    ),
)
def test_what_is_wrong_with_a_file_is_told_in_a_short_line(tmp_path: Path, raised: Exception, says: str) -> None:
    with BagWriter(tmp_path / "bag") as bag:
        bag.wind(3)
    with patch("exover.audit.bags.BagReader.open", side_effect=raised):
        assert audit(tmp_path / "bag").error == f"it is no mission: {says}"


def test_a_bag_without_a_binding(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as bag:
        bag.wind(1)
    model, _ = bound()
    found = MissionAuditor(Job(model, build(model).tables)).audit(str(tmp_path / "bag"), "bag")
    assert found.error == "it is a bag, and nothing says which topics are which requests: give --bind"
