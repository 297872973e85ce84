"""The order in which questions are asked, and the time slice of each, so that slow questions do not starve others."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import field
from heapq import heapify, heappop, heappush
from math import inf

from exover.dataclass import dataclass

SHARE = 0.25
"""The fraction of the time that the first round may lose to questions that exceed their slice."""
LEAST, MOST = 0.25, 1.0
"""Bounds of a slice in the first round, in seconds; a process needs about half of `LEAST` to start."""
LONGEST = 30.0
"""Upper bound of the first slice of questions that are asked together, in seconds."""
GROWTH = 4
"""The factor by which slices grow from one round to the next."""


@dataclass(frozen=True, slots=True)
class Lot:
    """Similar questions by number, for instance those of one check to one engine.

    `rank`: lots of a lower rank are asked first. `together`: one process is asked all of them at once; `in_order`: it
    answers them one after the other.
    """

    numbers: Collection[int]
    rank: int = 0
    together: bool = False
    in_order: bool = False


@dataclass(frozen=True, slots=True)
class Turn:
    """The questions that a process is asked at once, by number and in order; `together`, `in_order`: as in their lot.

    The process may take `seconds` for each answer, and `most` seconds for all.
    """

    numbers: tuple[int, ...]
    seconds: float = inf
    most: float = inf
    together: bool = False
    in_order: bool = False

    def lost(self, left: Collection[int]) -> list[int]:
        """Return which of the questions still open are lost with the process that was asked: all, if it may be any."""
        one_by_one = self.in_order or len(left) < len(self.numbers)
        return sorted(left)[:1] if one_by_one else sorted(left)


@dataclass
class _Queue:
    """The questions of a lot that wait for a turn.

    `ready`: a heap of (turns had so far, number). `held`: stand-ins (`Agenda.instead`) that are not ready yet.
    """

    lot: Lot
    place: int
    held: set[int]
    ready: list[tuple[int, int]]
    closed: bool = False
    """Whether one of its questions exceeded its slice in this round."""

    def tidy(self, over: Collection[int]) -> bool:
        """Drop questions that are `over`; return whether some are ready and, if asked together, none is held."""
        while self.ready and self.ready[0][1] in over:
            heappop(self.ready)
        return bool(self.ready) and not (self.lot.together and self.held)

    @property
    def key(self) -> tuple[int, int, int]:
        """The sort key: the queue with the least key is served first."""
        return self.ready[0][0], self.lot.rank, self.place


@dataclass
class Agenda:
    """A round-robin schedule: with limited time, each question gets a small slice before any gets a second, larger one.

    In a round, questions that have had fewer turns come first, then those of a lower rank, then the lots in order. A
    question that exceeds its slice is put off to the next round, and so are the questions of its lot that are still to
    be asked. So each lot loses at most one slice in a round, and cheap lots are answered however slow the others are.
    In the next round slices are `GROWTH` times as long. Without `seconds` there is one round, and slices are unlimited.

    Questions that are asked together take part in no rounds. They get a turn whenever they have had no more time in
    total than all other questions, and each of their slices is `GROWTH` times as long as the one before. The first is
    `SHARE` of the time: they come first since other engines would repeat most of their work. So with one process they
    get half of the time; with several they keep a process (`exover.checks.schedule.workers`) and seldom return here.

    `instead`: maps the number of a question to its stand-in, a question for the same answer that becomes ready once the
    first is put off or asked in vain. When either has its answer, neither is asked any more.
    """

    lots: Sequence[Lot]
    seconds: float | None = None
    instead: Mapping[int, int] = field(default_factory=dict)
    over: set[int] = field(init=False, default_factory=set)
    """Questions that are answered, themselves or by another; they are asked no more."""

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
        """Seconds used so far: by questions that are asked together (True), and by all others (False)."""
        self._last: tuple[bool, float] | None = None
        """Of the last turn: whether its questions were asked together, and the seconds that were left when it began."""
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
        """Whether some question is ready for a turn, in this round or the next."""
        return any(queue.tidy(self.over) for queue in self._queues)

    def next(self, left: float) -> Turn | None:
        """Return the next turn, given that `left` seconds are left; None iff no question is ready."""
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
        """Charge the time since the last turn began to the questions of that turn: asked together, or not."""
        if self.seconds is not None and self._last is not None:
            who, before = self._last
            self._spent[who] += before - left

    def _all_of(self, queue: _Queue, left: float) -> Turn:
        """Return the turn of all ready questions of a lot that is asked together.

        The slice for each answer grows with each turn, up to half of the time left; all may take that half at least.
        """
        seconds = min(left, self._stretch * GROWTH ** queue.ready[0][0], max(left / 2, self._stretch))
        numbers = tuple(sorted(number for _, number in queue.ready if number not in self.over))
        queue.ready.clear()
        return Turn(numbers, seconds, max(left / 2, seconds), together=True, in_order=queue.lot.in_order)

    def _one_of(self, ready: Sequence[_Queue], left: float) -> Turn:
        """Return the turn of one question; if every lot is closed in this round, begin the next, with longer slices."""
        if all(queue.closed for queue in ready):
            self._slice *= GROWTH
            for queue in self._queues:
                queue.closed = False
        queue = min((queue for queue in ready if not queue.closed), key=lambda queue: queue.key)
        seconds = min(left, self._slice)
        return Turn((heappop(queue.ready)[1],), seconds, seconds)

    def call(self, numbers: Collection[int]) -> None:
        """Make the stand-ins of these questions ready."""
        for number in numbers:
            later = self.instead.get(number)
            if later is not None and later in self._of[later].held:
                self._of[later].held.remove(later)
                heappush(self._of[later].ready, (0, later))

    def late(self, numbers: Collection[int]) -> None:
        """Put off questions that exceeded their slice to the next round, and make their stand-ins ready."""
        self.call(numbers)
        for number in numbers:
            if number not in self.over:
                self._turns[number] += 1
                self._of[number].closed = True
                heappush(self._of[number].ready, (self._turns[number], number))

    def again(self, numbers: Collection[int]) -> None:
        """Make questions ready again that lost their process through no fault of theirs; no turn is counted."""
        for number in numbers:
            if number not in self.over:
                heappush(self._of[number].ready, (self._turns[number], number))

    def answered(self, number: int, in_vain: bool) -> tuple[int, ...]:
        """Record an answer to a question, and return the questions that are over with it; none if it was over already.

        These are the question itself and, unless it was answered `in_vain`, all that are asked for the same answer.
        """
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
        """Yield all questions for the same answer as this one, itself included, stand-ins after what they stand for."""
        while number in self._before:
            number = self._before[number]
        yield number
        while number in self.instead:
            number = self.instead[number]
            yield number
