"""Conditions before a look at the latches say what they would say after it."""

from exover.model.evaluate import holds
from exover.model.expression import Compare, Const, Not, Reading
from exover.model.model import Model
from exover.model.state import State
from exover.swap.latching import Latching
from tests.support.engines import model_of
from tests.support.events import Stream

SPEC = """spec s; poster p: bool = false; poster q: bool = true; resource ink: 3 consumable;
latch low: when level(ink) < 2 until m.b; latch warm: when p until m.b; latch hot: when warm and not q until m.b;
module m { request a() { consumes ink 1; } request b(); request c(); }"""
CONDITIONS = (
    "low", "not low", "hot", "hot == true", "true != hot", "hot == p", "p != warm", "warm == hot",
    "active(m.a) and low", "q", "active(m.a)",
)  # fmt: skip


def looked_at(model: Model, state: State) -> State:
    for latch in model.latches:
        if holds(model, state, latch.condition):
            state = state.with_reading(latch.name, True)
    return state


def test_before_the_look_it_says_what_holds_after() -> None:
    rules = "".join(f"forbid {cond} and active(m.c) by kill m.c;" for cond in CONDITIONS)
    model = model_of(SPEC + rules)
    conditions = [rule.condition for rule in model.rules]
    conditions += [Not(cond) for cond in conditions]
    conditions += [Compare("!=", Const(False), Reading("hot")), Compare("==", Reading("low"), Reading("hot"))]
    latching = Latching(model)
    stream, differ = Stream(model, 3), 0
    for _ in stream.lines(300):
        after = looked_at(model, stream.state)
        differ += after != stream.state
        for cond in conditions:
            assert holds(model, stream.state, latching.latched(cond)) == holds(model, after, cond), cond
    assert differ > 0


def test_what_reads_no_latch_stays() -> None:
    model = model_of(f"{SPEC} forbid q and active(m.a) by kill m.a;")
    (rule,) = model.rules
    assert Latching(model).latched(rule.condition) == rule.condition
