"""Doubles that stand for all between two others."""

import math
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from exover.loop.finite.tested_bounds import points
from exover.model.types import plain

ENDS = st.floats(allow_nan=False)


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [
        (0.7, 1.1, 1.0),
        (0.8, 1.0, 0.9),
        (0.6, 1.2, 1.0),
        (0.0, 0.9, 0.5),
        (-1.0, 1.0, 0.0),
        (0.0, 2.0, 1.0),
        (0.9, math.inf, 2.0),
        (-math.inf, 0.9, -0.0),
        (-math.inf, math.inf, 0.0),
    ],
)
def test_few_digits(low: float, high: float, expected: float) -> None:
    found = plain(low, high)
    assert found == expected and math.copysign(1, found) > 0


@given(ENDS, ENDS)
def test_strictly_between_iff_there_is_a_double(low: float, high: float) -> None:
    low, high = min(low, high), max(low, high)
    first = math.nextafter(low, math.inf) if low != -math.inf else -sys.float_info.max
    found = plain(low, high)
    assert (found is None) == (not first < high)
    if found is not None:
        assert low < found < high and math.isfinite(found)


def test_samples_have_few_digits() -> None:
    assert points(0.0, 2.0, (0.6, 0.9, 1.2), 1) == [0.0, 0.3, 0.6, 0.8, 0.9, 1.0, 1.2, 1.6, 2.0]
    assert len(points(0.0, 1.0, (), 3)) == 5
