"""The proxy of ROS 2 without DDS: goals, their results and their cancels."""

import math
from random import Random

import pytest

pytest.importorskip("rosbags", reason="the extra exover[ros2] is not installed")

from exover.gate.ros2 import cdr, goals
from exover.gate.ros2.cdr import ABORTED, ACCEPTED, CANCELED, CANCELING, EXECUTING, SUCCEEDED, Stamp
from exover.gate.ros2.names import SERVICES, Port
from tests.gate.ros_middle import DRIVE, REACH, RosMiddle, id_of
from tests.gate.yard import BIND


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
