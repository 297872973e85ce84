"""Which question is asked next, and how long it may take, so that a slow one does not starve those after it."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from heapq import heappop, heappush
from math import inf

SHARE = 0.25
"""The part of the time that the first round may lose to questions that are too slow for it."""
LEAST = 0.25
"""Seconds that every question gets: a process needs about half of that to begin."""


@dataclass
class Agenda:
    """Questions by number, asked in two rounds if time is limited; `checks`: the check of each.

    First round: all in order, none longer than an equal part of `SHARE` for each check. One that is too slow is put off
    together with those of its check that are still to come, so that each check can lose its part only once, and cheap
    checks are answered however slow the others are. Second round: what was put off, check by check, those that were too
    slow last in theirs; each gets half of the time that is left, the last one all of it, and where that is not enough,
    its check comes after the others.
    """

    checks: Sequence[str]
    seconds: float | None = None
    _first: deque[int] = field(init=False)
    _second: dict[str, list[tuple[bool, int]]] = field(init=False, default_factory=dict)
    _final: set[int] = field(init=False, default_factory=set)

    def __post_init__(self) -> None:
        self._first = deque(range(len(self.checks)))

    def next(self, left: float) -> tuple[int, float] | None:
        """Return the next question and the seconds that it may take, of `left` seconds; None if there is none now."""
        while self._first:
            number = self._first.popleft()
            check = self.checks[number]
            if check not in self._second:
                return number, min(left, self._part)
            heappush(self._second[check], (False, number))
        queue = next(filter(None, self._second.values()), None)
        if queue is None:
            return None
        _, number = heappop(queue)
        self._final.add(number)
        return number, left / 2 if any(self._second.values()) else left

    def late(self, number: int) -> None:
        """Note that a question took longer than it may."""
        check = self.checks[number]
        queue = self._second[check] = self._second.pop(check, [])  # the others come first now
        if number not in self._final:
            heappush(queue, (True, number))

    @property
    def _part(self) -> float:
        if self.seconds is None:
            return inf
        return max(self.seconds * SHARE / len(set(self.checks)), LEAST)
