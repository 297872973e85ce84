"""Types of parameters, results, posters and states, and the values that belong to them (docs/language.md section 2)."""

import math
from sys import float_info
from typing import assert_never

from exover.dataclass import dataclass

Value = bool | int | float | str
"""A value: `bool`, `int`, a finite `float` for a real, or the name of an enum value."""


@dataclass(frozen=True, slots=True)
class Bool:
    """The two truth values."""


@dataclass(frozen=True, slots=True)
class Int:
    """The integers of the closed range `low .. high`."""

    low: int
    high: int


@dataclass(frozen=True, slots=True)
class Real:
    """The finite doubles of the closed range `low .. high`; without bounds, all of them."""

    low: float = -math.inf
    high: float = math.inf


@dataclass(frozen=True, slots=True)
class Enum:
    """The listed names; two enums are one type iff they list the same names in the same order."""

    values: tuple[str, ...]


Type = Bool | Int | Real | Enum


def contains(kind: Type, value: Value) -> bool:
    """Return whether `value`, already of the Python type that stands for `kind`, lies in its domain."""
    match kind:
        case Real(low, high):
            return isinstance(value, float) and math.isfinite(value) and low <= value <= high
        case Bool():
            return isinstance(value, bool)
        case Int(low, high):
            return isinstance(value, int) and low <= value <= high
        case Enum(values):
            return value in values
        case _:
            assert_never(kind)


def least(kind: Type) -> Value:
    """Return the first value of a domain; of a real without a lower bound, `min(0, high)`."""
    match kind:
        case Real(low, high):
            return low if math.isfinite(low) else min(0.0, high)
        case Bool():
            return False
        case Int(low, _):
            return low
        case Enum(values):
            return values[0]
        case _:
            assert_never(kind)


def resting_value(kind: Type) -> Value:
    """Return the value of a domain that stands for no value: of a real the one nearest to 0, else the first one."""
    return min(max(kind.low, 0.0), kind.high) if isinstance(kind, Real) else least(kind)


def finite_ends(kind: Real) -> tuple[float, float]:
    """Return the least and the greatest double of a domain."""
    return max(kind.low, -float_info.max), min(kind.high, float_info.max)


def ordinal(kind: Type, value: Value) -> int:
    """Return the integer that encodes a value of a bool, int or enum; raises `TypeError` for a real."""
    match kind:
        case Bool() | Int():
            return int(value)
        case Enum(values):
            return values.index(str(value))
        case Real():
            raise TypeError("a real has no ordinal of its own")
        case _:
            assert_never(kind)


def from_ordinal(kind: Type, number: int) -> Value:
    """Return the value of a bool, int or enum that `number` encodes: the inverse of `ordinal`."""
    match kind:
        case Bool():
            return bool(number)
        case Int():
            return number
        case Enum(values):
            return values[number]
        case Real():
            raise TypeError("a real has no ordinal of its own")
        case _:
            assert_never(kind)


def plain(low: float, high: float) -> float | None:
    """Return a double strictly between two, preferably one with few digits; None iff there is none.

    It is looked for around the middle. An infinite `low` counts as `min(high, 0) - 2`, `high` as `max(low, 0) + 2`.
    """
    start = low if math.isfinite(low) else min(high, 0.0) - 2
    end = high if math.isfinite(high) else max(low, 0.0) + 2
    middle = start / 2 + end / 2
    for digits in range(-3, 12):
        short = round(middle, digits) + 0.0  # no -0.0
        if low < short < high:
            return short
    next_one = math.nextafter(high, low) if math.isinf(low) else math.nextafter(low, high)
    found = middle if low < middle < high else next_one  # 2 is nothing beside a huge end
    return found if low < found < high else None
