"""The reachable states, found forwards, are those of plain enumeration, and backwards nothing else is found."""

from collections import Counter

import pytest

from exover.engines.bdd.analysis import Analysis
from exover.engines.bdd.manager import Set
from exover.engines.bdd.space import Space
from exover.loop.finite.abstraction import abstract
from exover.loop.finite.variables import GuardedValue
from exover.model.semantics import Reference
from exover.pipeline import load_properties
from exover.source import Source
from tests.support.engines import model_of
from tests.support.small import VARIED, compiled, explored, small_spec_of


@pytest.mark.parametrize("seed", VARIED)
def test_forwards_backwards_and_by_enumeration_the_same_states_are_reached(seed: int) -> None:
    made = compiled(model_of(small_spec_of(seed)))
    analysis = Analysis(made, Reference(made.model), lambda what: None)
    space, reached = analysis.space, analysis.reached
    for state in explored(seed).states:
        assert space.cube_of(abstract(analysis.loop, state)) & reached != space.none
    assert reached & ~analysis.stepper.universe == space.none
    assert not analysis.reaches(analysis.stepper.universe & ~reached)


def test_a_sum_that_many_conditions_read_is_made_once(monkeypatch: pytest.MonkeyPatch) -> None:
    made, make = Counter[int](), Space._sum_of

    def counted(space: Space, terms: list[tuple[int, GuardedValue]]) -> dict[int, Set]:
        made[number] += 1
        return make(space, terms)

    monkeypatch.setattr(Space, "_sum_of", counted)
    spec = compiled(model_of("spec s; poster p: int in 0 .. 99 = 0; module m { request a(); request b(); }"))
    for number in (2, 20):
        text = "for s;" + "".join(f"assume never p == {2 * value + 1};" for value in range(number))
        assumed = load_properties(Source("s.prop", text), spec.model).properties
        assert assumed is not None
        analysis = Analysis(spec, Reference(spec.model), lambda what: None, assumed)
        assert analysis.stepper.allowed != analysis.space.all
    assert made[2] == made[20] > 0
