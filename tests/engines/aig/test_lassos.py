"""Which steps are dropped from a lasso together."""

from exover.engines.aig.lassos import _joined, _without
from exover.engines.aig.random_lassos import InputLasso

STEPS = tuple(frozenset({number}) for number in range(8))


def test_blocks_are_dropped_from_where_they_are() -> None:
    lasso = InputLasso(STEPS[:5], STEPS[5:])
    assert _without(lasso, (0, 4), 2) == InputLasso(STEPS[2:4], STEPS[6:])
    assert _without(lasso, (6,), 1) == InputLasso(STEPS[:5], (STEPS[5], STEPS[7]))
    assert not _without(lasso, (5,), 3).loop


def test_blocks_that_overlap_are_not_dropped_together() -> None:
    singles = [(0,), (1,), (2,), (4,), (5,), (7,)]
    assert _joined(singles, 2) == [(0, 2), (0, 2, 4, 7)]
    assert _joined(singles, 1) == [(0, 1), (0, 1, 2, 4), (0, 1, 2, 4, 5, 7)]
    assert _joined([(3,)], 1) == []


def test_blocks_are_joined_once() -> None:
    assert _joined([(0, 2), (0, 2, 4)], 1) == []
