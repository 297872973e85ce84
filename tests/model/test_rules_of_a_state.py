"""The interpreter looks only at rules that may hold: none that holds is left out."""

import pytest

from exover.model.event import Ask
from exover.model.model import Model, Request, Rule
from exover.model.semantics import Reference
from exover.model.state import State
from tests.support.engines import model_of
from tests.support.events import Stream
from tests.support.fuzz import VARIED, spec_of


def holding(stream: Stream, state: State) -> list[Rule]:
    """Return the rules that hold in a state for some slot, all of them asked."""
    reference = stream.reference
    return [r for r in stream.model.rules if any(reference.true(state, i) for i in reference.instances(state, r))]


@pytest.mark.parametrize("seed", VARIED)
def test_no_rule_that_holds_is_left_out(seed: int) -> None:
    stream = Stream(model_of(spec_of(seed)), seed)
    for _ in stream.answered(100):
        for state in (stream.state, stream.state.once_stopped()):
            looked_at = stream.reference.rules(state)
            assert [r for r in stream.model.rules if r in looked_at] == looked_at
            assert all(rule in looked_at for rule in holding(stream, state))
            assert sorted(state.held) == sorted(state.active())


def test_rules_about_what_is_idle_are_left_out() -> None:
    spec = """spec s; resource p: 3;
    module m {
        request a() { uses p 2; }
        request b() { uses p 2; fail when d; }
        request c();
    }
    poster d: bool = false;
    mutex m.a, m.b;
    limit at most 1 of m.b, m.c;
    forbid out: active(m.a) and d by kill m.a;
    forbid either: (active(m.b) or active(m.c)) and d by kill m.b, m.c;
    forbid odd: not active(m.a) and active(m.c) and level(q) < 1;
    resource q: 3 consumable;
    """
    reference = Reference(model_of(spec))
    assert reference.rules(reference.start()) == []
    state, _ = reference.step(reference.start(), Ask("m.c", ()))
    assert [rule.name for rule in reference.rules(state)] == ["limit.1", "either", "odd"]
    state, _ = reference.step(reference.start(), Ask("m.a", ()))
    assert [rule.name for rule in reference.rules(state)] == ["p", "out"], "of the mutex both must be active"


class AskingAll(Reference):
    """An interpreter that asks a newcomer about every rule in question."""

    def possible(self, state: State, request: Request) -> list[Rule]:
        return list(self.questions[request.name])


class AskingAllStream(Stream):
    """An environment that is answered by it."""

    def __init__(self, model: Model, seed: int) -> None:
        super().__init__(model, seed)
        self.reference = AskingAll(model)


@pytest.mark.parametrize("seed", VARIED)
def test_no_rule_that_objects_to_a_newcomer_is_left_out(seed: int) -> None:
    model = model_of(spec_of(seed))
    found = [list(stream.answered(100)) for stream in (Stream(model, seed), AskingAllStream(model, seed))]
    assert found[0] == found[1]


def test_a_newcomer_is_asked_about_what_is_active_or_clearing() -> None:
    spec = """spec s;
    module m {
        request a() { settle until d; }
        request b();
        request c() instances 2;
    }
    poster d: bool = false;
    mutex m.a, m.b;
    mutex m.b over m.c;
    forbid out: active(m.b) and d by kill m.b;
    """
    reference = Reference(model_of(spec))
    request, start = reference.model.request["m.b"], reference.start()
    assert [rule.name for rule in reference.possible(start, request)] == ["out"]
    state, _ = reference.step(start, Ask("m.c", ()))
    assert [rule.name for rule in reference.possible(state, request)] == ["mutex.2", "out"]
    state, _ = reference.step(start, Ask("m.a", ()))
    assert state.places["m.a"], "it is clearing, and counts as active where a rule may kill the newcomer"
    assert [rule.name for rule in reference.possible(state, request)] == ["mutex.1", "out"]
