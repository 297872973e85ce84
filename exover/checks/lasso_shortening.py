"""Shortening of lassos: drop single steps and pairs of related steps, each try checked on the reference interpreter.

Lassos of diagrams and solvers have needless steps. A shorter lasso shows the violation as well if the claim is false
of it, which the moments of a lasso decide. Where no event is needed any more, the lasso ends in an observation of a
poster that reads the same already.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import field
from itertools import starmap

from exover.dataclass import dataclass
from exover.loop.claim import Claim, existential
from exover.loop.formula_classes import lingering_of, path_of
from exover.model.event import Event, Invalid, Observe, Report
from exover.model.lasso import Lasso, endings, rearranged, related
from exover.model.property import Formula, Negation, Properties
from exover.model.run_moments import moments_of
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import Trace, end_of, run, visited
from exover.model.types import least

LONGEST, PAIRED = 64, 12
"""The lengths up to which single steps are dropped, and up to which pairs are dropped and steps are moved."""
OBSERVED = 2
"""The number of posters and levels that are tried as the observation in which a lasso ends."""
_Lasso = Lasso[Event]


def shortened(trace: Trace, reference: Reference, claim: Claim, properties: Properties) -> Trace:
    """Return a shorter lasso of steps of the given one on which the claim is false too; the given run if there is none.

    That is also so if no single run can show that the claim is false. The loop may become one observation of a poster
    that reads the same already.
    """
    start, formula = trace.loop_start, claim.formula
    if start is None or formula is None or len(trace.moments) > LONGEST:
        return trace
    if not claim.linear and existential(formula):
        return trace
    shows = _Shows(reference, Negation(formula), claim.fair, properties)
    given = _Lasso(trace.events[:start], trace.events[start:])
    if not shows(given):
        return trace
    tree = _Tree(reference)
    best = next(filter(shows, _resting(reference, given, 2 * LONGEST)), given)
    best = _without_needless(best, shows, tree)
    if best.length > given.length:
        best = _without_needless(given, shows, tree)
    return trace if best == given else run(reference, best.stem + best.loop, len(best.stem))


def at_rest(trace: Trace, reference: Reference, claim: Claim, properties: Properties) -> Trace:
    """Return a run on which the claim is false, whose loop is an observation of what is so already, for a finite run
    after which it is false whatever follows; the given run if nothing such is found.
    """
    assert claim.formula is not None
    shows = _Shows(reference, Negation(claim.formula), claim.fair, properties)
    tried = _resting(reference, _Lasso(trace.events, ()), len(trace.moments) + LONGEST)
    found = next(filter(shows, tried), None)
    return trace if found is None else run(reference, found.steps, len(found.stem))


def guesses(claim: Claim) -> bool:
    """Return whether a monitor of lassos that violate a claim is nondeterministic: they need not end in states in which
    one condition stays true.
    """
    path = None if claim.formula is None or claim.linear else path_of(claim.formula, positive=False)
    return path is None or lingering_of(path.formula) is None


def _without_needless(lasso: _Lasso, shows: "_Shows", tree: "_Tree") -> _Lasso:
    """Return the lasso after as many turns as serve of four reductions: a loop at rest, single steps, related steps
    together, moved steps.
    """
    before: _Lasso | None = None
    while before != lasso:
        before = lasso
        lasso = next(filter(shows, _resting(shows.reference, lasso, 0)), lasso)
        for tried in _TRIED:
            lasso = _shorter(lasso, shows, tree, tried)
    return lasso


def _subject(event: Event) -> str:
    """Return the request or poster that an event is about."""
    return event.name if isinstance(event, Observe) else event.request


_TRIED: tuple[Callable[[_Lasso], Iterable[_Lasso]], ...] = (
    lambda given: (given.without({number}) for number in reversed(range(given.length))),
    lambda given: map(given.without, related(given, _subject, PAIRED)),
    lambda given: rearranged(given, _subject) if given.length <= PAIRED else (),
)
"""What is tried of a lasso, in this order."""


def _shorter(lasso: _Lasso, shows: "_Shows", tree: "_Tree", tried: Callable[[_Lasso], Iterable[_Lasso]]) -> _Lasso:
    """Replace the lasso by the first tried one that shows the violation, until there is none; return the last."""
    found: _Lasso | None = lasso
    while found is not None:
        lasso = found
        left = (tree.possible(_reread(shows.reference, each)) for each in tried(lasso))
        found = next(filter(shows, filter(None, left)), None)
    return lasso


class _Tree:
    """A tree of runs, of which each is followed but once."""

    def __init__(self, reference: Reference) -> None:
        self.reference = reference
        self.root = _Node(reference.start())

    def possible(self, lasso: _Lasso) -> _Lasso | None:
        """Return the lasso without its impossible steps, such as reports of idle slots; `None` if it does not close."""
        turn, stem = self._follow(self.root, lasso.stem)
        end, loop = self._follow(turn, lasso.loop)
        return _Lasso(stem, loop) if loop and turn.state.key() == end.state.key() else None

    def _follow(self, node: "_Node", events: Iterable[Event]) -> "tuple[_Node, tuple[Event, ...]]":
        """Return the end of these events, and those that are possible."""
        left: list[Event] = []
        for event in events:
            before = node
            if event not in before.after:
                state, actions = self.reference.step(before.state, event)
                impossible = any(isinstance(action, Invalid) for action in actions)
                before.after[event] = before if impossible else _Node(state)
            node = before.after[event]
            if node is not before:
                left.append(event)
        return node, tuple(left)


@dataclass(eq=False, slots=True)
class _Node:
    """A state of a tree of runs."""

    state: State
    after: "dict[Event, _Node]" = field(default_factory=dict)
    """By event the next state: this very node if the event is impossible."""


def _reread(reference: Reference, lasso: _Lasso) -> _Lasso:
    """Return the lasso; if its loop is one observation, let it observe what is so before the loop."""
    match lasso.loop:
        case (Observe(name, broken=False),):
            return _Lasso(lasso.stem, (Observe(name, end_of(reference, lasso.stem).observed(name)),))
        case _:
            return lasso


def _resting(reference: Reference, lasso: _Lasso, most: int) -> Iterator[_Lasso]:
    """Yield lassos that follow the given one up to a step, and then observe for ever what a poster or level is already.

    First those that do so at once; then, the shortest first, those of `most` steps or less that before report what is
    active (see `endings`).
    """
    events = lasso.steps
    if len(lasso.loop) == 1 and isinstance(lasso.loop[0], Observe):
        events = lasso.stem
    posters = [each.name for each in reference.model.variables if each.kind == "poster"]
    later: list[_Lasso] = []
    for count, state in enumerate(visited(reference, events)):
        observed = [*(Observe(name, state.readings[name]) for name in posters), *starmap(Observe, state.levels.items())]
        reports = _reports(reference, state, most - count)
        for each in endings(events[:count], reports, observed[:OBSERVED]):
            if each.length == count + 1 <= len(events):
                yield each
            elif each.length <= most:
                later.append(each)
    yield from sorted(later, key=lambda each: each.length)


def _reports(reference: Reference, state: State, most: int) -> tuple[Event, ...]:
    """Return reports, each ok with the least results, until nothing is active, or as many as `most`."""
    found: list[Event] = []
    while len(found) < most and (active := state.active()):
        request = reference.model.request[active[0][0]]
        found.append(Report(*active[0], "ok", tuple(least(each.type) for each in request.results)))
        state, _ = reference.step(state, found[-1])
    return tuple(found)


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
