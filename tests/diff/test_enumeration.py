"""What changes from one version to another, compared with plain enumeration of all runs of both."""

from random import Random

import pytest

from exover.diff.compare import differences
from exover.model.property import NO_PROPERTIES
from exover.model.versions import Versions
from tests.support.edits import FINITE, TooLarge, edited, enumerated
from tests.support.engines import model_of
from tests.support.generate import random_spec
from tests.support.small import compiled

STATES = 100
EDITS = 2


@pytest.mark.parametrize("seed", range(6))
def test_changes_and_their_shortest_runs_are_those_of_all_runs(seed: int) -> None:
    looked = 0
    for number in range(5 * seed, 5 * seed + 5):
        old = model_of(random_spec(number, FINITE))
        for edit in range(EDITS):
            new = edited(old, Random(EDITS * number + edit))
            try:
                wanted = enumerated(old, new, STATES)
            except TooLarge:
                break
            both = (compiled(old), compiled(new))
            shown, undecided = differences(Versions(old, new), both, (NO_PROPERTIES, NO_PROPERTIES), "", print)
            assert not undecided
            assert {each.change: len(each.steps) for each in shown} == wanted
            assert all(each.shortest for each in shown)
            looked += 1
    assert looked
