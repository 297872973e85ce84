"""Around a number, those with which a computation goes the same way: all its comparisons come out as they do with it.

The computation is done once, with a probe in place of the number that notes what it is compared with (concolic
execution; Godefroid, Klarlund, Sen 2005). So what is found holds of everything that the computation reads.
"""

import math
import operator
from collections.abc import Callable
from fractions import Fraction
from typing import Any

from exover.dataclass import dataclass


@dataclass(slots=True)
class Surroundings:
    """The numbers around `sample` that no comparison has told from it so far; an end is among them iff it is closed.

    An end is a `Fraction`, or infinite. `joint` iff the number was compared with, or added to, another with a probe.
    """

    sample: int | float
    low: Any = -math.inf
    high: Any = math.inf
    low_closed: bool = False
    high_closed: bool = False
    joint: bool = False

    def hold(self, low: float, high: float, low_closed: bool, high_closed: bool) -> bool:
        """Return whether all numbers of an interval are among them."""
        begins = (self.low, not self.low_closed) <= (low, not low_closed)
        return begins and (high, high_closed) <= (self.high, self.high_closed)

    def probe(self) -> "IntProbe | RealProbe":
        """Return the number, such that its comparisons are noted here."""
        made = IntProbe(self.sample) if isinstance(self.sample, int) else RealProbe(self.sample)
        made.around, made.factor, made.constant = self, 1, Fraction(0)
        return made

    def compare(self, test: Callable[[Any, Any], bool], factor: int, constant: Fraction) -> bool:
        """Return whether `factor * x + constant` compares so with 0, and note how far it does for numbers near x."""
        if factor == 0:
            return test(constant, 0)
        cut, sample = -constant / factor, Fraction(self.sample)
        below, at, above = test(-factor, 0), test(0, 0), test(factor, 0)
        truth = below if sample < cut else above if sample > cut else at
        if sample < cut or (sample == cut and above != at):
            self._end(cut, closed=truth == at)
        if sample > cut or (sample == cut and below != at):
            self._begin(cut, closed=truth == at)
        return truth

    def _begin(self, cut: Fraction, closed: bool) -> None:
        self.low, is_open = max((self.low, not self.low_closed), (cut, not closed))
        self.low_closed = not is_open

    def _end(self, cut: Fraction, closed: bool) -> None:
        self.high, self.high_closed = min((self.high, self.high_closed), (cut, closed))


class _Probe:
    """`factor` times the number that `around` is about, plus `constant`."""

    around: Surroundings
    factor: int
    constant: Fraction

    def _form(self, other: Any) -> tuple[int, Fraction] | None:
        """Return another value as a factor of the same number and a constant; None if another number is in it."""
        if not isinstance(other, _Probe):
            return 0, Fraction(other)
        if other.around is self.around:
            return other.factor, other.constant
        self.around.joint = other.around.joint = True
        return None

    def _compared(self, test: Callable[[Any, Any], bool], other: Any) -> bool:
        if not isinstance(other, int | float):
            return test is operator.ne
        form = self._form(other)
        if form is None:
            return test(_value(self), _value(other))
        factor, constant = form
        return self.around.compare(test, self.factor - factor, self.constant - constant)

    def _combined(self, mine: int, other: Any, others: int) -> Any:
        """Return a sum of both with these factors."""
        form = self._form(other)
        if form is None:
            return int(mine * _value(self) + others * _value(other))
        return self._so(mine * self.factor + others * form[0], mine * self.constant + others * form[1])

    def _so(self, factor: int, constant: Fraction) -> "_Probe":
        value = factor * Fraction(self.around.sample) + constant
        made = IntProbe(value) if isinstance(self, int) else RealProbe(value)
        made.around, made.factor, made.constant = self.around, factor, constant
        return made

    def __lt__(self, other: Any) -> bool:
        return self._compared(operator.lt, other)

    def __le__(self, other: Any) -> bool:
        return self._compared(operator.le, other)

    def __gt__(self, other: Any) -> bool:
        return self._compared(operator.gt, other)

    def __ge__(self, other: Any) -> bool:
        return self._compared(operator.ge, other)

    def __eq__(self, other: object) -> bool:
        return self._compared(operator.eq, other)

    def __ne__(self, other: object) -> bool:
        return self._compared(operator.ne, other)

    def __hash__(self) -> int:
        return hash(_value(self))

    def __add__(self, other: Any) -> Any:
        return self._combined(1, other, 1)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        return self._combined(1, other, -1)

    def __rsub__(self, other: Any) -> Any:
        return self._combined(-1, other, 1)

    def __mul__(self, other: Any) -> Any:
        return self._so(self.factor * other, self.constant * other)

    __rmul__ = __mul__


def _value(number: Any) -> Fraction:
    """Return the value of a number, which may be a probe, whose own comparisons are noted."""
    if isinstance(number, _Probe):
        return number.factor * Fraction(number.around.sample) + number.constant
    return Fraction(number)


class IntProbe(_Probe, int):
    """An int that notes what it is compared with."""


class RealProbe(_Probe, float):
    """A real that notes what it is compared with."""
