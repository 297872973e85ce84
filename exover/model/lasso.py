"""Lassos over steps of any kind, and candidates for shorter lassos made of the same steps."""

from collections.abc import Callable, Collection, Hashable, Iterable, Iterator
from itertools import chain, combinations
from typing import Generic, TypeVar

from exover.dataclass import dataclass

Step = TypeVar("Step", bound=Hashable)
StepNumbers = frozenset[int]
"""A set of steps of a run by number; in a lasso the numbers of the loop follow those of the stem."""


@dataclass(frozen=True, slots=True)
class Lasso(Generic[Step]):
    """A run: the steps of the stem once, then those of the loop for ever."""

    stem: tuple[Step, ...]
    loop: tuple[Step, ...]

    @property
    def steps(self) -> tuple[Step, ...]:
        """The steps of the stem, then those of the loop."""
        return (*self.stem, *self.loop)

    @property
    def length(self) -> int:
        """The number of steps of stem and loop together."""
        return len(self.stem) + len(self.loop)

    def without(self, dropped: Collection[int]) -> "Lasso[Step]":
        """Return the lasso without the steps of these numbers."""
        turn = len(self.stem)
        kept = [(number, step) for number, step in enumerate(self.steps) if number not in dropped]
        return Lasso(tuple(s for n, s in kept if n < turn), tuple(s for n, s in kept if n >= turn))


def related(lasso: Lasso[Step], subject: Callable[[Step], Hashable], paired: int) -> list[StepNumbers]:
    """Return sets of steps that may be dropped together, without duplicates: first all steps of one subject (in the
    whole lasso, in the stem, in the loop), then from one step to another of its subject all steps, or all of the
    subject, or the two, then single steps.

    Any two steps are a pair if the lasso has at most `paired` steps. Two steps of one subject often undo each other,
    and then only dropping both leaves a lasso.
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
    for numbers in about.values():
        for first, last in combinations(range(len(numbers)), 2):
            together.append(frozenset(range(numbers[first], numbers[last] + 1)))
            together.append(frozenset(numbers[first : last + 1]))
    pairs = combinations(range(length), 2) if length <= paired else chain(*(combinations(n, 2) for n in about.values()))
    each = (frozenset({number}) for number in range(length))
    return list(dict.fromkeys([*filter(None, together), *map(frozenset, pairs), *each]))


def endings(run: tuple[Step, ...], reports: tuple[Step, ...], observed: Iterable[Step]) -> Iterator[Lasso[Step]]:
    """Yield lassos of a run, these reports or none, and a loop of one of these observations.

    For example, what follows a run that violates a property already need not do so again: once all that is active is
    reported, an observation that changes nothing may go on for ever.
    """
    for event in observed:
        yield Lasso(run, (event,))
        yield Lasso((*run, *reports), (event,))


def moves(steps: tuple[Step, ...]) -> Iterator[tuple[int, int, tuple[Step, ...]]]:
    """Yield `(i, j, steps)`: step i has replaced step j, and is gone from its own place, so there is one step less.

    For example, an observation before an ask makes a step needless that kept the request waiting until then.
    """
    for place, replaced in enumerate(steps):
        for number, step in enumerate(steps):
            if step != replaced:
                moved = (*steps[:place], step, *steps[place + 1 :])
                yield number, place, (*moved[:number], *moved[number + 1 :])


def rearranged(lasso: Lasso[Step], subject: Callable[[Step], Hashable]) -> list[Lasso[Step]]:
    """Return shorter candidates: one step has replaced another (see `moves`), or the loop begins earlier.

    No `moves` takes a step of the stem into the loop: what happened once need not happen for ever.
    """
    turn = len(lasso.stem)
    moved = [
        Lasso(steps[: turn - (number < turn)], steps[turn - (number < turn) :])
        for number, place, steps in moves(lasso.steps)
        if number >= turn or place < turn
    ]
    return [each for each in dict.fromkeys((*moved, *_begun_earlier(lasso, subject))) if each.loop]


def _begun_earlier(lasso: Lasso[Step], subject: Callable[[Step], Hashable]) -> Iterator[Lasso[Step]]:
    """Yield lassos with a shorter stem and a rotated loop; one step of the stem may become a loop step of its subject.

    For example, a report whose outcome in the stem differs from that in the loop often makes the loop begin late.
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
