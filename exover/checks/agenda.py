"""Which question is asked next, and how long it may take, so that a slow one does not starve those after it."""

from collections import deque
from collections.abc import Mapping, Sequence
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

    `instead`: by number of a question another that is asked for the same answer, once the first is put off or was
    asked in vain; it takes its turns as if it stood last. When either has its answer, neither is asked any more.
    """

    checks: Sequence[str]
    seconds: float | None = None
    instead: Mapping[int, int] = field(default_factory=dict)
    over: set[int] = field(init=False, default_factory=set)
    """What need not be asked, or not any longer."""
    _first: deque[int] = field(init=False)
    _second: dict[str, list[tuple[bool, int]]] = field(init=False, default_factory=dict)
    _final: set[int] = field(init=False, default_factory=set)
    _waiting: dict[int, int] = field(init=False)

    def __post_init__(self) -> None:
        self._waiting = dict(self.instead)
        held = set(self.instead.values())
        self._first = deque(number for number in range(len(self.checks)) if number not in held)
        self._checks = {self.checks[number] for number in self._first}
        self._twins = {**self.instead, **{second: first for first, second in self.instead.items()}}

    def next(self, left: float) -> tuple[int, float] | None:
        """Return the next question and the seconds that it may take, of `left` seconds; None if there is none now."""
        while self._first:
            number = self._first.popleft()
            if number in self.over:
                continue
            check = self.checks[number]
            if check not in self._second:
                return number, min(left, self._part)
            self._put_off(number, asked=False)
        for queue in self._second.values():
            while queue:
                _, number = heappop(queue)
                if number not in self.over:
                    self._final.add(number)
                    return number, left / 2 if self._more() else left
        return None

    def late(self, number: int) -> None:
        """Note that a question took longer than it may."""
        check = self.checks[number]
        self._second[check] = self._second.pop(check, [])  # the others come first now
        if number not in self._final:
            self._put_off(number, asked=True)

    def answered(self, number: int, in_vain: bool) -> None:
        """Note that a question was answered."""
        self.over.add(number)
        if in_vain:
            self._call(number)
        elif number in self._twins:
            self.over.add(self._twins[number])

    def _put_off(self, number: int, asked: bool) -> None:
        heappush(self._second[self.checks[number]], (asked, number))
        self._call(number)

    def _call(self, number: int) -> None:
        """Let the question take its turn that is asked instead of another, unless it has done so already."""
        if number in self._waiting:
            self._first.append(self._waiting.pop(number))

    def _more(self) -> bool:
        return any(each[1] not in self.over for queue in self._second.values() for each in queue)

    @property
    def _part(self) -> float:
        if self.seconds is None:
            return inf
        return max(self.seconds * SHARE / len(self._checks), LEAST)
