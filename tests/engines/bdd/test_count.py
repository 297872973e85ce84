"""Reachable states are counted exactly: as many as plain enumeration finds, counted apart or together."""

import pytest

from exover.engines.bdd import decomposition as exploring
from exover.engines.bdd.analysis import Analysis
from exover.engines.bdd.count import count, count_states
from exover.engines.bdd.decomposition import parts
from exover.loop.finite.abstraction import abstract
from exover.model.model import NOWHERE
from exover.model.property import NO_PROPERTIES, Disjunction, Happened, Properties, Property
from exover.model.semantics import Reference
from tests.support.engines import model_of
from tests.support.oracle import Graph, explore
from tests.support.small import VARIED, compiled, explored, small_spec_of

APART = """spec apart;
module m { request a(); request b(); }
module k { poster p: int in 0 .. 2 = 0; request c() { check p < 2; on ok set s = y; } state s: {x, y} = x; }
mutex m.a, m.b by wait;
"""
RESTLESS = APART + 'launch again: k.c() when k.p == 2 because "it is tried in every step";\n'
PENDING = APART + 'launch first: k.c() when k.p == 0 because "any step launches it";\n'


def analysis_of(text: str, properties: Properties = NO_PROPERTIES) -> Analysis:
    made = compiled(model_of(text))
    return Analysis(made, Reference(made.model), lambda what: None, properties)


def enumerated(analysis: Analysis, graph: Graph) -> int:
    """Return how many states plain enumeration has found, as far as the loop tells them apart."""
    return len({tuple(abstract(analysis.loop, state)) for state in graph.states})


@pytest.mark.parametrize("seed", VARIED)
def test_as_many_states_are_counted_as_enumerated(seed: int) -> None:
    analysis = analysis_of(small_spec_of(seed))
    assert count_states(analysis.stepper) == enumerated(analysis, explored(seed))


@pytest.mark.parametrize("text", [APART, RESTLESS, PENDING])
def test_parts_are_counted_apart_where_that_is_right(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    analysis = analysis_of(text)
    assert len(parts(analysis.loop)) > 1
    asked: list[object] = []
    whole = exploring.explore
    monkeypatch.setattr(exploring, "explore", lambda *given: asked.append(given[1:]) or whole(*given))
    assert count_states(analysis.stepper) == enumerated(analysis, explore(analysis.compiled.model, 1500, 20_000))
    assert (() in asked) == (text != APART)


def test_what_the_last_step_did_is_no_part_of_a_state() -> None:
    atoms = [Happened("launched", name) for name in ("m.a", "m.b", "k.c")]
    told = Properties((Property("p", None, "ctl", Disjunction(tuple(atoms)), None, NOWHERE),))
    assert count_states(analysis_of(APART, told).stepper) == count_states(analysis_of(APART).stepper)


def test_many_parts_are_counted_beyond_what_floats_hold() -> None:
    modules = "".join(f"module m{n} {{ request a(); request b(); }}\n" for n in range(40))
    rules = "".join(f"mutex m{n}.a, m{n}.b by wait;\n" for n in range(40))
    analysis = analysis_of(f"spec many;\n{modules}{rules}")
    one = count_states(analysis_of("spec one; module m { request a(); request b(); } mutex m.a, m.b by wait;").stepper)
    assert count_states(analysis.stepper) == one**40
    assert one > 5


def test_states_of_parts_are_the_states_of_the_whole() -> None:
    analysis = analysis_of(APART)
    states = {tuple(abstract(analysis.loop, state)) for state in explore(analysis.compiled.model, 1500, 20_000).states}
    assert len(parts(analysis.loop)) > 1
    assert count(analysis.space, analysis.reached, range(len(analysis.loop.variables))) == len(states)
    assert all(analysis.space.cube(list(state)) & analysis.reached != analysis.space.none for state in states)
