"""Runs that repeat themselves, of steps of any kind, and the shorter ones that their steps may make."""

from collections.abc import Callable, Collection, Hashable, Iterator
from itertools import chain, combinations
from typing import Generic, TypeVar

from exover.dataclass import dataclass

Step = TypeVar("Step", bound=Hashable)
StepNumbers = frozenset[int]
"""Steps of a run by number, in a lasso those of the loop after those of the stem."""


@dataclass(frozen=True, slots=True)
class Lasso(Generic[Step]):
    """A run: these steps once, and those of the loop for ever."""

    stem: tuple[Step, ...]
    loop: tuple[Step, ...]

    @property
    def steps(self) -> tuple[Step, ...]:
        """Those of both."""
        return (*self.stem, *self.loop)

    @property
    def length(self) -> int:
        """How many steps both have."""
        return len(self.stem) + len(self.loop)

    def without(self, dropped: Collection[int]) -> "Lasso[Step]":
        """Return the lasso without these steps."""
        turn = len(self.stem)
        kept = [(number, step) for number, step in enumerate(self.steps) if number not in dropped]
        return Lasso(tuple(s for n, s in kept if n < turn), tuple(s for n, s in kept if n >= turn))


def related(lasso: Lasso[Step], subject: Callable[[Step], Hashable], paired: int) -> list[StepNumbers]:
    """Return the steps that speak of the same, together and each two of them; of lassos of up to `paired` steps any
    two; and each step.

    What one such step does another often undoes: only without both is there a lasso.
    """
    about: dict[Hashable, list[int]] = {}
    for number, step in enumerate(lasso.steps):
        about.setdefault(subject(step), []).append(number)
    turn, length = len(lasso.stem), lasso.length
    together = [
        frozenset(number for number in numbers if first <= number < end)
        for numbers in about.values()
        for first, end in ((0, length), (0, turn), (turn, length))
    ]
    pairs = combinations(range(length), 2) if length <= paired else chain(*(combinations(n, 2) for n in about.values()))
    each = (frozenset({number}) for number in range(length))
    return list(dict.fromkeys([*filter(None, together), *map(frozenset, pairs), *each]))


def moves(steps: tuple[Step, ...]) -> Iterator[tuple[int, int, tuple[Step, ...]]]:
    """Yield the number of a step, that of one whose place it may have, and the steps with it there, not where it was.

    An observation before an ask, say, makes another step needless that kept the request waiting until then.
    """
    for place, replaced in enumerate(steps):
        for number, step in enumerate(steps):
            if step != replaced:
                moved = (*steps[:place], step, *steps[place + 1 :])
                yield number, place, (*moved[:number], *moved[number + 1 :])


def rearranged(lasso: Lasso[Step], subject: Callable[[Step], Hashable]) -> list[Lasso[Step]]:
    """Return shorter lassos in which a step has the place of another, or whose loop begins earlier.

    No step of the stem comes into the loop: what has happened need not happen for ever.
    """
    turn = len(lasso.stem)
    moved = [
        Lasso(steps[: turn - (number < turn)], steps[turn - (number < turn) :])
        for number, place, steps in moves(lasso.steps)
        if number >= turn or place < turn
    ]
    return [each for each in dict.fromkeys((*moved, *_begun_earlier(lasso, subject))) if each.loop]


def _begun_earlier(lasso: Lasso[Step], subject: Callable[[Step], Hashable]) -> Iterator[Lasso[Step]]:
    """Yield lassos whose loop begins earlier, with any of its steps; a step of the stem may be made one of the loop's.

    Where a report of the stem has another outcome than in the loop, say, that alone often makes the loop begin late.
    """
    stem, loop = lasso.stem, lasso.loop
    loops = [loop[turn:] + loop[:turn] for turn in range(len(loop))]
    stems = [(0, stem)]
    for number, step in enumerate(stem):
        like = (each for each in dict.fromkeys(loop) if each != step and subject(each) == subject(step))
        stems += [(number + 1, (*stem[:number], each, *stem[number + 1 :])) for each in like]
    for first, changed in stems:
        for end in range(first, len(stem)):
            yield from (Lasso(changed[:end], each) for each in loops)
