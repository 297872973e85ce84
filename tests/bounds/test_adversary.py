"""The bounds of the specs here are near to what runs reach that are to cost as much as they can."""

from pathlib import Path

import pytest

from exover.engines.aig.costs import tightened
from tests.bounds.adversary import reached
from tests.runtime.compiling import ROOT, built

TIMES = 3
"""How many times what is reached the bounds of the worst event are, at most."""


@pytest.mark.parametrize("path", sorted((ROOT / "specs").glob("*.exo")), ids=lambda path: path.stem)
def test_bounds_are_near_to_what_is_reached(path: Path) -> None:
    found = built(path)
    worst, most = tightened(found.compiled).worst, reached(found)
    assert most.tests <= worst.tests <= TIMES * most.tests
    assert most.answers <= worst.answers <= TIMES * most.answers
    assert most.passes <= worst.passes <= TIMES * most.passes
