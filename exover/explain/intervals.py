"""The values of a number in finitely many intervals, such that a spec distinguishes none in one; each has a sample."""

import math
from collections.abc import Callable, Iterable, Iterator
from fractions import Fraction

from exover.dataclass import dataclass
from exover.explain.paths import Surroundings
from exover.model.types import Int, Real, plain
from exover.model.wording import value_text

FEW = 16
"""An int of at most so many values has an interval for each of them."""


@dataclass(frozen=True, slots=True)
class Interval:
    """The numbers from `low` to `high`; an end is in it iff it is closed. `sample` is one of them."""

    low: float
    high: float
    low_closed: bool
    high_closed: bool
    sample: int | float

    def meets(self, other: "Interval") -> bool:
        """Return whether the other interval follows this one with no number between."""
        if isinstance(self.sample, int):
            return self.high + 1 == other.low
        if self.high_closed and other.low_closed:
            return math.nextafter(self.high, math.inf) == other.low
        return self.high == other.low and (self.high_closed or other.low_closed)


def intervals(kind: Int | Real, cuts: Iterable[Fraction], present: int | float) -> tuple[Interval, ...]:
    """Return the intervals of the range of a type, ascending: each cut alone, and the values between two cuts.

    The sample of the interval of the present value is that value; the sample of another int is the nearest to it.
    """
    found = _of_int(kind, cuts, int(present)) if isinstance(kind, Int) else _of_real(kind, cuts, float(present))
    return tuple(found)


def _of_int(kind: Int, cuts: Iterable[Fraction], present: int) -> Iterator[Interval]:
    """Yield the intervals of an int; a cut between two integers stands for both."""
    points = {end for cut in cuts for end in (math.floor(cut), math.ceil(cut))}
    if kind.high - kind.low < FEW:
        points = set(range(kind.low, kind.high + 1))
    low = kind.low
    for point in sorted(point for point in points if kind.low <= point <= kind.high):
        if low < point:
            yield _ints(low, point - 1, present)
        yield Interval(point, point, True, True, point)
        low = point + 1
    if low <= kind.high:
        yield _ints(low, kind.high, present)


def _ints(low: int, high: int, present: int) -> Interval:
    return Interval(low, high, True, True, min(max(present, low), high))


def _of_real(kind: Real, cuts: Iterable[Fraction], present: float) -> Iterator[Interval]:
    """Yield the intervals of a real; cuts are rounded to doubles, which is what is compared."""
    points = sorted({point for point in map(float, cuts) if kind.low <= point <= kind.high})
    low, closed = kind.low, math.isfinite(kind.low)
    for point in points:
        yield from _between(low, point, closed, False, present)
        yield Interval(point, point, True, True, point)
        low, closed = point, False
    yield from _between(low, kind.high, closed, math.isfinite(kind.high), present)


def _between(low: float, high: float, low_closed: bool, high_closed: bool, present: float) -> Iterator[Interval]:
    """Yield the interval between two ends, unless it has no double."""
    first = low if low_closed else math.nextafter(low, math.inf)
    last = high if high_closed else math.nextafter(high, -math.inf)
    if first > last:
        return
    sample = min(max(present, first), last)
    if sample != present and (sample, True) not in ((low, low_closed), (high, high_closed)):
        inner = plain(low, high)
        sample = first if inner is None else inner
    yield Interval(low, high, low_closed, high_closed, sample)


# ---- what a computation tells apart ----


def refined(whole: Interval, present: int | float, around: Callable[[int | float], Surroundings]) -> Iterator[Interval]:
    """Yield the parts of an interval, ascending, in each of which a computation tells no number from its sample."""
    if whole.low == whole.high:
        yield whole
        return
    near, present = around(whole.sample), type(whole.sample)(present)
    low, is_open = max((near.low, not near.low_closed), (whole.low, not whole.low_closed))
    high, closed = min((near.high, near.high_closed), (whole.high, whole.high_closed))
    if (low, is_open) != (whole.low, not whole.low_closed):
        for rest in _part(whole.low, low, whole.low_closed, is_open, present):
            yield from refined(rest, present, around)
    yield from _part(low, high, not is_open, closed, present)
    if (high, closed) != (whole.high, whole.high_closed):
        for rest in _part(high, whole.high, not closed, whole.high_closed, present):
            yield from refined(rest, present, around)


def _part(
    low: float | Fraction, high: float | Fraction, low_closed: bool, high_closed: bool, present: int | float
) -> Iterator[Interval]:
    """Yield the interval between two ends, unless it has no number."""
    if isinstance(present, float):
        yield from _between(float(low), float(high), low_closed, high_closed, present)
        return
    first = math.ceil(low) if low_closed else math.floor(low) + 1
    last = math.floor(high) if high_closed else math.ceil(high) - 1
    if first <= last:
        yield _ints(first, last, present)


def described(first: Interval, last: Interval, kind: Int | Real) -> str:
    """Return the numbers from one interval to another as they follow `were`: `<= 0.2`, `in 10 .. 14`, `3`."""
    low, high = value_text(first.low), value_text(last.high)
    if first.low == last.high:
        return low
    if first.low == kind.low and (first.low_closed or math.isinf(first.low)):
        return f"{'<=' if last.high_closed else '<'} {high}"
    if last.high == kind.high and (last.high_closed or math.isinf(last.high)):
        return f"{'>=' if first.low_closed else '>'} {low}"
    if first.low_closed and last.high_closed:
        return f"in {low} .. {high}"
    return f"{'>=' if first.low_closed else '>'} {low} and {'<=' if last.high_closed else '<'} {high}"
