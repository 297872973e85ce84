"""The reachable states, found forwards, are those of plain enumeration, and backwards nothing else is found."""

import pytest

from exover.engines.bdd.analysis import Analysis
from exover.loop.finite.abstraction import abstract
from exover.model.semantics import Reference
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
