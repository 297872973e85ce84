"""The proxy of ROS 2 without DDS: goals, their cancels, and the death of clients and servers."""

import math
from random import Random

import pytest

pytest.importorskip("rosbags", reason="the extra exover[ros2] is not installed")

from exover.gate.ros2 import cdr, goals
from exover.gate.ros2.cdr import ABORTED, ACCEPTED, CANCELED, CANCELING, EXECUTING, SUCCEEDED, Stamp
from exover.gate.ros2.names import SERVICES, Port
from tests.gate.ros_middle import RosMiddle, id_of
from tests.gate.yard import BIND

DRIVE, REACH = "/gated/drive", "/gated/reach"


def test_a_goal_goes_through_and_its_result_comes_back_as_it_is() -> None:
    yard = RosMiddle().ready()
    header = yard.drive(1, 2.5)
    assert yard.accepted("/drive", header) is None  # the server has not said
    sent = yard.take_goal(DRIVE)
    assert sent[:16] == id_of(1) and yard.types.read("yard_msgs/action/Drive_Goal", sent[16:])["x"] == 2.5
    assert yard.accepted("/drive", header) is True
    assert yard.result("/drive", 1) is None
    yard.show(DRIVE, (1, EXECUTING))
    assert yard.statuses("/drive") == {1: EXECUTING}
    yard.end(DRIVE, SUCCEEDED, metres=2.4)
    status, result = yard.told_result("/drive") or (0, {})
    assert (status, dict(result)["metres"]) == (SUCCEEDED, 2.4)
    assert yard.statuses("/drive") == {1: SUCCEEDED}
    assert yard.journal[-1]["event"] == {
        "report": "base.drive", "instance": 0, "outcome": "ok", "results": {"distance": 2.4},
    }  # fmt: skip
    assert yard.result("/drive", 1) == (status, result)  # for those who ask late
    assert not yard.gate.state.slots and not yard.alarms()


def test_a_rule_refuses_a_goal() -> None:
    yard = RosMiddle().ready()
    yard.proxy.take(Port("inner", "/battery", "message"), cdr.topic(yard.types.write("yard_msgs/msg/Battery")))
    header = yard.drive(1)
    assert yard.accepted("/drive", header) is False
    assert not yard.got("inner", DRIVE, "send_goal") and yard.rules() == ["base.drive.charged"]
    assert yard.result("/drive", 1) == (0, {"metres": 0.0, "error_code": 0})  # unknown


def test_a_goal_that_waits_is_accepted_and_goes_on_later() -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    yard.take_goal(DRIVE)
    header = yard.reach(2)
    assert yard.accepted("/reach", header) is True and yard.statuses("/reach") == {2: ACCEPTED}
    assert not yard.got("inner", REACH, "send_goal")
    yard.end(DRIVE, SUCCEEDED)
    yard.take_goal(REACH)
    assert yard.accepted("/reach", header) is None  # it was told
    yard.end(REACH, SUCCEEDED, touched=True)
    assert yard.result("/reach", 2) == (SUCCEEDED, {"touched": True})


def test_what_waits_too_long_ends_as_aborted() -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    yard.take_goal(DRIVE)
    yard.reach(2)
    yard.now = 30
    assert yard.proxy.due <= 30
    yard.proxy.tick()
    assert yard.result("/reach", 2) == (ABORTED, {"touched": False}) and yard.statuses("/reach") == {2: ABORTED}


def test_a_kill_is_a_cancel_and_the_next_goes_on_once_it_has_ended() -> None:
    yard = RosMiddle().ready()
    yard.drive(1, 1.0)
    yard.take_goal(DRIVE)
    yard.drive(2, 2.0, peer=2)
    ((data, _),) = yard.got("inner", DRIVE, "cancel_goal")
    assert data[20:36] == id_of(1) and yard.statuses("/drive") == {1: CANCELING, 2: ACCEPTED}
    assert yard.gate.state.slots["base.drive", 0].phase == "stopping"
    yard.serve(DRIVE, "cancel_goal", data, cdr.cancel_reply(0, [cdr.GoalInfo(id_of(1), Stamp(5, 6))]))
    assert not yard.got("inner", DRIVE, "send_goal") and not yard.alarms()
    yard.end(DRIVE, CANCELED)
    assert yard.take_goal(DRIVE)[:16] == id_of(2)
    assert yard.result("/drive", 1) == (CANCELED, {"metres": 0.0, "error_code": 0})


def test_a_kill_before_the_server_has_accepted_cancels_it_then() -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    yard.drive(2)
    assert not yard.got("inner", DRIVE, "cancel_goal")
    yard.take_goal(DRIVE)
    ((data, _),) = yard.got("inner", DRIVE, "cancel_goal")
    assert data[20:36] == id_of(1)


@pytest.mark.parametrize("code", [cdr.CANCEL_REJECTED, cdr.CANCEL_UNKNOWN])
def test_a_server_that_refuses_to_cancel_keeps_its_slot(code: int) -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    yard.take_goal(DRIVE)
    yard.drive(2)
    ((data, _),) = yard.got("inner", DRIVE, "cancel_goal")
    yard.serve(DRIVE, "cancel_goal", data, cdr.cancel_reply(code, ()))
    assert yard.alarms() == ["refuses-to-stop"]
    assert yard.gate.state.slots["base.drive", 0].phase == "stopping"
    yard.now = 2.0
    yard.proxy.tick()
    assert yard.alarms()[1:] == ["does-not-stop"] and not yard.got("inner", DRIVE, "send_goal")


def test_clients_cancel_what_waits_and_what_runs() -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    yard.take_goal(DRIVE)
    yard.reach(2)
    assert yard.cancel("/reach", 2) == cdr.CANCEL_OK
    assert yard.result("/reach", 2) == (CANCELED, {"touched": False})
    assert yard.cancel("/drive", 1) == cdr.CANCEL_OK
    ((data, _),) = yard.got("inner", DRIVE, "cancel_goal")
    assert data[20:36] == id_of(1) and yard.gate.state.slots["base.drive", 0].phase == "stopping"
    assert yard.cancel("/drive", 1) == cdr.CANCEL_OK  # again: it is on its way
    yard.end(DRIVE, CANCELED)
    assert yard.cancel("/drive", 1) == cdr.CANCEL_TERMINATED and yard.cancel("/drive", 77) == cdr.CANCEL_UNKNOWN
    assert not yard.gate.state.slots and not yard.gate.state.places


def test_all_goals_are_cancelled_or_those_until_a_time() -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    yard.take_goal(DRIVE)  # accepted at 5.6
    assert yard.cancel("/drive", 0, Stamp(5, 5)) == cdr.CANCEL_OK and not yard.got("inner", DRIVE, "cancel_goal")
    assert yard.cancel("/drive", 0, Stamp(5, 6)) == cdr.CANCEL_OK and yard.got("inner", DRIVE, "cancel_goal")
    yard.end(DRIVE, CANCELED)
    yard.drive(2)
    yard.take_goal(DRIVE)
    assert yard.cancel("/drive", 0) == cdr.CANCEL_OK and yard.got("inner", DRIVE, "cancel_goal")


def test_a_server_refuses_a_goal() -> None:
    yard = RosMiddle().ready()
    header = yard.drive(1)
    yard.take_goal(DRIVE, accepted=False)
    assert yard.accepted("/drive", header) is False and not yard.gate.state.slots
    assert yard.journal[-1]["event"]["outcome"] == "failed"
    yard.drive(2)
    yard.take_goal(DRIVE)
    yard.reach(3)
    yard.end(DRIVE, SUCCEEDED)
    yard.take_goal(REACH, accepted=False)  # it was held, and is accepted for its client
    assert yard.result("/reach", 3) == (ABORTED, {"touched": False})


@pytest.mark.parametrize(
    ("status", "code", "outcome", "name"),
    [
        (SUCCEEDED, 0, "ok", None),
        (SUCCEEDED, 7, "failed", "blocked"),
        (ABORTED, 7, "failed", "blocked"),
        (ABORTED, 0, "failed", None),
        (CANCELED, 0, "interrupted", None),
        (SUCCEEDED, 9, "failed", None),
        (0, 0, "failed", None),
    ],
)
def test_how_a_result_is_reported(status: int, code: int, outcome: str, name: str | None) -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    yard.take_goal(DRIVE)
    yard.end(DRIVE, status, error_code=code)
    event = yard.journal[-1]["event"]
    assert (event["outcome"], event.get("status")) == (outcome, name)
    assert yard.alarms() == (["unknown-status"] if code == 9 or status == 0 else [])


@pytest.mark.parametrize("status", [ACCEPTED, EXECUTING, SUCCEEDED])
def test_a_status_shows_that_a_goal_was_accepted_whose_answer_is_lost(status: int) -> None:
    yard = RosMiddle().ready()
    header = yard.drive(1)
    ((sent, _),) = yard.got("inner", DRIVE, "send_goal")
    yard.show(DRIVE, (1, cdr.UNKNOWN))  # of a goal that is not known says nothing
    assert not yard.got("outer", "/drive", "send_goal")
    yard.show(DRIVE, (1, status))
    ((answer, _),) = yard.got("outer", "/drive", "send_goal")
    assert answer[4:20] == header and cdr.read_goal_reply(answer) == (True, Stamp(5, 6))
    yard.serve(DRIVE, "send_goal", sent, cdr.goal_reply(True, Stamp(5, 6)))  # it was late, not lost
    assert not yard.got("outer", "/drive", "send_goal")
    yard.end(DRIVE, SUCCEEDED, metres=1.0)
    assert (yard.result("/drive", 1) or (0,))[0] == SUCCEEDED and not yard.gate.state.slots and not yard.alarms()


def test_what_is_to_stop_is_cancelled_once_a_status_shows_that_it_was_accepted() -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    yard.drive(2, peer=2)  # it kills the first
    assert not yard.got("inner", DRIVE, "cancel_goal")
    yard.show(DRIVE, (1, EXECUTING))
    ((data, _),) = yard.got("inner", DRIVE, "cancel_goal")
    assert data[20:36] == id_of(1)


def test_a_result_that_is_lost_is_asked_for_again_until_it_comes() -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    yard.take_goal(DRIVE)
    yard.show(DRIVE, (1, EXECUTING))
    first = yard.got("inner", DRIVE, "get_result")
    yard.now = 10
    assert yard.proxy.due > 10  # it runs on: nothing is lost
    yard.show(DRIVE, (1, SUCCEEDED))
    for when in (10.5, 11.0):
        yard.now = when - 0.1
        yard.show(DRIVE, (1, SUCCEEDED))  # a server that says it often is not asked later
        yard.proxy.tick()
        assert not yard.got("inner", DRIVE, "get_result")
        yard.now = when
        assert yard.proxy.due <= when
        yard.proxy.tick()
        again = yard.got("inner", DRIVE, "get_result")
        assert [data[20:] for data, _ in again] == [data[20:] for data, _ in first]
    yard.sent = [(Port("inner", DRIVE, "get_result"), *again[0])]
    yard.end(DRIVE, SUCCEEDED, metres=2.0)
    assert yard.result("/drive", 1) == (SUCCEEDED, {"metres": 2.0, "error_code": 0})
    assert not yard.gate.state.slots and yard.proxy.due > 11.5


def test_a_new_server_is_not_asked_for_a_result_before_it_has_answered() -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    yard.take_goal(DRIVE)
    yard.show(DRIVE, (1, SUCCEEDED))
    yard.leave(DRIVE)
    yard.come(DRIVE, "another")
    yard.got("inner", DRIVE, "get_result")
    yard.now = 0.5
    yard.proxy.tick()
    assert not yard.got("inner", DRIVE, "get_result") and yard.got("inner", DRIVE, "cancel_goal")


def test_a_goal_with_an_id_that_the_server_has_shown_is_refused() -> None:
    yard = RosMiddle().ready()
    yard.show(DRIVE, (1, SUCCEEDED))
    header = yard.drive(1)
    assert yard.accepted("/drive", header) is False and yard.rules() == ["unreadable"]
    yard.show(DRIVE)
    header = yard.drive(1)
    yard.take_goal(DRIVE)
    assert yard.accepted("/drive", header) is True


def test_feedback_passes_of_goals_that_run_here() -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    yard.take_goal(DRIVE)
    for number in (1, 2):
        yard.proxy.take(Port("inner", DRIVE, "feedback"), cdr.topic(id_of(number) + b"\1" * 8))
    assert yard.got("outer", "/drive", "feedback") == [(cdr.topic(id_of(1) + b"\1" * 8), 0)]


# ---- what is wrong ----


def test_goals_that_cannot_be_read_are_refused() -> None:
    yard = RosMiddle(BIND.replace("wait = 30\n", "wait = 30\nmax-line = 1024\n", 1)).ready()
    yard.drive(1, math.nan)
    yard.drive(2, 11.0)
    yard.reach(3, "up")
    yard.reach(4, "l" * 2000)
    yard.client("/reach", "send_goal", id_of(5) + b"\3\0\0\0\xff\xff\0\0")
    yard.client("/drive", "send_goal", id_of(6) + b"\0")
    yard.drive(0)  # an id of zeros
    assert yard.rules() == ["out-of-range"] * 2 + ["unreadable"] * 5
    assert not yard.gate.state.slots and len(yard.got("outer", "/drive", "send_goal")) == 4
    yard.proxy.take(Port("outer", "/drive", "send_goal"), b"\0\1\0\0short", 1)
    yard.proxy.take(Port("outer", "/drive", "send_goal"), b"\0\7\0\0" + bytes(64), 1)  # XCDR2
    assert len(yard.told) == 2 and "was dropped" in yard.told[0]


def test_a_goal_id_is_used_once() -> None:
    yard = RosMiddle().ready()
    first = yard.drive(1)
    second = yard.drive(1, peer=2)
    ((data, peer),) = yard.got("outer", "/drive", "send_goal")
    assert data[4:20] == second and peer == 2 and data[20] == 0 and yard.rules() == ["unreadable"]
    yard.take_goal(DRIVE)
    assert yard.accepted("/drive", first) is True
    yard.end(DRIVE, SUCCEEDED, metres=1.0)
    assert yard.accepted("/drive", yard.drive(1)) is False  # it has ended, and is known
    assert (yard.result("/drive", 1) or (0,))[0] == SUCCEEDED


def test_answers_that_nobody_has_asked_for_are_dropped() -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    ((asked, _),) = yard.got("inner", DRIVE, "send_goal")
    for header in (b"somebody" + asked[12:20], b"the gate" + (999).to_bytes(8, "little")):
        yard.proxy.take(Port("inner", DRIVE, "send_goal"), cdr.service(header, cdr.goal_reply(True, Stamp(1, 1))))
    yard.serve(DRIVE, "get_result", asked, b"\4" + bytes(20))  # on another port
    assert not yard.got("outer", "/drive", "send_goal") and len(yard.gate.state.slots) == 1
    yard.serve(DRIVE, "send_goal", asked, cdr.goal_reply(True, Stamp(1, 1)))
    yard.serve(DRIVE, "send_goal", asked, cdr.goal_reply(False, Stamp(1, 1)))  # a second one
    assert len(yard.got("outer", "/drive", "send_goal")) == 1 and len(yard.gate.state.slots) == 1


# ---- death, start and restart ----


def test_nothing_is_launched_before_the_servers_have_said_what_runs() -> None:
    yard = RosMiddle()
    assert yard.accepted("/drive", yard.drive(1)) is False and yard.rules() == ["starting"]
    yard.come(DRIVE)
    ((data, _),) = yard.got("inner", DRIVE, "cancel_goal")
    assert data[20:36] == cdr.NO_ID
    assert yard.accepted("/drive", yard.drive(2)) is False
    yard.now = 0.5
    yard.proxy.tick()  # not answered: it is asked again
    assert len(yard.got("inner", DRIVE, "cancel_goal")) == 1


def test_what_runs_at_the_start_is_stopped_before_anything_begins() -> None:
    yard = RosMiddle().ready()
    yard.leave(REACH)
    yard.come(REACH, "another")
    ((data, _),) = yard.got("inner", REACH, "cancel_goal")
    yard.serve(REACH, "cancel_goal", data, cdr.cancel_reply(0, [cdr.GoalInfo(id_of(50), Stamp(1, 1))]))
    assert yard.alarms() == ["stray"] and yard.accepted("/drive", yard.drive(1)) is False
    yard.now = 0.5
    yard.proxy.tick()
    ((data, _),) = yard.got("inner", REACH, "cancel_goal")
    yard.serve(REACH, "cancel_goal", data, cdr.cancel_reply(cdr.CANCEL_REJECTED, ()))  # it has something, still
    assert yard.accepted("/drive", yard.drive(2)) is False
    yard.now = 1.0
    yard.proxy.tick()
    yard.meet(REACH)
    yard.drive(3)
    assert yard.take_goal(DRIVE)[:16] == id_of(3) and yard.proxy.due > 1  # nobody is asked any more
    assert yard.rules() == ["stray", "stray"]


def test_what_the_gate_has_had_cancelled_is_a_stray_until_it_has_ended() -> None:
    yard = RosMiddle().ready()
    yard.leave(DRIVE)
    yard.come(DRIVE, "another")
    ((data, _),) = yard.got("inner", DRIVE, "cancel_goal")
    yard.serve(DRIVE, "cancel_goal", data, cdr.cancel_reply(0, [cdr.GoalInfo(id_of(50), Stamp(1, 1))]))
    yard.show(DRIVE, (50, CANCELING))
    yard.now = 0.5
    yard.proxy.tick()
    ((data, _),) = yard.got("inner", DRIVE, "cancel_goal")
    yard.serve(DRIVE, "cancel_goal", data, cdr.cancel_reply(0, ()))  # servers name no goal twice
    assert yard.accepted("/reach", yard.reach(1)) is False and yard.rules() == ["stray"]
    yard.show(DRIVE, (50, CANCELED))
    assert yard.alarms() == ["stray"] and not yard.gate.state.strays
    yard.drive(2)
    assert yard.take_goal(DRIVE)[:16] == id_of(2)


def test_a_goal_of_somebody_else_is_a_stray_and_denies_everything() -> None:
    yard = RosMiddle().ready()
    yard.show(DRIVE, (66, EXECUTING))
    ((data, _),) = yard.got("inner", DRIVE, "cancel_goal")
    assert data[20:36] == id_of(66) and yard.alarms() == ["stray"]
    assert yard.accepted("/reach", yard.reach(1)) is False and yard.rules() == ["stray"]
    yard.show(DRIVE, (66, CANCELED))
    yard.reach(2)
    assert yard.take_goal(REACH)[:16] == id_of(2)


def test_a_goal_of_somebody_else_beside_one_of_ours_is_cancelled() -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    yard.take_goal(DRIVE)
    yard.show(DRIVE, (1, EXECUTING), (66, EXECUTING))
    ((data, _),) = yard.got("inner", DRIVE, "cancel_goal")
    assert data[20:36] == id_of(66) and yard.alarms() == ["stray"]
    yard.end(DRIVE, SUCCEEDED)
    yard.show(DRIVE, (1, EXECUTING), (66, CANCELED))  # an old one of ours is none
    assert yard.alarms() == ["stray"] and not yard.gate.state.strays


def test_a_goal_of_somebody_else_beside_one_of_ours_denies_everything() -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    yard.take_goal(DRIVE)
    assert yard.accepted("/reach", yard.reach(2)) is True  # it waits
    yard.show(DRIVE, (1, EXECUTING), (66, EXECUTING))
    assert not yard.gate.state.places and yard.statuses("/reach") == {2: ABORTED}
    yard.end(DRIVE, SUCCEEDED)
    assert yard.accepted("/reach", yard.reach(3)) is False and not yard.got("inner", REACH, "send_goal")
    assert yard.rules() == ["aborted", "stray"] and yard.alarms() == ["stray"]
    yard.show(DRIVE, (66, CANCELED))
    yard.reach(4)
    assert yard.take_goal(REACH)[:16] == id_of(4)


def test_a_goal_that_waits_here_and_that_somebody_else_has_sent_is_a_stray() -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    yard.take_goal(DRIVE)
    yard.reach(2)
    yard.show(REACH, (2, EXECUTING))
    assert yard.alarms() == ["stray"] and yard.statuses("/reach") == {2: ABORTED}
    yard.show(REACH, (2, EXECUTING))  # it is known here, as one that never ran
    assert yard.gate.state.strays
    yard.show(REACH, (2, CANCELED))
    assert not yard.gate.state.strays


def test_what_becomes_stray_before_the_start_delays_it() -> None:
    yard = RosMiddle()
    for name in (DRIVE, REACH):
        yard.come(name)
        yard.meet(name)
    yard.show(DRIVE, (66, EXECUTING))
    yard.proxy.servers("service", "/gated/halt", frozenset({"server"}))
    assert yard.gate.state.strays == {("base.drive", 0)} and not yard.gate.state.started  # no launch rule uses the slot
    yard.show(DRIVE, (66, CANCELED))
    assert yard.gate.state.started and not yard.gate.state.strays


def test_the_end_of_what_is_stray_is_no_answer_of_its_server() -> None:
    yard = RosMiddle().ready()
    yard.leave(DRIVE)
    yard.come(DRIVE, "another")
    yard.show(DRIVE, (66, CANCELING))
    yard.show(DRIVE, (66, CANCELED))
    assert yard.gate.state.away and yard.accepted("/drive", yard.drive(1)) is False
    data, _ = yard.got("inner", DRIVE, "cancel_goal")[0]
    yard.serve(DRIVE, "cancel_goal", data, cdr.cancel_reply(0, ()))
    assert not yard.gate.state.strays
    yard.drive(2)
    assert yard.take_goal(DRIVE)[:16] == id_of(2)
    yard = RosMiddle()
    yard.proxy.servers("service", "/gated/halt", frozenset({"server"}))
    yard.come(REACH)
    data, _ = yard.got("inner", REACH, "cancel_goal")[0]
    yard.serve(REACH, "cancel_goal", data, cdr.cancel_reply(0, ()))
    yard.come(DRIVE)
    yard.show(DRIVE, (66, CANCELING))
    yard.show(DRIVE, (66, CANCELED))
    assert not yard.gate.state.started  # what it answers may still be lost


def test_a_server_that_dies_with_goals_of_somebody_else() -> None:
    for bind in (BIND, STARTS_IDLE):
        yard = RosMiddle(bind)
        yard.proxy.servers("service", "/gated/halt", frozenset({"server"}))
        for name in (REACH, DRIVE):
            yard.come(name)
            data, _ = yard.got("inner", name, "cancel_goal")[-1]
            yard.serve(name, "cancel_goal", data, cdr.cancel_reply(0, ()))
        yard.show(DRIVE, (66, EXECUTING), (67, EXECUTING))
        # slot 0 is for what launch rules require, and the end of a stray is no end of that
        assert yard.gate.state.strays == {("base.drive", 1), ("base.drive", 2)}
        yard.leave(DRIVE)
        assert len(yard.gate.state.strays) == 2
        yard.come(DRIVE, "a new process")
        data, _ = yard.got("inner", DRIVE, "cancel_goal")[-1]
        yard.serve(DRIVE, "cancel_goal", data, cdr.cancel_reply(0, ()))
        assert not yard.gate.state.strays
        yard.drive(1)
        assert yard.take_goal(DRIVE)[:16] == id_of(1)


def test_a_server_that_dies_leaves_its_slot_active_until_a_new_one_says_otherwise() -> None:
    yard = RosMiddle().ready()
    header = yard.drive(1)
    yard.take_goal(DRIVE)
    assert yard.accepted("/drive", header) is True
    yard.result("/drive", 1)
    yard.leave(DRIVE)
    assert yard.told_result("/drive") == (ABORTED, {"metres": 0.0, "error_code": 0})
    assert yard.gate.state.slots["base.drive", 0].lost and yard.alarms() == ["module-gone"]
    assert yard.accepted("/drive", yard.drive(2)) is False and yard.rules() == ["unavailable"]
    assert yard.accepted("/reach", yard.reach(3)) is True  # it waits: the base may be moving
    yard.come(DRIVE, "a new process")
    yard.meet(DRIVE)
    assert yard.take_goal(REACH)[:16] == id_of(3)


def test_a_goal_that_survives_a_cut_is_asked_for_again() -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    yard.take_goal(DRIVE)
    yard.leave(DRIVE)
    yard.got("inner", DRIVE, "get_result")
    yard.come(DRIVE)
    ((data, _),) = yard.got("inner", DRIVE, "cancel_goal")
    yard.serve(DRIVE, "cancel_goal", data, cdr.cancel_reply(0, [cdr.GoalInfo(id_of(1), Stamp(5, 6))]))
    assert not yard.gate.state.slots["base.drive", 0].lost and "stray" not in yard.alarms()
    yard.end(DRIVE, CANCELED)
    assert not yard.gate.state.slots
    yard.drive(2)
    assert yard.take_goal(DRIVE)[:16] == id_of(2)


@pytest.mark.parametrize("again", [True, False])
def test_a_cut_does_not_end_what_the_status_array_has_shown(again: bool) -> None:
    yard = RosMiddle().ready()
    yard.show(DRIVE, (66, CANCELING))
    yard.leave(DRIVE)
    yard.got("inner", DRIVE, "cancel_goal")
    yard.come(DRIVE, *(["server"] if again else ["a new process"]))
    *_, (data, _) = yard.got("inner", DRIVE, "cancel_goal")  # of all: a stray that is known is cancelled before
    yard.serve(DRIVE, "cancel_goal", data, cdr.cancel_reply(0, ()))  # the array comes behind it
    assert bool(yard.gate.state.strays) is again
    yard.show(DRIVE, (66, CANCELED))
    assert not yard.gate.state.strays


def test_a_goal_that_is_unknown_after_a_cut_and_begins_all_the_same_is_a_stray() -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    yard.take_goal(DRIVE)
    yard.reach(2)
    yard.end(DRIVE, SUCCEEDED)  # the second has waited, and is sent
    yard.leave(REACH)
    yard.come(REACH)
    yard.meet(REACH)
    yard.end(REACH, cdr.UNKNOWN)
    assert not yard.gate.state.slots
    yard.show(REACH, (2, EXECUTING))  # it took the goal behind the questions
    assert yard.alarms()[-1] == "stray" and yard.gate.state.strays


def test_a_goal_that_is_cancelled_during_a_cut_is_active_until_its_result_comes() -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    yard.take_goal(DRIVE)
    yard.cancel("/drive", 1)
    yard.leave(DRIVE)
    yard.got("inner", DRIVE, "cancel_goal")
    yard.got("inner", DRIVE, "get_result")
    yard.come(DRIVE)
    ((data, _),) = yard.got("inner", DRIVE, "cancel_goal")
    yard.serve(DRIVE, "cancel_goal", data, cdr.cancel_reply(0, ()))  # servers name no goal twice
    yard.reach(2)
    assert yard.gate.state.slots["base.drive", 0].phase == "stopping" and not yard.got("inner", REACH, "send_goal")
    yard.end(DRIVE, CANCELED)
    assert yard.take_goal(REACH)[:16] == id_of(2)


def test_an_answer_to_a_cancel_says_nothing_of_the_next_goal() -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    yard.take_goal(DRIVE)
    yard.drive(2)
    ((data, _),) = yard.got("inner", DRIVE, "cancel_goal")
    yard.end(DRIVE, CANCELED)
    yard.serve(DRIVE, "cancel_goal", data, cdr.cancel_reply(0, [cdr.GoalInfo(id_of(1), Stamp(5, 6))]))
    assert yard.take_goal(DRIVE)[:16] == id_of(2) and not yard.alarms()


def test_a_server_that_dies_before_it_answers() -> None:
    yard = RosMiddle().ready()
    header = yard.drive(1)
    yard.leave(DRIVE)
    assert yard.accepted("/drive", header) is False and yard.gate.state.slots["base.drive", 0].lost


STARTS_IDLE = BIND.replace('spec = "yard"', 'spec = "yard"\nstart = "idle"')


@pytest.mark.parametrize("again", [True, False])
def test_a_server_whose_start_stops_everything(again: bool) -> None:
    yard = RosMiddle(STARTS_IDLE).ready()
    yard.drive(1)
    yard.take_goal(DRIVE)
    yard.leave(DRIVE)
    yard.got("inner", DRIVE, "get_result")
    yard.come(DRIVE, *(["server"] if again else ["a new process"]))
    yard.meet(DRIVE)
    asked = yard.got("inner", DRIVE, "get_result")
    assert bool(asked) is again  # the same process may run it still
    assert bool(yard.gate.state.slots) is again
    if again:
        yard.sent = [(Port("inner", DRIVE, "get_result"), *asked[0])]
        yard.end(DRIVE, CANCELED)
    yard.got("inner", DRIVE, "send_goal")
    yard.drive(2)
    assert yard.take_goal(DRIVE)[:16] == id_of(2)


def test_what_was_to_stop_when_the_network_was_cut_is_cancelled_again() -> None:
    yard = RosMiddle(STARTS_IDLE).ready()
    yard.drive(1)
    yard.take_goal(DRIVE)
    yard.cancel("/drive", 1)
    assert len(yard.got("inner", DRIVE, "cancel_goal")) == 1
    yard.leave(DRIVE)
    yard.come(DRIVE)
    yard.meet(DRIVE)
    assert [data[20:36] for data, _ in yard.got("inner", DRIVE, "cancel_goal")] == [id_of(1)]
    yard.end(DRIVE, CANCELED)
    assert not yard.gate.state.slots and not yard.alarms()[1:]


def test_what_has_survived_a_cut_is_cancelled_when_it_has_to_stop() -> None:
    yard = RosMiddle().ready()
    yard.drive(1)
    yard.take_goal(DRIVE)
    yard.leave(DRIVE)
    yard.come(DRIVE)
    ((data, _),) = yard.got("inner", DRIVE, "cancel_goal")
    yard.serve(DRIVE, "cancel_goal", data, cdr.cancel_reply(cdr.CANCEL_REJECTED, ()))
    yard.drive(2)  # it kills the first
    ((data, _),) = yard.got("inner", DRIVE, "cancel_goal")
    assert data[20:36] == id_of(1)
    yard.end(DRIVE, CANCELED)
    assert yard.take_goal(DRIVE)[:16] == id_of(2)


def test_what_is_stray_when_the_network_comes_back_is_cancelled_again() -> None:
    yard = RosMiddle(STARTS_IDLE).ready()
    yard.show(DRIVE, (66, EXECUTING))
    yard.got("inner", DRIVE, "cancel_goal")
    yard.leave(DRIVE)
    yard.come(DRIVE)
    yard.show(DRIVE, (66, EXECUTING))
    asked = [data[20:36] for data, _ in yard.got("inner", DRIVE, "cancel_goal")]
    assert id_of(66) in asked and yard.alarms() == ["stray"]


def test_a_server_that_starts_idle_gets_nothing_before_it_has_answered() -> None:
    yard = RosMiddle(STARTS_IDLE)
    yard.proxy.servers("service", "/gated/halt", frozenset({"server"}))
    yard.come(REACH)
    yard.meet(REACH)
    yard.come(DRIVE)
    assert yard.accepted("/drive", yard.drive(1)) is False and yard.rules() == ["starting"]
    yard.now = 0.4
    yard.proxy.tick()
    ((first, _),) = yard.got("inner", DRIVE, "cancel_goal")
    assert yard.proxy.due == 0.5
    yard.now = 0.5  # the answer was lost
    yard.proxy.tick()
    ((second, _),) = yard.got("inner", DRIVE, "cancel_goal")
    assert first[20:36] == second[20:36] and not yard.gate.state.started
    yard.serve(DRIVE, "cancel_goal", second, cdr.cancel_reply(cdr.CANCEL_REJECTED, ()))
    assert yard.gate.state.started and yard.proxy.due > 1
    yard.drive(2)
    assert yard.take_goal(DRIVE)[:16] == id_of(2)
    yard.serve(DRIVE, "cancel_goal", first, cdr.cancel_reply(cdr.CANCEL_UNKNOWN, ()))  # it was late, not lost
    assert ("base.drive", 0) in yard.gate.state.slots


def test_a_server_that_answers_twice_is_asked_for_results_once() -> None:
    yard = RosMiddle(STARTS_IDLE)
    yard.proxy.servers("service", "/gated/halt", frozenset({"server"}))
    for name in (REACH, DRIVE):
        yard.come(name)
        yard.meet(name)
    yard.drive(1)
    yard.take_goal(DRIVE)
    yard.leave(DRIVE)
    yard.got("inner", DRIVE, "get_result")
    yard.come(DRIVE)
    yard.now = 0.5
    yard.proxy.tick()
    questions = yard.got("inner", DRIVE, "cancel_goal")
    assert len(questions) == 2
    for data, _ in questions:
        yard.serve(DRIVE, "cancel_goal", data, cdr.cancel_reply(cdr.CANCEL_UNKNOWN, ()))
    assert len(yard.got("inner", DRIVE, "get_result")) == 1


def test_answers_that_never_come_are_not_awaited_without_end() -> None:
    yard = RosMiddle(STARTS_IDLE)
    yard.come(REACH)
    for _ in range(100):
        yard.now += 0.5
        yard.proxy.tick()
    assert len({data for data, _ in yard.got("inner", REACH, "cancel_goal")}) == 1
    yard = RosMiddle().ready()
    for number in range(1, 10):
        yard.drive(number)
        yard.take_goal(DRIVE)
        yard.cancel("/drive", number)  # the server does not answer this
        yard.end(DRIVE, CANCELED)
    assert not yard.proxy._outside.own._open


def test_a_client_that_dies_while_it_waits_and_one_that_dies_while_it_runs() -> None:
    yard = RosMiddle().ready()
    yard.drive(1, peer=1)
    yard.take_goal(DRIVE)
    yard.reach(2, peer=2)
    yard.proxy.client_gone(2)
    assert not yard.gate.state.places and yard.statuses("/reach") == {2: CANCELED}
    yard.proxy.client_gone(1)
    assert yard.got("inner", DRIVE, "cancel_goal") and yard.gate.state.slots["base.drive", 0].phase == "stopping"
    yard.end(DRIVE, CANCELED)
    assert not yard.gate.state.slots


def test_two_servers_of_one_name_are_told() -> None:
    yard = RosMiddle().ready()
    yard.come(DRIVE, "server", "another")
    assert yard.told == ["2 servers have the name /gated/drive: each goal may run in all of them"]
    yard.come(DRIVE, "another")
    assert not yard.alarms()


@pytest.mark.parametrize("bind", ["ask", "idle"])
def test_a_server_that_is_started_anew_before_its_lease_has_ended(bind: str) -> None:
    yard = RosMiddle(BIND if bind == "ask" else STARTS_IDLE)
    yard.proxy.servers("service", "/gated/halt", frozenset({"server"}))
    for name in (DRIVE, REACH):
        yard.come(name)
        yard.meet(name)
    yard.drive(1)
    yard.take_goal(DRIVE)
    yard.come(DRIVE, "server", "new")
    assert not yard.alarms() and not yard.got("inner", DRIVE, "cancel_goal")
    yard.show(DRIVE, (66, CANCELING))  # of the new one: it is in no answer
    yard.got("inner", DRIVE, "cancel_goal")
    yard.come(DRIVE, "new")
    assert yard.alarms() == ["stray", "module-gone"]
    yard.meet(DRIVE)
    assert not yard.gate.state.slots and yard.gate.state.strays
    yard.show(DRIVE, (66, CANCELED))
    yard.drive(2)
    assert yard.take_goal(DRIVE)[:16] == id_of(2)


def test_the_status_array_ends_with_the_last_ten_and_results_are_kept_longer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(goals, "KEPT", 30)
    yard = RosMiddle().ready()
    for number in range(1, 33):
        yard.drive(number)
        yard.take_goal(DRIVE)
        yard.end(DRIVE, SUCCEEDED)
    assert list(yard.statuses("/drive")) == list(range(23, 33))
    assert yard.result("/drive", 1) == (0, {"metres": 0.0, "error_code": 0})
    assert (yard.result("/drive", 3) or (0,))[0] == SUCCEEDED


def test_a_status_array_is_laid_out_as_others_read_it() -> None:
    goals_ = [(cdr.GoalInfo(id_of(number), Stamp(number, 9)), number) for number in range(1, 4)]
    body = cdr.statuses(cdr.status_entry(*each) for each in goals_)
    read = RosMiddle().types.read("action_msgs/msg/GoalStatusArray", body)["status_list"]
    assert [(each["status"], each["goal_info"]["stamp"]["sec"]) for each in read] == [(1, 1), (2, 2), (3, 3)]
    assert list(cdr.read_statuses(cdr.topic(body))) == [(info.id, *info.stamp, status) for info, status in goals_]
    assert not list(cdr.read_statuses(cdr.topic(b"\xff\xff\xff\xff" + body[4:28])))  # cut off


def test_whatever_comes_breaks_nothing() -> None:
    random = Random(5)
    yard = RosMiddle().ready()
    ports = [Port("outer", name, part) for name in ("/drive", "/reach") for part in SERVICES]
    ports += [Port("inner", name, part) for name in (DRIVE, REACH) for part in (*SERVICES, "feedback", "status")]
    ports += [
        Port("outer", "/halt", "call"),
        Port("inner", "/gated/halt", "call"),
        Port("inner", "/battery", "message"),
    ]
    sent = [b""]
    for _ in range(4000):
        port = random.choice(ports)
        size = random.choice((0, 3, 16, 40, 60))
        data = bytearray(random.choice((cdr.ENCAPSULATION, b"\0\7\0\0", b"")) + random.randbytes(size))
        if random.random() < 0.5:  # a message that was one, and is no longer
            data = bytearray(random.choice(sent))
            for _ in range(random.randrange(3) if data else 0):
                data[random.randrange(len(data))] = random.randrange(256)
        yard.proxy.take(port, bytes(data), random.randrange(3))
        if random.random() < 0.2:
            yard.drive(random.randrange(1, 50), float(random.randrange(-20, 20)))
            yard.reach(random.randrange(1, 50), random.choice("lrx"))
        if random.random() < 0.02:
            yard.come(random.choice((DRIVE, REACH)), *random.sample(("a", "b"), random.randrange(1, 3)))
            yard.leave(random.choice((DRIVE, REACH)))
            yard.proxy.client_gone(random.randrange(3))
            yard.now += random.random()
            yard.proxy.tick()
        sent = [*sent, *(data for _, data, _ in yard.sent)][-50:]
        yard.sent.clear()
    assert all(slot in (("base.drive", 0), ("arm.reach", 0), ("base.halt", 0)) for slot in yard.gate.state.slots)
