"""How many passes every step needs."""

import pytest

from exover.engines.aig.passes import enough_passes
from exover.model.property import NO_PROPERTIES
from exover.pipeline import load_properties
from exover.source import Source
from tests.support.engines import model_of
from tests.support.launches import chain
from tests.support.small import compiled


@pytest.mark.parametrize("length", [1, 2, 5])
def test_each_launch_after_another_needs_one(length: int) -> None:
    made = compiled(model_of(f"spec s; {chain(length)}"))
    assert enough_passes(made, NO_PROPERTIES) == max(1, length)


def test_steps_that_are_forbidden_count() -> None:
    """Whether a step is forbidden is known once it is settled."""
    made = compiled(model_of(f"spec s; {chain(5)}"))
    loaded = load_properties(Source("s.prop", "for s; assume never asked(m.r0, m.r1, m.r2);"), made.model)
    assert loaded.properties is not None
    assert enough_passes(made, loaded.properties) == 5


def test_more_than_twelve_are_not_tried() -> None:
    assert enough_passes(compiled(model_of(f"spec s; {chain(14)}")), NO_PROPERTIES) is None
