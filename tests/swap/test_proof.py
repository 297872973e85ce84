"""What `exover swap` proves is true of random runs of OLD: no rule of NEW is broken once the named have ended."""

from dataclasses import replace

import pytest

from exover.model.model import Model
from exover.model.semantics import Reference
from exover.model.state import State
from exover.ocrd.decision_context import DecisionContext
from exover.ocrd.vector import Vocabulary
from exover.pipeline import build, swap
from exover.swap.prove import SwapAnswer
from tests.support.engines import model_of
from tests.support.events import Stream
from tests.support.fuzz import spec_of
from tests.support.proving import proved

SEEDS = (0, 2, 5, 13, 21, 34)


def carried(state: State, answer: SwapAnswer, new: Model) -> State:
    """Return the state with what NEW starts with in place of what OLD does not remember."""
    for name in answer.forgotten:
        if name in new.variable:
            state = state.with_reading(name, new.variable[name].initial)
        elif name in new.resource:
            state = state.with_level(name, new.resource[name].initial)
        else:
            state = state.with_past(name.removeprefix("past(").removesuffix(")"), None)
    return state


def broken(new: Model, state: State) -> list[str]:
    """Return the rules of NEW that are broken in a state and are not restored yet."""
    reference, questions = Reference(new), DecisionContext(Vocabulary(new))
    found = []
    for rule in new.rules:
        seen = state.once_stopped() if questions.restored(rule) else state
        found += [rule.name for each in reference.instances(seen, rule) if reference.true(seen, each)]
    return found


@pytest.mark.parametrize("seed", SEEDS)
def test_no_state_of_old_breaks_a_rule_of_new(seed: int) -> None:
    """OLD has every other rule; where that is not proved, some rule is named that may be broken."""
    new = model_of(spec_of(seed))
    old = replace(new, name="old", rules=new.rules[::2])
    before = build(old)
    _, answer = swap(before, build(new), proved(before))
    assert (answer.verdict == "holds") == (answer.open == ())
    stream, looked = Stream(old, seed), 0
    for _ in stream.lines(400):
        state = carried(stream.state, answer, new)
        idle = not any(slot for name in answer.ended for slot in state.slots[name])
        looked += idle
        wrong = [name for name in broken(new, state) if name not in answer.open] if idle else []
        assert wrong == [], stream.state
    assert looked > 0


def test_requests_that_are_named_are_needed() -> None:
    """Without their end, runs come to states that NEW forbids: what is named is not named in vain."""
    seen = 0
    for seed in SEEDS:
        new = model_of(spec_of(seed))
        old = replace(new, name="old", rules=new.rules[::2])
        stream = Stream(old, seed)
        seen += any(broken(new, stream.state) for _ in stream.lines(400))
    assert seen >= 2
