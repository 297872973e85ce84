"""One gate of one robot: transports of several protocols share its state."""

from collections.abc import Mapping
from typing import Any

import pytest

from exover.gate.binding import BindingKind
from exover.gate.gate import Gate
from exover.gate.outer import (
    Called,
    CallId,
    CancelRefused,
    ClientGone,
    Forward,
    Hold,
    OuterEffect,
    Refuse,
    SlotSaid,
    Stop,
)
from exover.model.event import Ask
from exover.ocrd.machine import Machine
from exover.pipeline import build
from exover.run.simulate import Engine, ReferenceEngine
from tests.gate.carts import BIND, SPEC, binding_of, kept_in, model_of

MIXED = BIND.replace('tool = "reach"', 'action = "/reach"\ntype = "arm/action/Reach"').replace(
    'cancel = { tool = "stow", ends = true }\n', ""
)
MODEL = model_of(SPEC)
MOVE, REACH = ("base.move", 0), ("arm.reach", 0)


class Recorder:
    """A transport that does nothing but remember."""

    def __init__(self, name: str, kinds: tuple[BindingKind, ...]) -> None:
        self.name = name
        self.kinds = kinds
        self.done: list[OuterEffect] = []

    def do(self, effect: OuterEffect) -> None:
        self.done.append(effect)


def started(checker: Engine) -> tuple[Gate, Recorder, Recorder, list[Mapping[str, Any]]]:
    journal: list[Mapping[str, Any]] = []
    gate = Gate(MODEL, binding_of(MIXED, MODEL), checker, lambda: 0.0, kept_in(journal))
    tools, actions = Recorder("mcp", ("tool",)), Recorder("ros2", ("action", "service"))
    gate.attach(tools)
    gate.attach(actions)
    for slot in sorted(gate.state.unsaid):
        gate.tell(SlotSaid(slot, False))
    return gate, tools, actions, journal


def test_clients_of_two_protocols_share_the_state() -> None:
    gate, tools, actions, _ = started(Machine(MODEL, build(MODEL).tables))
    agent, mission = CallId("mcp", 1), CallId("ros2/mission", 1)
    gate.call(agent, "base.move", {"v": 0.5})
    assert tools.done == [Forward(agent, MOVE, (0.5,))]
    gate.call(mission, "arm.reach", {"side": "left"})
    because = "reaching needs a base that stands"
    assert actions.done == [Hold(mission, "arm.reach.wait.1", because)]
    gate.report(MOVE, {"outcome": "ok", "results": {"distance": 1}})
    assert actions.done[-1] == Forward(mission, REACH, ("left",)) and len(tools.done) == 2


def test_what_happens_while_effects_are_done_happens_afterwards() -> None:
    class Stubborn(Recorder):
        def do(self, effect: OuterEffect) -> None:
            super().do(effect)
            if isinstance(effect, Stop):
                gate.tell(CancelRefused(effect.slot))

    gate, _, _, journal = started(ReferenceEngine(MODEL))
    stubborn = Stubborn("mcp", ("tool",))
    gate.attach(stubborn)
    gate.call(CallId("mcp", 1), "base.move", {"v": 0.5})
    gate.call(CallId("mcp", 2), "base.stop", {})
    kinds = [type(effect).__name__ for effect in stubborn.done]
    assert kinds == ["Forward", "Stop", "Hold", "Alarm"]
    assert journal[-1]["alarm"] == "refuses-to-stop"


def test_results_that_are_none_end_the_slot_all_the_same() -> None:
    gate, _, _, journal = started(ReferenceEngine(MODEL))
    gate.call(CallId("mcp", 1), "base.move", {"v": 0.5})
    gate.report(MOVE, {"outcome": "ok", "results": {"distance": 1e9}})
    assert MOVE not in gate.state.slots and "out-of-range" in journal[-2]["detail"]
    assert journal[-1]["event"] == {"report": "base.move", "instance": 0, "outcome": "failed"}


def test_a_faulty_checker_denies_and_stops_what_runs() -> None:
    class Faulty(ReferenceEngine):
        fault = 0

    checker = Faulty(MODEL)
    gate, tools, _, journal = started(checker)
    gate.call(CallId("mcp", 1), "base.move", {"v": 0.5})
    checker.fault = 7
    gate.tell(Called(CallId("mcp", 2), Ask("arm.grip", (99,))))
    assert [entry["alarm"] for entry in journal if "alarm" in entry] == ["faulty"]
    assert Stop(MOVE, "abort", None) in tools.done and gate.state.slots[MOVE].phase == "stopping"


def test_a_call_that_cannot_be_is_refused_before_anybody_is_asked() -> None:
    gate, tools, _, journal = started(ReferenceEngine(MODEL))
    gate.call(CallId("mcp", 1), "base.move", {"v": float("nan")})
    (refused,) = tools.done
    assert isinstance(refused, Refuse) and refused.rule == "out-of-range" and journal[-1]["refused"] == "base.move"


def test_a_reading_that_is_none_is_the_worst() -> None:
    model = model_of(SPEC + "poster bumped: bool = false else true; poster floor: int in 0 .. 3 = 0;")
    journal: list[Mapping[str, Any]] = []
    gate = Gate(model, binding_of(BIND, model), ReferenceEngine(model), lambda: 0.0, kept_in(journal))
    for slot in sorted(gate.state.unsaid):
        gate.tell(SlotSaid(slot, False))
    for name, value in (("bumped", "yes"), ("base.speed", None), ("base.speed", 7), ("floor", "first"), ("moon", 1)):
        gate.observe(name, value)
    told = [entry.get("event") or entry["detail"].split(":")[0] for entry in journal]
    outside = {"observe": "base.speed", "value": 3}
    bumped = {"observe": "bumped", "value": True}
    assert told == ["wrong-type", bumped, "wrong-type", outside, outside, "wrong-type", "unknown-poster"]


def test_an_effect_that_fails_keeps_no_stop_from_being_sent() -> None:
    class Broken(Recorder):
        def do(self, effect: OuterEffect) -> None:
            super().do(effect)
            raise ValueError(f"cannot do {effect}")

    gate, tools, _, journal = started(Machine(MODEL, build(MODEL).tables))
    broken = Broken("mcp", ("tool",))
    asked: list[tuple[str, Mapping[str, Any]]] = [("base.move", {"v": 0.5}), *[("arm.grip", {"force": 1})] * 2]
    for number, (request, args) in enumerate(asked):
        gate.call(CallId("mcp", number), request, args)
    assert len(tools.done) == 3
    gate.attach(broken)
    with pytest.raises(ValueError, match=r"cannot do Stop"):
        gate.tell(ClientGone("mcp"))
    assert {effect.slot for effect in broken.done if isinstance(effect, Stop)} == set(gate.state.slots)
    assert len(journal) == 6


def test_a_journal_that_fails_keeps_nothing_from_going_out() -> None:
    def full(entry: str) -> None:
        raise OSError("no space")

    gate = Gate(MODEL, binding_of(MIXED, MODEL), Machine(MODEL, build(MODEL).tables), lambda: 0.0, full)
    tools = Recorder("mcp", ("tool",))
    gate.attach(tools)
    gate.tell(*(SlotSaid(slot, False) for slot in sorted(gate.state.unsaid)))
    with pytest.raises(OSError, match="no space"):
        gate.call(CallId("mcp", 1), "base.move", {"v": 0.5})
    assert [type(effect) for effect in tools.done] == [Forward]
