"""Lassos from which no step can be dropped, nor two related ones, tried on the reference interpreter.

Diagrams and solvers close a loop by the way that suits them. What is left of a lasso shows the same if the claim is
false of it too: what a formula says of a run that repeats itself is known from its moments. Where nothing need
happen any more, nothing does: a poster is observed to read what it reads already.
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import chain, combinations

from exover.dataclass import dataclass
from exover.loop.claim import Claim
from exover.loop.formula_classes import lingering_of, path_of
from exover.model.event import Event, Observe
from exover.model.property import (
    Formula,
    Negation,
    Properties,
    SomeAlways,
    SomeNext,
    SomeUntil,
    parts_of,
)
from exover.model.run_moments import moments_of
from exover.model.semantics import Reference
from exover.model.trace import Trace, end_of, run

LONGEST, PAIRED = 64, 12
"""Of lassos of up to so many steps single ones are tried to be dropped, and any two."""
OBSERVED = 2
"""So many posters are tried to be observed where nothing need happen."""


@dataclass(frozen=True, slots=True)
class _Lasso:
    """Events, of which those of the loop come again and again."""

    stem: tuple[Event, ...]
    loop: tuple[Event, ...]

    def __len__(self) -> int:
        return len(self.stem) + len(self.loop)

    def without(self, dropped: Sequence[int]) -> "_Lasso":
        """Return the lasso without these steps."""
        turn = len(self.stem)
        kept = [(n, event) for n, event in enumerate((*self.stem, *self.loop)) if n not in dropped]
        return _Lasso(tuple(e for n, e in kept if n < turn), tuple(e for n, e in kept if n >= turn))


def shortened(trace: Trace, reference: Reference, claim: Claim, properties: Properties) -> Trace:
    """Return a lasso made of steps of the given one of which a claim is false too, as far as it is one run that shows
    it; else the given run.

    The last step may be an observation of what is read already, again and again.
    """
    start, formula = trace.loop_start, claim.formula
    if start is None or formula is None or len(trace.moments) > LONGEST:
        return trace
    if not claim.linear and not _is_of_one_run(formula, positive=False):
        return trace
    shows = _Shows(reference, Negation(formula), claim.fair, properties)
    best = given = _Lasso(trace.events[:start], trace.events[start:])
    if not shows(given):
        return trace
    while (found := _without_needless(best, shows)) != best:
        best = found
    return trace if best == given else run(reference, best.stem + best.loop, len(best.stem))


def guesses(claim: Claim) -> bool:
    """Return whether a monitor of lassos of which a claim is false has to guess what comes: they do not all end in a
    state in which one condition stays true.
    """
    path = None if claim.formula is None or claim.linear else path_of(claim.formula, positive=False)
    return path is None or lingering_of(path.formula) is None


def _without_needless(lasso: _Lasso, shows: "_Shows") -> _Lasso:
    """Return a lasso that rests where it can, without single steps, then without several at a time."""
    lasso = next(filter(shows, _resting(shows.reference, lasso)), lasso)
    lasso = _dropped(lasso, shows, lambda lasso: ((n,) for n in reversed(range(len(lasso)))))
    return _dropped(lasso, shows, _related)


def _related(lasso: _Lasso) -> Iterator[tuple[int, ...]]:
    """Yield the steps that speak of the same, together and each two of them, of a short lasso any two; then each step.

    What one such step does another often undoes: only without both is the claim false of what is left.
    """
    about: dict[str, list[int]] = {}
    for number, event in enumerate((*lasso.stem, *lasso.loop)):
        about.setdefault(event.name if isinstance(event, Observe) else event.request, []).append(number)
    yield from (tuple(numbers) for numbers in about.values() if len(numbers) > 2)
    pairable = [list(range(len(lasso)))] if len(lasso) <= PAIRED else list(about.values())
    yield from chain.from_iterable(combinations(numbers, 2) for numbers in pairable)
    yield from ((number,) for number in range(len(lasso)))


def _dropped(lasso: _Lasso, shows: "_Shows", drops: Callable[[_Lasso], Iterator[tuple[int, ...]]]) -> _Lasso:
    """Return a lasso from which none of these steps can be dropped."""
    found: _Lasso | None = lasso
    while found is not None:
        lasso = found
        left = (_reread(shows.reference, lasso.without(each)) for each in drops(lasso))
        found = next(filter(shows, left), None)
    return lasso


def _reread(reference: Reference, lasso: _Lasso) -> _Lasso:
    """Return the lasso; if its loop is one observation of a poster, of what that reads by then."""
    match lasso.loop:
        case (Observe(name, value, False),):
            read = end_of(reference, lasso.stem).readings.get(name, value)
            return _Lasso(lasso.stem, (Observe(name, read),))
        case _:
            return lasso


def _resting(reference: Reference, lasso: _Lasso) -> Iterator[_Lasso]:
    """Yield lassos that are not longer and follow the given one up to where a poster is observed, for ever."""
    events = (*lasso.stem, *lasso.loop)
    if len(lasso.loop) == 1 and isinstance(lasso.loop[0], Observe):
        events = lasso.stem
    posters = [each.name for each in reference.model.variables if each.kind == "poster"][:OBSERVED]
    state = reference.start()
    for count, event in enumerate(events):
        for name in posters:
            yield _Lasso(events[:count], (Observe(name, state.readings[name]),))
        state, _ = reference.step(state, event)


def _is_of_one_run(formula: Formula, positive: bool) -> bool:
    """Return whether one run shows that a formula of CTL, or its negation, is true: it says that some run exists."""
    match formula:
        case Negation(part):
            return _is_of_one_run(part, not positive)
        case SomeNext() | SomeUntil() | SomeAlways() if not positive:
            return False
        case _:
            return all(_is_of_one_run(part, positive) for part in parts_of(formula))


@dataclass(frozen=True, slots=True)
class _Shows:
    """Whether a lasso is a run that the assumptions leave, fair if it is to be, and a formula is true of it."""

    reference: Reference
    formula: Formula
    fair: bool
    properties: Properties

    def __call__(self, lasso: _Lasso) -> bool:
        """Return whether it is known to be so."""
        word = moments_of(self.reference, lasso.stem, lasso.loop)
        if word is None or (self.fair and not word.is_fair()):
            return False
        later = range(1, len(word.states))
        assumed = (word.where(each.formula).issuperset(later) for each in self.properties.assumptions)
        return all(assumed) and 0 in word.where(self.formula)
