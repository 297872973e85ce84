"""How the work of a function grows with its input, in calls of functions: the same on every machine, however busy."""

import sys
from collections.abc import Callable
from types import FrameType

LINEAR = 2.6
"""Twice the input takes at most so many times the calls of the work that is linear, logarithms included."""


def calls(work: Callable[[], object]) -> int:
    """Return how many functions of Python and of C are called while a function works."""
    count = 0

    def called(frame: FrameType, event: str, argument: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(called)
    try:
        work()
    finally:
        sys.setprofile(before)
    return count


def growth(work: Callable[[int], object], size: int) -> float:
    """Return how many times the calls of a size are made for twice the size."""
    work(1)  # what is made once, at the first call, is of no size
    return calls(lambda: work(2 * size)) / calls(lambda: work(size))
