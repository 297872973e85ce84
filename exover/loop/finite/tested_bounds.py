"""What the tests of the tables tell apart: the bounds of each entry, and values that stand for what lies between."""

import math
from bisect import bisect_left
from dataclasses import field
from itertools import pairwise

from exover.dataclass import dataclass
from exover.loop.tracked_predicates import TrackedConstants
from exover.model.types import plain
from exover.ocrd.tables import Tables

MOST_VALUES = 1024
"""An integer that is part of a sum is followed value by value up to so many values."""


class TooLarge(Exception):
    """The loop has more to tell apart than decision diagrams are meant for; the text says what."""


@dataclass(frozen=True)
class TestedBounds:
    """By entry the bounds that some test compares it with; and the sums."""

    tables: Tables
    of: dict[int, list[int]] = field(default_factory=dict)
    sums: dict[int, list[tuple[int, int]]] = field(default_factory=dict)
    """By sum its parts with their factors."""

    def __post_init__(self) -> None:
        for part, row in enumerate(self.tables.entries):
            for total, factor in self.tables.sums[row.sums : row.sums_end]:
                self.sums.setdefault(total, []).append((part, factor))
        for node in self.tables.nodes:
            if node.code >= 0:
                self.of.setdefault(node.code, []).append(node.bound)
        for entry, bounds in self.of.items():
            self.of[entry] = sorted(set(bounds))

    def exact(self, entry: int) -> bool:
        """Return whether the very value of an entry matters, as a part of a sum."""
        row = self.tables.entries[entry]
        return row.sums < row.sums_end

    def samples(self, name: str, entries: list[int], low: int, high: int, tracked: TrackedConstants) -> list[int]:
        """Return values of `low .. high`, one for each way in which tests of the entries and conditions turn out.

        `name`: what has these values, for messages.
        """
        if tracked.exact or any(self.exact(entry) for entry in entries):
            if high - low >= MOST_VALUES:
                raise TooLarge(
                    f"a sum reads `{name}`, which has {high - low + 1} values; {MOST_VALUES} at most are followed"
                )
            return list(range(low, high + 1))
        bounds = tracked.cuts | {bound for entry in entries for bound in self.of.get(entry, ())}
        return [low, *sorted(bound + 1 for bound in bounds if low <= bound < high)]

    def sign(self, entry: int, value: int) -> int:
        """Return what tells the values of an entry apart: itself, or the number of bounds below it."""
        return value if self.exact(entry) else bisect_left(self.of.get(entry, []), value)


def points(low: float, high: float, constants: tuple[float, ...], each: int) -> list[float]:
    """Return the constants within `low .. high`, and `each` doubles of every open interval that they leave."""
    inside = sorted({c for c in constants if low <= c <= high})
    found = set(inside) | {edge for edge in (low, high) if math.isfinite(edge)}
    for left, right in pairwise([low, *inside, high]):
        found.update(spread(left, right, each))
    return sorted(found)


def spread(low: float, high: float, number: int) -> list[float]:
    """Return up to so many increasing doubles strictly between two, with few digits."""
    found: list[float] = []
    middle = plain(low, high)
    if middle is not None and number > 0:
        found += spread(low, middle, (number - 1) // 2)
        found.append(middle)
        found += spread(middle, high, number - 1 - (number - 1) // 2)
    return found
