"""Shortening of lassos: drop single steps and pairs of related steps, each try checked on the reference interpreter.

Lassos of diagrams and solvers have needless steps. A shorter lasso shows the violation as well if the claim is false
of it, which the moments of a lasso decide. Where no event is needed any more, the lasso ends in an observation of a
poster that reads the same already.
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
"""The lengths up to which single steps are dropped, and up to which pairs are dropped and steps are moved."""
OBSERVED = 2
"""The number of posters that are tried as the observation in which a lasso ends."""
_Lasso = Lasso[Event]


def shortened(trace: Trace, reference: Reference, claim: Claim, properties: Properties) -> Trace:
    """Return a shorter lasso of steps of the given one on which the claim is false too; the given run if there is none.

    That is also so if no single run can show that the claim is false. The loop may become one observation of a poster
    that reads the same already.
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
    """Return whether a monitor of lassos that violate a claim is nondeterministic: they need not end in states in which
    one condition stays true.
    """
    path = None if claim.formula is None or claim.linear else path_of(claim.formula, positive=False)
    return path is None or lingering_of(path.formula) is None


def _without_needless(lasso: _Lasso, shows: "_Shows") -> _Lasso:
    """Return the lasso after four reductions: a stuttering loop, single steps, related steps together, moved steps."""
    lasso = next(filter(shows, _stuttering(shows.reference, lasso)), lasso)
    lasso = _shorter(lasso, shows, lambda given: (given.without({n}) for n in reversed(range(given.length))))
    lasso = _shorter(lasso, shows, lambda given: map(given.without, related(given, _subject, PAIRED)))
    return _shorter(lasso, shows, lambda given: _rearranged(shows.reference, given) if given.length <= PAIRED else ())


def _subject(event: Event) -> str:
    """Return the request or poster that an event is about."""
    return event.name if isinstance(event, Observe) else event.request


def _shorter(lasso: _Lasso, shows: "_Shows", tried: Callable[[_Lasso], Iterable[_Lasso]]) -> _Lasso:
    """Replace the lasso by the first tried one that shows the violation, until there is none; return the last."""
    found: _Lasso | None = lasso
    while found is not None:
        lasso = found
        found = next(filter(shows, (_reread(shows.reference, each) for each in tried(lasso))), None)
    return lasso


def _rearranged(reference: Reference, lasso: _Lasso) -> Iterator[_Lasso]:
    """Yield shorter lassos of the same steps moved, without those that are impossible then (reports of idle slots)."""

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
    """Return the lasso; if its loop is one observation, let it observe what the poster reads before the loop."""
    match lasso.loop:
        case (Observe(name, value, False),):
            read = end_of(reference, lasso.stem).readings.get(name, value)
            return _Lasso(lasso.stem, (Observe(name, read),))
        case _:
            return lasso


def _stuttering(reference: Reference, lasso: _Lasso) -> Iterator[_Lasso]:
    """Yield lassos that consist of a prefix of the given one and a loop that observes what a poster reads already."""
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
    """The predicate of lassos: allowed by the assumptions, fair if `fair`, and a formula is true at the start."""

    reference: Reference
    formula: Formula
    fair: bool
    properties: Properties

    def __call__(self, lasso: _Lasso) -> bool:
        """Return whether the lasso is known to satisfy the predicate."""
        word = moments_of(self.reference, lasso.stem, lasso.loop)
        if word is None or (self.fair and not word.is_fair()):
            return False
        later = range(1, len(word.states))
        assumed = (word.where(each.formula).issuperset(later) for each in self.properties.assumptions)
        return all(assumed) and 0 in word.where(self.formula)
