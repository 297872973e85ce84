"""Edits of random specs, and what they change, by plain enumeration of all runs of both versions."""

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import product
from random import Random

from exover.diff.deeds import changes_of, done
from exover.engines.aig.encoding.versions import ComparedLoops
from exover.model.difference import AnswerChange
from exover.model.event import Abort, AbortWaiting, Ask, Event, Observe, Report
from exover.model.model import Model, Parameter, Reject, Request, Wait
from exover.model.property import NO_PROPERTIES
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.types import Bool, Enum, Int, Type, Value
from exover.model.versions import Versions
from exover.ocrd.compile import Compiled
from tests.support.scene import TINY

FINITE = replace(TINY, requests=2, rules=4, instances=1, clauses=3, types=(Bool(), Enum(("left", "right"))))
"""Without reals, whose values cannot be enumerated."""


class TooLarge(Exception):
    """There are more states than are looked at."""


def loops_of(old: Compiled, new: Compiled) -> ComparedLoops:
    """Return two versions without properties."""
    return ComparedLoops(Versions(old.model, new.model), (old, new), (NO_PROPERTIES, NO_PROPERTIES))


def edited(model: Model, random: Random) -> Model:
    """Return a model with one thing changed: a rule, guard or launch is gone, or a remedy or guard is another."""
    found = list(_edits(model))
    return random.choice(found) if found else model


def _edits(model: Model) -> Iterator[Model]:
    for name in dict.fromkeys(rule.name for rule in model.rules):
        yield replace(model, rules=tuple(rule for rule in model.rules if rule.name != name))
        for remedies in ((Reject(),), (Wait(),)):
            rules = (replace(rule, remedies=remedies) if rule.name == name else rule for rule in model.rules)
            yield replace(model, rules=tuple(rules))
    for launch in model.launches:
        yield replace(model, launches=tuple(each for each in model.launches if each is not launch))
    for request in model.requests:
        if request.on_launch or request.on_ok or request.on_failed or request.on_interrupted:
            yield _with(model, replace(request, on_launch=(), on_ok=(), on_failed=(), on_interrupted=()))
        for guard in request.guards:
            yield _with(model, replace(request, guards=tuple(each for each in request.guards if each is not guard)))
            kind = "settle" if guard.kind == "check" else "check"
            guards = (replace(each, kind=kind) if each is guard else each for each in request.guards)
            yield _with(model, replace(request, guards=tuple(guards)))


def _with(model: Model, request: Request) -> Model:
    return replace(model, requests=tuple(request if r.name == request.name else r for r in model.requests))


def enumerated(old: Model, new: Model, most: int) -> dict[AnswerChange, int]:
    """Return by change that some run shows how many steps the shortest has; raises `TooLarge` beyond so many states.

    Both have the same requests, posters and consumables.
    """
    versions, references = Versions(old, new), (Reference(old), Reference(new))
    start = (references[0].start(), references[1].start())
    depth = {_key(start): 0}
    queue = deque([start])
    found: dict[AnswerChange, int] = {}
    while queue:
        states = queue.popleft()
        steps = depth[_key(states)] + 1
        for event in _events(old, states[0]):
            one, other = (done(r, s, event) for r, s in zip(references, states, strict=True))
            seen = set(changes_of(versions, one, other))
            for change in seen:
                found.setdefault(change, steps)
            after = (one.after, other.after)
            if not seen and _key(after) not in depth:
                depth[_key(after)] = steps
                queue.append(after)
        if len(depth) > most:
            raise TooLarge
    return found


def _key(states: tuple[State, State]) -> tuple[object, ...]:
    return states[0].key(), states[1].key()


def _events(model: Model, state: State) -> Iterator[Event]:
    for request in model.requests:
        for args in _all(request.params):
            yield Ask(request.name, args)
        if state.places[request.name]:
            yield AbortWaiting(request.name)
    for name, slot in state.active():
        yield from (Report(name, slot, "ok", results) for results in _all(model.request[name].results))
        yield Report(name, slot, "failed")
        yield Report(name, slot, "interrupted")
        yield Abort(name, slot)
    for variable in model.variables:
        if variable.kind == "poster":
            yield from (Observe(variable.name, value) for value in _values(variable.type))
    for name, stock in model.resource.items():
        if stock.consumable:
            yield from (Observe(name, level) for level in range(stock.capacity + 1))


def _all(parameters: tuple[Parameter, ...]) -> Iterable[tuple[Value, ...]]:
    return product(*(_values(parameter.type) for parameter in parameters))


def _values(kind: Type) -> Iterable[Value]:
    match kind:
        case Bool():
            return False, True
        case Int(low, high):
            return range(low, high + 1)
        case Enum(values):
            return values
        case _:
            raise TooLarge
