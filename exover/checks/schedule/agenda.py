"""Which question is asked next, and how long it may take, so that a slow one does not starve those after it."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import field
from heapq import heapify, heappop, heappush
from math import inf

from exover.dataclass import dataclass

SHARE = 0.25
"""The part of the time that the first round may lose to questions that are too slow for it."""
LEAST, MOST = 0.25, 1.0
"""Seconds of a slice in the first round; a process needs about half of `LEAST` to begin."""
LONGEST = 30.0
"""Seconds of the first stretch of those who are asked together, at most."""
GROWTH = 4
"""How many times as long as in the round before a slice is."""


@dataclass(frozen=True, slots=True)
class Lot:
    """Questions by number that are alike: those of one check to one engine, say.

    `rank`: the lower, the sooner they are asked. `together`: one process is asked them all at once.
    """

    numbers: Collection[int]
    rank: int = 0
    together: bool = False


@dataclass(frozen=True, slots=True)
class Turn:
    """What a process is asked at once: questions by number, in order; `together`: those of a lot that is so.

    It may take `seconds` for each answer, and `most` for all.
    """

    numbers: tuple[int, ...]
    seconds: float = inf
    most: float = inf
    together: bool = False


@dataclass
class _Queue:
    """What is to be asked of a lot, by how many turns it has had; `held`: what others are asked before."""

    lot: Lot
    place: int
    held: set[int]
    ready: list[tuple[int, int]]
    closed: bool = False
    """Something of it was too slow in this round."""

    def tidy(self, over: Collection[int]) -> bool:
        """Leave out what need not be asked any more; return whether there is something to ask."""
        while self.ready and self.ready[0][1] in over:
            heappop(self.ready)
        return bool(self.ready) and not (self.lot.together and self.held)

    @property
    def key(self) -> tuple[int, int, int]:
        """The lower, the sooner it is asked."""
        return self.ready[0][0], self.lot.rank, self.place


@dataclass
class Agenda:
    """Questions in rounds, if time is limited: each gets a small slice before any gets a second, larger one.

    In a round those come first that have had fewer turns, then those of a lower rank, then the lots in order. A
    question that is too slow is put off to the next round together with those of its lot that are still to come, so
    that each lot can lose one slice in a round only, and cheap lots are answered however slow the others are. In the
    next round slices are `GROWTH` times as long, and what was never asked comes before what was. Without `seconds`
    there is one round without end.

    What is asked together knows no rounds: it takes turns with all the others, one after each stretch of time in which
    they had as much as it has had, and `GROWTH` times as long as its last. Its first is `SHARE` of the time, for it is
    asked all: others that began sooner would do again what is all but done. So where one process does all, it gets half
    of the time; where there are more it keeps one (`exover.checks.schedule.workers`), and seldom comes back here.

    `instead`: by number of a question another that is asked for the same answer, once the first is put off or was
    asked in vain. When either has its answer, neither is asked any more.
    """

    lots: Sequence[Lot]
    seconds: float | None = None
    instead: Mapping[int, int] = field(default_factory=dict)
    over: set[int] = field(init=False, default_factory=set)
    """What need not be asked, or not any longer."""

    def __post_init__(self) -> None:
        held = set(self.instead.values())
        self._before = {later: sooner for sooner, later in self.instead.items()}
        self._queues: list[_Queue] = []
        self._of: dict[int, _Queue] = {}
        for place, lot in enumerate(self.lots):
            ready = [(0, number) for number in lot.numbers if number not in held]
            heapify(ready)
            queue = _Queue(lot, place, held.intersection(lot.numbers), ready)
            self._queues.append(queue)
            self._of.update(dict.fromkeys(lot.numbers, queue))
        self._turns = dict.fromkeys(self._of, 0)
        self._spent = {True: 0.0, False: 0.0}
        """Seconds that those have had who are asked together, and the others."""
        self._last: tuple[bool, float] | None = None
        """Whether the last turn was of those who are asked together, and the seconds that were left then."""
        self._slice = self._stretch = inf
        if self.seconds is not None:
            share = self.seconds * SHARE
            self._slice = min(max(share / max(len(self.lots), 1), LEAST), MOST)
            self._stretch = min(max(share, LEAST), LONGEST)

    @property
    def numbers(self) -> Collection[int]:
        """All questions."""
        return self._of.keys()

    @property
    def waits(self) -> bool:
        """Whether some question waits for its turn, in this round or the next."""
        return any(queue.tidy(self.over) for queue in self._queues)

    def next(self, left: float) -> Turn | None:
        """Return what is asked next, if `left` seconds are left; None if there is nothing now."""
        ready = [queue for queue in self._queues if queue.tidy(self.over)]
        if not ready:
            return None
        together = [queue for queue in ready if queue.lot.together]
        others = [queue for queue in ready if not queue.lot.together]
        self._note(left)
        if together and (not others or self._spent[True] <= self._spent[False]):
            turn = self._all_of(min(together, key=lambda queue: queue.key), left)
        else:
            turn = self._one_of(others, left)
        self._last = turn.together, left
        return turn

    def _note(self, left: float) -> None:
        """Note who has had the time since the last turn began."""
        if self.seconds is not None and self._last is not None:
            who, before = self._last
            self._spent[who] += before - left

    def _all_of(self, queue: _Queue, left: float) -> Turn:
        """Return the turn of questions that are asked together: half of the time is theirs, longer slices each time."""
        seconds = min(left, self._stretch * GROWTH ** queue.ready[0][0], max(left / 2, self._stretch))
        numbers = tuple(sorted(number for _, number in queue.ready if number not in self.over))
        queue.ready.clear()
        return Turn(numbers, seconds, max(left / 2, seconds), together=True)

    def _one_of(self, ready: Sequence[_Queue], left: float) -> Turn:
        """Return the turn of one question of this round, or of the next one if all lots have been too slow in this."""
        if all(queue.closed for queue in ready):
            self._slice *= GROWTH
            for queue in self._queues:
                queue.closed = False
        queue = min((queue for queue in ready if not queue.closed), key=lambda queue: queue.key)
        seconds = min(left, self._slice)
        return Turn((heappop(queue.ready)[1],), seconds, seconds)

    def call(self, numbers: Collection[int]) -> None:
        """Let the questions take their turns that are asked instead of these."""
        for number in numbers:
            later = self.instead.get(number)
            if later is not None and later in self._of[later].held:
                self._of[later].held.remove(later)
                heappush(self._of[later].ready, (0, later))

    def late(self, numbers: Collection[int]) -> None:
        """Put off questions that took longer than they may."""
        self.call(numbers)
        for number in numbers:
            if number not in self.over:
                self._turns[number] += 1
                self._of[number].closed = True
                heappush(self._of[number].ready, (self._turns[number], number))

    def again(self, numbers: Collection[int]) -> None:
        """Let questions take their turn once more: it was not for them that they have no answer."""
        for number in numbers:
            if number not in self.over:
                heappush(self._of[number].ready, (self._turns[number], number))

    def answered(self, number: int, in_vain: bool) -> tuple[int, ...]:
        """Note that a question was answered; return all that are over with it, itself among them."""
        if number in self.over:
            return ()
        if in_vain:
            self.call((number,))
            found: tuple[int, ...] = (number,)
        else:
            found = tuple(self._alike(number))
        self.over.update(found)
        for each in found:
            self._of[each].held.discard(each)
        return found

    def _alike(self, number: int) -> Iterator[int]:
        """Yield the questions that are asked for the same answer."""
        while number in self._before:
            number = self._before[number]
        yield number
        while number in self.instead:
            number = self.instead[number]
            yield number
