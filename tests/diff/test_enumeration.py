"""What changes from one version to another, compared with plain enumeration of all runs of both."""

from random import Random

import pytest

from exover.diff.compare import differences
from tests.support.edits import FINITE, edited, enumerated, loops_of
from tests.support.engines import model_of
from tests.support.generate import random_spec
from tests.support.small import compiled

CASES = (
    *((1, 0), (2, 0), (2, 1), (3, 0), (8, 1), (9, 0), (9, 1), (15, 1), (18, 0), (18, 1), (23, 1), (25, 0), (26, 1)),
)  # fmt: skip
"""Of the first thirty random specs and edits of them that have few states: twice each construct, edit and change."""
STATES = 100


@pytest.mark.parametrize(("seed", "edit"), CASES)
def test_changes_and_their_shortest_runs_are_those_of_all_runs(seed: int, edit: int) -> None:
    old = model_of(random_spec(seed, FINITE))
    new = edited(old, Random(2 * seed + edit))
    wanted = enumerated(old, new, STATES)
    shown, undecided = differences(loops_of(compiled(old), compiled(new)), "", print)
    assert not undecided
    assert {each.change: len(each.steps) for each in shown} == wanted
    assert all(each.shortest for each in shown)
