"""Specs that grow: their tables grow as the rules do, deep diagrams are built, and small ones decide rightly."""

from collections.abc import Callable

import pytest

from benchmarks import families
from exover import pipeline
from exover.source import Source
from tests.support.engines import disagreement, model_of
from tests.support.events import Stream

ALL = (
    families.mutexes,
    families.priorities,
    families.stop,
    families.crowd,
    families.limit,
    families.limit_all,
    families.power,
    families.contexts,
)
LINEAR = (families.mutexes, families.stop, families.crowd, families.limit, families.contexts)
COMPILED = (families.priorities, families.power)
"""Those that the compiled C is asked about, too."""
Family = Callable[[int], str]


def nodes(text: str) -> int:
    model = pipeline.load(Source("family.exo", text)).model
    assert model is not None
    return pipeline.build(model).compiled.figures.nodes


@pytest.mark.parametrize("family", ALL, ids=lambda family: family.__name__)
def test_the_tables_of_every_family_answer_as_the_reference_does(family: Family) -> None:
    text = family(6)
    found = disagreement(text, tuple(Stream(model_of(text), 0).lines(200)), native=family in COMPILED)
    assert found is None, f"\n{found}"


@pytest.mark.parametrize("family", LINEAR, ids=lambda family: family.__name__)
def test_nodes_are_linear_in_the_rules(family: Family) -> None:
    """Twice as many rules again add as many nodes, but for what a random spec is better or worse off."""
    small, middle, large = (nodes(family(size)) for size in (16, 32, 48))
    assert abs((large - middle) - (middle - small)) <= small // 20


@pytest.mark.parametrize(("family", "per_request"), [(families.stop, 8), (families.crowd, 4)])
def test_diagrams_of_hundreds_of_levels_are_built(family: Family, per_request: int) -> None:
    assert nodes(family(300)) <= per_request * 302
