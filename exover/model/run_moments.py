"""The truth of a formula at each moment of a lasso (Pnueli 1977), as far as the answers show it."""

from collections.abc import Sequence

from exover.dataclass import dataclass
from exover.model.evaluate import Scope, bind, holds
from exover.model.event import Args, Ask, Event, Invalid, Killed, Launched, Rejected, Report
from exover.model.expression import Cond
from exover.model.kleene import every, negated, some
from exover.model.model import Model
from exover.model.property import (
    Atom,
    Conjunction,
    Disjunction,
    Formula,
    Happened,
    Negation,
    Next,
    Passed,
    SomeAlways,
    SomeNext,
    SomeUntil,
    Until,
)
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import Answers

Moments = frozenset[int]
"""A set of moments of a run by number: the start is 0, the moment after step n is n."""


def moments_of(reference: Reference, stem: Sequence[Event], loop: Sequence[Event]) -> "RunMoments | None":
    """Return the moments of the lasso `stem loop loop`, whose second loop is repeated for ever.

    None if these events are no lasso: the loop is empty, an event is invalid, or the loop does not lead back.
    """
    if not loop:
        return None
    events = (None, *stem, *loop, *loop)
    states, answers = [reference.start()], [Answers()]
    for event in events[1:]:
        assert event is not None
        after, actions = reference.step(states[-1], event)
        if any(isinstance(each, Invalid) for each in actions):
            return None
        states.append(after)
        answers.append(actions)
    length = len(stem) + len(loop)
    if states[len(stem)].key() != states[length].key():
        return None
    return RunMoments(reference, events, states, answers, length + 1)


@dataclass(frozen=True, slots=True)
class RunMoments:
    """The moments of a lasso, the start first; the successor of the last one is the moment number `back`."""

    reference: Reference
    events: Sequence[Event | None]
    states: Sequence[State]
    answers: Sequence[Answers]
    back: int

    def is_fair(self) -> bool:
        """Return whether every slot is idle or reported at some moment of the loop."""
        repeated = range(self.back, len(self.states))
        reported = {(e.request, e.slot) for e in map(self.events.__getitem__, repeated) if isinstance(e, Report)}
        return all(
            (request.name, slot) in reported or any(self.states[k].slots[request.name][slot] is None for k in repeated)
            for request in self.reference.model.requests
            for slot in range(request.instances)
        )

    def where(self, formula: Formula, sure: bool = True) -> Moments:
        """Return the moments at which a formula is true, or if not `sure`, may be true, for answers do not show
        everything. `SomeNext` and its like are read on this one run, as if there were no other.
        """
        everywhere = frozenset(range(len(self.states)))
        match formula:
            case Negation(part):
                return everywhere - self.where(part, not sure)
            case Conjunction(parts):
                return everywhere.intersection(*(self.where(part, sure) for part in parts))
            case Disjunction(parts):
                return frozenset[int]().union(*(self.where(part, sure) for part in parts))
            case Next(part) | SomeNext(part):
                return self._before(self.where(part, sure))
            case Until(left, right) | SomeUntil(left, right):
                stay, found = self.where(left, sure), self.where(right, sure)
                for _ in everywhere:
                    found |= stay & self._before(found)
                return found
            case SomeAlways(part):
                found = self.where(part, sure)
                for _ in everywhere:
                    found &= self._before(found)
                return found
            case _:
                return self._now(formula, sure)

    def _before(self, moments: Moments) -> Moments:
        """Return the predecessors of these moments."""
        last = {len(self.states) - 1} if self.back in moments else set[int]()
        return frozenset(k - 1 for k in moments if k) | last

    def _now(self, formula: Formula, sure: bool) -> Moments:
        """Return the moments at which an atom is true, or if not `sure`, true or unknown."""
        wanted = (True,) if sure else (True, None)
        moments = enumerate(zip(self.events, self.states, self.answers, strict=True))
        return frozenset(k for k, moment in moments if is_true(self.reference.model, *moment, formula) in wanted)


def is_true(model: Model, event: Event | None, after: State, actions: Answers, formula: Formula) -> bool | None:
    """Return whether a formula without temporal operators is true after a step; None if the actions do not show it.

    `event` is None at the start.
    """

    def truth(part: Formula) -> bool | None:
        return is_true(model, event, after, actions, part)

    match formula:
        case Atom(condition):
            return holds(model, after, condition)
        case Negation(part):
            return negated(truth(part))
        case Conjunction(parts):
            return every(map(truth, parts))
        case Disjunction(parts):
            return some(map(truth, parts))
        case Happened("asked", request, None):
            return isinstance(event, Ask) and event.request == request
        case Happened("ended", request, None):
            return isinstance(event, Report) and event.request == request
        case Happened("launched", request, None):
            return any(isinstance(each, Launched) and each.request == request for each in actions)
        case Happened("killed", request, None):
            return any(isinstance(each, Killed) and each.request == request for each in actions)
        case Happened("rejected", request, None):
            if any(isinstance(each, Rejected) and each.request == request for each in actions):
                return True
            refused_again = event is not None and any(each.request == request for each in model.launches)
            return None if refused_again else False
        case Happened("asked", request, where) if where is not None and isinstance(event, Ask):
            return event.request == request and _with(model, after, where, request, event.args)
        case Happened("launched", request, where) if where is not None:
            launched = (each for each in actions if isinstance(each, Launched) and each.request == request)
            return any(_with(model, after, where, request, each.args) for each in launched)
        case Passed(("left", request)):
            about = [each for each in actions if isinstance(each, Launched | Rejected) and each.request == request]
            newcomer = isinstance(event, Ask) and event.request == request
            match about:
                case []:
                    return False
                case [Rejected(rule=rule)] if newcomer and rule != "superseded":
                    return False  # the newcomer alone is refused
                case _:
                    return None
        case _:
            return None


def _with(model: Model, after: State, where: Cond, request: str, args: Args) -> bool:
    return holds(model, after, where, Scope(bind(model.request[request].params, args)))
