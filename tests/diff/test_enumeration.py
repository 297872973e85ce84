"""What changes from one version to another, compared with plain enumeration of all runs of both."""

from itertools import product
from random import Random

import pytest

from exover.diff.compare import differences
from exover.engines.aig.versions import ComparedLoops
from exover.model.property import NO_PROPERTIES
from exover.model.versions import Versions
from tests.support.edits import FINITE, edited, enumerated
from tests.support.engines import model_of
from tests.support.generate import random_spec
from tests.support.small import compiled

SEEDS = (0, 1, 2, 3, 7, 8, 9, 12, 13, 15, 18, 23, 26, 28)
CASES = (*product(SEEDS, range(2)), (25, 0))
"""Of the first thirty random specs those that have few states, and edits of them that have."""
STATES = 100


@pytest.mark.parametrize(("seed", "edit"), CASES)
def test_changes_and_their_shortest_runs_are_those_of_all_runs(seed: int, edit: int) -> None:
    old = model_of(random_spec(seed, FINITE))
    new = edited(old, Random(2 * seed + edit))
    wanted = enumerated(old, new, STATES)
    loops = ComparedLoops(Versions(old, new), (compiled(old), compiled(new)), (NO_PROPERTIES, NO_PROPERTIES))
    shown, undecided = differences(loops, "", print)
    assert not undecided
    assert {each.change: len(each.steps) for each in shown} == wanted
    assert all(each.shortest for each in shown)
