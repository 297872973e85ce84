"""Servers of ROS 2 that die, come again, or are cut off from the gate."""

import pytest

pytest.importorskip("rosbags", reason="the extra exover[ros2] is not installed")

from exover.gate.ros2 import cdr
from exover.gate.ros2.cdr import ABORTED, CANCELED, CANCELING, EXECUTING, SUCCEEDED, Stamp
from exover.gate.ros2.names import Port
from tests.gate.ros_middle import DRIVE, REACH, STARTS_IDLE, RosMiddle, id_of
from tests.gate.yard import BIND


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


def test_a_server_that_dies_with_goals_of_somebody_else() -> None:
    for bind in (BIND, STARTS_IDLE):
        yard = RosMiddle(bind)
        yard.proxy.servers("service", "/gated/halt", frozenset({"server"}))
        for name in (REACH, DRIVE):
            yard.come(name)
            yard.show(name)
            data, _ = yard.got("inner", name, "cancel_goal")[-1]
            yard.serve(name, "cancel_goal", data, cdr.cancel_reply(0, ()))
        yard.show(DRIVE, (66, EXECUTING), (67, EXECUTING))
        # slot 0 is for what launch rules require, and the end of a stray is no end of that
        assert yard.gate.state.strays == {("base.drive", 1), ("base.drive", 2)}
        yard.leave(DRIVE)
        assert len(yard.gate.state.strays) == 2
        yard.got("inner", DRIVE, "cancel_goal")
        yard.come(DRIVE, "a new process")
        yard.show(DRIVE)
        yard.meet(DRIVE)
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
    assert yard.gate.state.strays
    yard.meet_again(DRIVE)
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
        yard.show(name)
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
    if bind == "ask":
        yard.meet_again(DRIVE)
    assert not yard.gate.state.slots and yard.gate.state.strays
    yard.show(DRIVE, (66, CANCELED))
    yard.drive(2)
    assert yard.take_goal(DRIVE)[:16] == id_of(2)
