"""States on the way to a launch: a search that takes first what leaves the fewest obstacles.

The way is made of what the request depends on (a cone of influence): observations of the posters that its guards and
rules read, asks of the requests that change what these read, and so on. The search is best first (Pearl 1984), and
of two states with equally many obstacles it takes the one from which less was tried.
"""

from collections.abc import Callable, Iterator, Sequence
from heapq import heappop, heappush
from itertools import count
from random import Random

from exover.checks.causes.hindrances import settings, touches
from exover.checks.causes.near_events import arguments, assumed, least_arguments, observations, reports
from exover.model.event import Ask, Event, Observe
from exover.model.expression import Cond
from exover.model.model import Model, Request
from exover.model.property import Assumption
from exover.model.reads import Read, reads, rule_reads, users
from exover.model.semantics import Reference
from exover.model.state import State

STEPS = 240
"""The number of steps of a search."""
ASKS = 2
"""The number of random arguments with which a request is asked besides the least."""


def toward(
    reference: Reference,
    begun: State,
    assumptions: Sequence[Assumption],
    request: Request,
    obstacles: Callable[[State], int],
) -> Iterator[State]:
    """Yield the state, then different states on runs from it towards one with no `obstacles` of a request.

    Only steps are taken after which the assumptions are known to be true; none is an abort.
    """
    model, random, number = reference.model, Random(0), count(1)
    layers = list(_layers(reference, request))
    seen = {begun.key()}
    yield begun
    left = [(obstacles(begun), 0, 0, begun, _events(model, layers, begun, random))]
    for _ in range(STEPS):
        if not left:
            return
        amount, spent, place, here, events = heappop(left)
        event = next(events, None)
        if event is None:
            continue
        heappush(left, (amount, spent + 1, place, here, events))
        after = assumed(reference, here, event, assumptions)
        if after is None or after.key() in seen:
            continue
        seen.add(after.key())
        yield after
        fresh = _events(model, layers, after, random)
        heappush(left, (obstacles(after), spent + 1, next(number), after, fresh))


def _layers(reference: Reference, request: Request) -> Iterator[tuple[tuple[Observe, ...], tuple[Request, ...]]]:
    """Yield the observations and the requests that change what the request depends on, the nearest first."""
    model = reference.model
    further = [*(latch.condition for latch in model.latches), *(launch.condition for launch in model.launches)]
    seen = list(observations(model, further))
    read, known, names = [*_depends(reference, request), Read("active", request.name)], set[Read](), set[str]()
    while fresh := [each for each in dict.fromkeys(read) if each not in known]:
        known.update(fresh)
        read = [each for name in fresh for each in _through(model, name)]
        named = {each.name for each in fresh}
        changing = [each for each in model.requests if each.name not in names and _changes(model, each, fresh)]
        names.update(each.name for each in changing)
        yield tuple(each for each in seen if each.name in named), tuple(changing)
        read += [each for other in changing for each in _depends(reference, other)]


def _depends(reference: Reference, request: Request) -> list[Read]:
    """Return what the guards, rules and consumptions of a request read."""
    conditions: list[Cond] = [guard.condition for guard in request.guards]
    found = [each for condition in conditions for each in sorted(reads(condition))]
    found += [each for rule in reference.questions[request.name] for each in sorted(rule_reads(rule))]
    return found + [Read("level", each.resource) for each in request.consumptions]


def _through(model: Model, read: Read) -> list[Read]:
    """Return what a latch or the used amount of a resource depends on; nothing of anything else."""
    if read.kind == "used":
        return [Read("active", name) for name in users(model, read.name)]
    latches = [each for each in model.latches if read == Read("reading", each.name)]
    return [each for latch in latches for each in sorted(reads(latch.condition))]


def _changes(model: Model, request: Request, read: Sequence[Read]) -> bool:
    """Return whether a request changes something that is read, by its launch, its end or what these set."""
    levels = {each.resource for each in request.productions} | {each.resource for each in request.consumptions}
    return touches(request, read, levels) or bool(settings(model, request, read))


def _events(
    model: Model, layers: Sequence[tuple[Sequence[Observe], Sequence[Request]]], state: State, random: Random
) -> Iterator[Event]:
    """Yield the events to try in a state: reports after the nearest observations, then asks, the nearest first."""
    for number, (observed, asked) in enumerate(layers):
        yield from (each for each in observed if state.observed(each.name) != each.value)
        yield from reports(model, state, random) if number == 0 else ()
        for request in asked:
            if state.places[request.name] is None or request.interrupts_self:
                several = [arguments(request, random) for _ in range(ASKS)] if request.params else []
                yield from (Ask(request.name, args) for args in dict.fromkeys([least_arguments(request), *several]))
