"""Goals of ROS 2 servers that the gate has not launched: at its start, and later."""

import pytest

pytest.importorskip("rosbags", reason="the extra exover[ros2] is not installed")

from exover.gate.ros2 import cdr
from exover.gate.ros2.cdr import ABORTED, CANCELED, CANCELING, EXECUTING, SUCCEEDED, Stamp
from exover.gate.ros2.strays import AGAIN
from tests.gate.ros_middle import DRIVE, REACH, RosMiddle, id_of


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


def starting() -> RosMiddle:
    """Return a gate at its start: one server has answered that it cancels nothing, and not shown its status array."""
    yard = RosMiddle()
    yard.proxy.servers("service", "/gated/halt", frozenset({"server"}))
    yard.come(DRIVE)
    yard.show(DRIVE)
    yard.meet(DRIVE)
    yard.come(REACH)
    yard.meet(REACH)
    return yard


def test_a_stray_that_is_being_cancelled_is_seen_though_its_server_answers_before_it_shows_its_array() -> None:
    yard = starting()
    assert yard.accepted("/drive", yard.drive(1)) is False and yard.rules() == ["starting"]
    yard.show(REACH, (50, CANCELING))
    assert yard.got("inner", REACH, "cancel_goal")  # of the stray
    yard.meet_again(REACH)
    assert yard.accepted("/drive", yard.drive(2)) is False and yard.alarms() == ["stray"]
    yard.show(REACH, (50, CANCELED))
    yard.drive(3)
    assert yard.take_goal(DRIVE)[:16] == id_of(3)


def test_a_server_that_shows_no_array_is_believed_half_a_second_later() -> None:
    yard = starting()
    yard.now = AGAIN - 0.1
    yard.proxy.tick()
    assert not yard.got("inner", REACH, "cancel_goal") and not yard.gate.state.started
    yard.now = 0.0
    yard.meet_again(REACH)
    assert yard.gate.state.started
    yard.now += 60
    yard.proxy.tick()
    assert not yard.got("inner", REACH, "cancel_goal")


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
        yard.show(name)
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
