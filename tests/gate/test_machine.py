"""The state machine of the gate, by itself and beside the reference interpreter."""

from collections import Counter

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from exover.gate.outer import (
    Alarm,
    Called,
    CallId,
    Cancelled,
    CancelRefused,
    ClientGone,
    Finish,
    Forward,
    Hold,
    ModuleGone,
    Observed,
    OuterEffect,
    Refuse,
    Reported,
    SlotSaid,
    Stop,
    Ticked,
)
from exover.gate.state import ASTRAY
from exover.model.event import Args, Ask, Observe, Report
from exover.model.model import Model
from exover.ocrd.machine import Machine
from exover.pipeline import build
from exover.run.inprocess import InProcessEngine
from tests.gate.carts import SPEC, model_of
from tests.gate.outside import Compared, Outside
from tests.support.small import small_spec_of

CART = model_of(SPEC)
MOVE, STOP, REACH = ("base.move", 0), ("base.stop", 0), ("arm.reach", 0)

CONTRARY = """spec contrary;
module base { request move(); }
module arm {
    request reach() { check running(base.move); wait until not running(base.move); }
    request wave() { check waiting(arm.reach); wait until not waiting(arm.reach); }
}
"""
"""What waits for the end of something is refused once that has ended."""


def started(model: Model = CART) -> Compared:
    """Return a gate whose modules have said that nothing runs."""
    gate = Compared(model)
    for slot in sorted(gate.machine.every_slot):
        assert gate.tell(SlotSaid(slot, False), 0) == ()
    assert gate.state.started
    return gate


def ask(gate: Compared, number: int, request: str, *args: object, now: float = 0) -> tuple[OuterEffect, ...]:
    held: Args = args  # type: ignore[assignment]
    return gate.tell(Called(CallId("a", number), Ask(request, held)), now)


def test_a_launch_is_forwarded_and_its_report_finishes_the_call() -> None:
    gate = started()
    assert ask(gate, 1, "base.move", 0.5) == (Forward(CallId("a", 1), MOVE, (0.5,)),)
    assert gate.tell(Reported(Report(*MOVE, "ok", (3.0,))), 1) == (Finish(CallId("a", 1), MOVE, "ok"),)
    assert not gate.state.slots


def test_a_wait_is_held_and_forwarded_later() -> None:
    gate = started()
    ask(gate, 1, "base.move", 0.5)
    because = "reaching needs a base that stands"
    assert ask(gate, 2, "arm.reach", "left") == (Hold(CallId("a", 2), "arm.reach.wait.1", because),)
    assert ask(gate, 3, "arm.reach", "left") == (Refuse(CallId("a", 3), "busy", None),)
    ended = gate.tell(Reported(Report(*MOVE, "failed")), 1)
    assert ended == (Finish(CallId("a", 1), MOVE, "failed"), Forward(CallId("a", 2), REACH, ("left",)))


def test_a_wait_has_a_deadline() -> None:
    gate = started()
    ask(gate, 1, "base.move", 0.5)
    ask(gate, 2, "arm.reach", "left", now=1)
    assert gate.state.due == 4 and gate.tell(Ticked(), 3.9) == ()
    (refused,) = gate.tell(Ticked(), 4)
    assert isinstance(refused, Refuse) and refused.rule == "deadline" and "arm.reach.wait.1" in (refused.because or "")


def test_a_kill_stops_and_the_slot_stays_active_until_it_is_reported() -> None:
    gate = started()
    ask(gate, 1, "base.move", 0.5)
    assert ask(gate, 2, "base.stop")[0] == Stop(MOVE, "base.stop.interrupts.base.move", None)
    assert gate.tell(CancelRefused(MOVE), 1) == (Alarm("refuses-to-stop", *MOVE),)
    assert gate.tell(Ticked(), 2) == (Alarm("does-not-stop", *MOVE),) and gate.tell(Ticked(), 2.5) == ()
    assert gate.state.slots[MOVE].phase == "stopping" and STOP not in gate.state.slots
    ended = gate.tell(Reported(Report(*MOVE, "interrupted")), 3)
    assert ended == (Finish(CallId("a", 1), MOVE, "interrupted"), Forward(CallId("a", 2), STOP, ()))


def test_a_client_that_cancels_or_is_gone() -> None:
    gate = started()
    ask(gate, 1, "base.move", 0.5)
    ask(gate, 2, "arm.reach", "left")
    assert gate.tell(Cancelled(CallId("a", 2)), 0) == () and not gate.state.places
    assert gate.tell(Cancelled(CallId("b", 1)), 0) == () and gate.state.slots[MOVE].phase == "running"
    ask(gate, 3, "arm.reach", "left")
    assert gate.tell(ClientGone("a"), 0) == (Stop(MOVE, "abort", None),)
    assert not gate.state.places and gate.state.slots[MOVE].phase == "stopping"


def test_the_cancel_of_one_call_refuses_another_that_waits_for_it() -> None:
    gate = started(model_of(CONTRARY))
    ask(gate, 1, "base.move")
    assert isinstance(ask(gate, 2, "arm.reach")[0], Hold)
    told = gate.tell(Cancelled(CallId("a", 1)), 0)
    assert told == (Stop(MOVE, "abort", None), Refuse(CallId("a", 2), "arm.reach.check.1", None))


def test_what_is_refused_since_another_has_waited_too_long_is_told_its_own_rule() -> None:
    gate = started(model_of(CONTRARY))
    ask(gate, 1, "base.move")
    ask(gate, 2, "arm.reach")
    ask(gate, 3, "arm.wave", now=1)
    told = {each.call.number: each.rule for each in gate.tell(Ticked(), 3.5) if isinstance(each, Refuse)}
    assert told == {2: "deadline", 3: "arm.wave.check.1"}


def test_a_module_that_dies_is_never_taken_for_idle() -> None:
    gate = started()
    ask(gate, 1, "base.move", 0.5)
    ask(gate, 2, "arm.reach", "left")
    alarm, refused = gate.tell(ModuleGone(frozenset({"base.move"})), 0)
    assert alarm.kind == "module-gone" and refused.rule == "unavailable"  # type: ignore[union-attr]
    assert gate.tell(Ticked(), 2.9) == () and gate.state.slots[MOVE].lost
    assert ask(gate, 4, "base.move", 0.1) == (Refuse(CallId("a", 4), "unavailable", "its module is not there"),)
    assert gate.tell(SlotSaid(MOVE, True), 1) == () and gate.state.slots[MOVE].phase == "running"
    assert ask(gate, 5, "base.stop")[0] == Stop(MOVE, "base.stop.interrupts.base.move", None)
    assert Forward(CallId("a", 5), STOP, ()) in gate.tell(SlotSaid(MOVE, False), 1)


def test_a_module_that_says_of_one_slot_what_runs_is_there() -> None:
    text = """spec twice; poster low: bool = false;
    module arm { request reach(); request grip() instances 2; }
    launch again: arm.grip() when low;"""
    gate = started(model_of(text))
    first, second = ("arm.grip", 0), ("arm.grip", 1)
    gate.tell(Observed(Observe("low", True)), 0)
    gate.tell(ModuleGone(frozenset({"arm.grip", "arm.reach"})), 0)
    assert Forward(None, first, ()) in gate.tell(SlotSaid(first, False), 0)
    assert not gate.state.slots[first].lost and gate.state.away == {"arm.reach"}
    assert gate.tell(SlotSaid(second, False), 0) == ()
    gate.tell(ModuleGone(frozenset({"arm.grip", "arm.reach"})), 0)
    gate.tell(Observed(Observe("low", False)), 0)
    gate.tell(SlotSaid(second, False), 0)
    gate.tell(SlotSaid(first, False), 0)
    gate.tell(ModuleGone(frozenset({"arm.grip"})), 0)
    gate.tell(SlotSaid(second, False), 0)
    assert gate.tell(Observed(Observe("low", True)), 0) == (Forward(None, first, ()),)
    assert first not in gate.state.unsaid  # its module will not say that it was idle


def test_a_report_of_what_was_lost_says_that_it_does_not_run() -> None:
    gate = started()
    ask(gate, 1, "base.move", 0.5)
    gate.tell(ModuleGone(frozenset({"base.move"})), 0)
    gate.tell(Reported(Report(*MOVE, "failed")), 1)
    assert not gate.state.away and not gate.state.unsaid
    assert ask(gate, 2, "base.move", 0.5) == (Forward(CallId("a", 2), MOVE, (0.5,)),)


def test_nothing_goes_through_before_all_have_said_what_runs() -> None:
    gate = Compared(CART)
    (refused,) = ask(gate, 1, "base.stop")
    assert isinstance(refused, Refuse) and refused.rule == "starting"
    stray = gate.tell(SlotSaid(MOVE, True), 0)
    assert [type(each) for each in stray] == [Alarm, Stop] and gate.tell(SlotSaid(MOVE, True), 0) == ()
    for slot in sorted(gate.machine.every_slot - {MOVE}):
        gate.tell(SlotSaid(slot, False), 0)
    assert ask(gate, 2, "base.stop")[0].rule == "starting"  # type: ignore[union-attr]
    gate.tell(SlotSaid(MOVE, False), 0)
    assert isinstance(ask(gate, 3, "base.stop")[0], Forward)
    gate.tell(SlotSaid(REACH, True), 0)
    assert ask(gate, 4, "arm.grip", 1)[0].rule == "stray"  # type: ignore[union-attr]


def test_the_gate_has_not_started_as_long_as_something_stray_runs() -> None:
    gate = Compared(CART)
    others = sorted(gate.machine.every_slot - {MOVE})
    gate.tell(SlotSaid(MOVE, False), 0)
    gate.tell(SlotSaid(MOVE, True), 0)
    for slot in others:
        gate.tell(SlotSaid(slot, False), 0)
    assert not gate.state.started
    gate.tell(SlotSaid(MOVE, False), 0)
    assert gate.state.started and not gate.state.strays


def test_what_waits_is_refused_once_something_is_stray() -> None:
    gate = started()
    ask(gate, 1, "base.move", 0.5)
    ask(gate, 2, "arm.reach", "left")
    alarm, stop, refused = gate.tell(SlotSaid(("arm.grip", 0), True), 0)
    assert isinstance(alarm, Alarm) and isinstance(stop, Stop)
    assert refused == Refuse(CallId("a", 2), "stray", ASTRAY) and not gate.state.places
    ended = gate.tell(Reported(Report(*MOVE, "failed")), 1)
    assert ended == (Finish(CallId("a", 1), MOVE, "failed"),)


def test_what_waits_for_another_that_waits_is_not_launched_once_something_is_stray() -> None:
    text = """spec waits;
    module base { request move(); request stand(); }
    module arm {
        request reach() { wait until not running(base.move); }
        request wave() { wait until not waiting(arm.reach); }
    }
    """
    gate = started(model_of(text))
    ask(gate, 1, "base.move")
    ask(gate, 2, "arm.reach")
    ask(gate, 3, "arm.wave")
    _, _, first, second, _ = gate.tell(SlotSaid(("base.stand", 0), True), 0)
    assert first == Refuse(CallId("a", 2), "stray", ASTRAY) and second == Refuse(CallId("a", 3), "stray", ASTRAY)
    assert not gate.state.places and gate.state.slots.keys() == {MOVE}


def test_what_is_read_before_the_start_requires_nothing_until_then() -> None:
    gate = Compared(model_of(SPEC + "poster tired: bool = false; launch rest: base.stop() when tired;"))
    slots = sorted(gate.machine.every_slot)
    gate.tell(Observed(Observe("tired", False)), 0)
    assert gate.tell(Observed(Observe("tired", True)), 0) == ()
    for slot in slots:
        assert gate.tell(SlotSaid(slot, False), 0) == ()
    assert gate.tell(Ticked(), 0) == (Forward(None, STOP, ()),) and not gate.state.readings


def test_a_report_of_what_does_not_run_is_told_and_changes_nothing() -> None:
    gate = started()
    before = gate.state
    (alarm,) = gate.tell(Reported(Report(*MOVE, "ok", (1.0,))), 0)
    assert isinstance(alarm, Alarm) and alarm.kind == "stray" and gate.state == before


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6))
@example(3068)  # the cancel of a call that runs refuses one that waits
def test_it_knows_what_is_active_whatever_happens(seed: int) -> None:
    compare(small_spec_of(seed), seed, 120)


@pytest.mark.parametrize("seed", range(3))
def test_it_decides_alike_on_tables_and_on_the_emitted_c(seed: int) -> None:
    model = model_of(SPEC)
    tables = build(model).tables
    effects = compare(SPEC, seed, 800, Machine(model, tables), InProcessEngine(model, tables))
    assert set(effects) == {"Forward", "Hold", "Refuse", "Stop", "Finish", "Alarm"}


def compare(text: str, seed: int, events: int, *checkers: object) -> Counter[str]:
    """Hold a gate beside the reference while anything happens; return how often it did what."""
    model = model_of(text)
    gate, outside = Compared(model, *checkers), Outside(model, seed)  # type: ignore[arg-type]
    now = 0.0
    for slot in sorted(gate.machine.every_slot):
        gate.tell(SlotSaid(slot, False), now)
    for _ in range(events):
        now += 0.25
        gate.tell(outside.event(), now)
    held = [each.call for each in (*gate.state.slots.values(), *gate.state.places.values()) if each.call]
    assert set(held) == gate.ledger.open() - gate.given_up and len(held) == len(set(held))
    return gate.ledger.effects
