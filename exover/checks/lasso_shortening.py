"""Lassos from which no step can be dropped, nor two related ones, tried on the reference interpreter.

Diagrams and solvers close a loop by the way that suits them. What is left of a lasso shows the same if the claim is
false of it too: what a formula says of a run that repeats itself is known from its moments. Where nothing need
happen any more, nothing does: a poster is observed to read what it reads already.
"""

from collections.abc import Callable, Iterable, Iterator
from functools import cache

from exover.dataclass import dataclass
from exover.loop.claim import Claim
from exover.loop.formula_classes import lingering_of, path_of
from exover.model.event import Event, Invalid, Observe
from exover.model.lasso import Lasso, rearranged, related
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
from exover.model.state import State
from exover.model.trace import Trace, end_of, run

LONGEST, PAIRED = 64, 12
"""Of lassos of up to so many steps single ones are tried to be dropped; any two, and any to take another's place."""
OBSERVED = 2
"""So many posters are tried to be observed where nothing need happen."""
_Lasso = Lasso[Event]


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
    """Return a lasso that rests where it can, without single steps, then without several at a time, and rearranged."""
    lasso = next(filter(shows, _resting(shows.reference, lasso)), lasso)
    lasso = _shorter(lasso, shows, lambda given: (given.without({n}) for n in reversed(range(given.length))))
    lasso = _shorter(lasso, shows, lambda given: map(given.without, related(given, _subject, PAIRED)))
    return _shorter(lasso, shows, lambda given: _rearranged(shows.reference, given) if given.length <= PAIRED else ())


def _subject(event: Event) -> str:
    """Return of which request or poster an event speaks."""
    return event.name if isinstance(event, Observe) else event.request


def _shorter(lasso: _Lasso, shows: "_Shows", tried: Callable[[_Lasso], Iterable[_Lasso]]) -> _Lasso:
    """Return a lasso of which none that is tried shows as much."""
    found: _Lasso | None = lasso
    while found is not None:
        lasso = found
        found = next(filter(shows, (_reread(shows.reference, each) for each in tried(lasso))), None)
    return lasso


def _rearranged(reference: Reference, lasso: _Lasso) -> Iterator[_Lasso]:
    """Yield shorter lassos of the same steps, without those that are impossible there, as reports of what is idle."""

    @cache
    def after(events: tuple[Event, ...]) -> tuple[State, bool]:
        """Return the state to which events lead, and whether the last of them is impossible."""
        if not events:
            return reference.start(), False
        state, actions = reference.step(after(events[:-1])[0], events[-1])
        return state, any(isinstance(action, Invalid) for action in actions)

    for each in rearranged(lasso, _subject):
        steps = each.steps
        if after(steps)[0].key() == after(each.stem)[0].key():
            yield each.without([number for number in range(len(steps)) if after(steps[: number + 1])[1]])


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
    events = lasso.steps
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
