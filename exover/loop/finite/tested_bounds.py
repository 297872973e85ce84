"""The bounds that tests compare each entry with, and representatives of the intervals between them."""

import math
from bisect import bisect_left
from dataclasses import field
from functools import cached_property
from itertools import pairwise

from exover.dataclass import dataclass
from exover.loop.tracked_predicates import TrackedConstants
from exover.model.types import plain
from exover.ocrd.tables import Tables

MOST_VALUES = 1024
"""The greatest number of values of an integer that is part of a sum."""


class TooLarge(Exception):
    """The finite loop would be too large for decision diagrams; the message says why."""


@dataclass(frozen=True)
class TestedBounds:
    """The sorted bounds that tests compare each entry with, and the parts of each sum."""

    tables: Tables
    of: dict[int, list[int]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for node in self.tables.nodes:
            if node.code >= 0:
                self.of.setdefault(node.code, []).append(node.bound)
        for entry, bounds in self.of.items():
            self.of[entry] = sorted(set(bounds))

    @cached_property
    def sums(self) -> dict[int, list[tuple[int, int]]]:
        """The parts of each sum with their factors."""
        return self.tables.parts()

    def exact(self, entry: int) -> bool:
        """Return whether the exact value of an entry matters because it is part of a sum."""
        row = self.tables.entries[entry]
        return row.sums < row.sums_end

    def samples(self, name: str, entries: list[int], low: int, high: int, tracked: TrackedConstants) -> list[int]:
        """Return values of `low .. high`, one for each combination of outcomes of tests of the entries and conditions.

        `name`: whose values they are, for messages. Raises `TooLarge` if exact values matter and there are too many.
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
        """Return the signature of an entry's value: the value if it is `exact`, else the number of bounds below it."""
        return value if self.exact(entry) else bisect_left(self.of.get(entry, []), value)


def points(low: float, high: float, constants: tuple[float, ...], each: int) -> list[float]:
    """Return the constants within `low .. high`, its finite ends, and up to `each` doubles between neighbours."""
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
