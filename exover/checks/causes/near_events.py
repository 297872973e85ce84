"""Events with values near the constants of a model's conditions, and states that random runs of them reach."""

from collections.abc import Iterable, Iterator, Sequence
from random import Random

from exover.model.event import ENDINGS, Ask, Ending, Event, Observe, Report
from exover.model.expression import Compare, Cond, Const, Reading, atoms
from exover.model.model import Model, Request
from exover.model.property import Assumption
from exover.model.run_moments import is_true
from exover.model.semantics import Reference
from exover.model.state import SlotId, State
from exover.model.types import Bool, Enum, Int, Real, Type, Value, contains, least

WALKS, STEPS = 12, 10
"""The number of random runs from a state, and their steps."""


def observations(model: Model, further: Iterable[Cond] = ()) -> Iterator[Observe]:
    """Yield observations of the posters that rules and guards of a model, or `further` conditions, compare, with values
    around their constants, of each consumable at its capacity, and of those that requests consume empty.
    """
    found: dict[str, dict[Value, None]] = {}
    for condition in (*objecting(model), *further):
        for name, value in _compared(condition):
            if name in model.variable and model.variable[name].kind == "poster":
                kind = model.variable[name].type
                values = (each for each in _beside(kind, value) if contains(kind, each))
                found.setdefault(name, {}).update(dict.fromkeys(values))
    yield from (Observe(name, value) for name, values in found.items() for value in values)
    yield from (Observe(each.name, each.capacity) for each in model.resources if each.consumable)
    yield from (Observe(each, 0) for each in sorted({e.resource for r in model.requests for e in r.consumptions}))


def objecting(model: Model) -> list[Cond]:
    """Return the conditions of the rules and guards of a model."""
    guards = (guard.condition for request in model.requests for guard in request.guards)
    return [*(rule.condition for rule in model.rules), *guards]


def _compared(condition: Cond) -> Iterator[tuple[str, Value]]:
    for atom in atoms(condition):
        match atom:
            case Compare(_, Reading(name), Const(value)) | Compare(_, Const(value), Reading(name)):
                yield name, value
            case _:
                pass


def _beside(kind: Type, value: Value) -> tuple[Value, ...]:
    """Return values of a type below, at and above a constant, some perhaps out of range; all of a bool or an enum."""
    match kind, value:
        case Bool(), _:
            return False, True
        case Enum(values), _:
            return values
        case Int(low, high), int():
            return value - 1, value, value + 1, low, high
        case Real(low, high), float():
            return low, (low + value) / 2, value, (value + high) / 2, high
        case _:
            return ()


def arguments(request: Request, random: Random) -> tuple[Value, ...]:
    """Return random arguments of a request."""
    return tuple(_any(parameter.type, random) for parameter in request.params)


def least_arguments(request: Request) -> tuple[Value, ...]:
    """Return the least arguments of a request."""
    return tuple(least(parameter.type) for parameter in request.params)


def _any(kind: Type, random: Random) -> Value:
    match kind:
        case Bool():
            return random.random() < 0.5
        case Int(low, high):
            return random.randint(low, high)
        case Enum(values):
            return random.choice(values)
        case Real(_, high):
            lowest = float(least(kind))
            found = random.uniform(lowest, min(high, max(0.0, lowest) + 1e3)) if lowest < high else lowest
            return plain if contains(kind, plain := round(found, 1)) else found


def onward(
    reference: Reference, state: State, assumptions: Sequence[Assumption], often: Sequence[Request] = ()
) -> Iterator[State]:
    """Yield the state, then the states of random runs from it, by reports, observations and asks.

    Only steps are taken after which the assumptions are known to be true. `often`: requests that are preferred in half
    of the steps.
    """
    model, random = reference.model, Random(0)
    seen = list(observations(model))
    yield state
    for _ in range(WALKS):
        here = state
        for _ in range(STEPS):
            after = assumed(reference, here, _event(model, here, seen, often, random), assumptions)
            if after is not None:
                here = after
                yield here


def assumed(reference: Reference, state: State, event: Event, assumptions: Sequence[Assumption]) -> State | None:
    """Return the state after an event; None unless the assumptions are known to be true after that step."""
    after, actions = reference.step(state, event)
    known = (is_true(reference.model, event, after, actions, each.formula) for each in assumptions)
    return after if all(known) else None


def _event(model: Model, state: State, seen: Sequence[Observe], often: Sequence[Request], random: Random) -> Event:
    likely = often if often and random.random() < 0.5 else model.requests
    active, chance = state.active(each.name for each in likely), random.random()
    if active and chance < 0.4:
        name, slot = random.choice(active)
        outcome = "ok" if random.random() < 0.7 else random.choice(ENDINGS)
        return _report(model, (name, slot), outcome, random)
    if seen and chance < 0.6:
        return random.choice(seen)
    request = random.choice(likely)
    return Ask(request.name, arguments(request, random))


def reports(model: Model, state: State, random: Random) -> Iterator[Report]:
    """Return an iterator of reports: one for each active slot and outcome, with random results."""
    active = state.active(each.name for each in model.requests)
    return (_report(model, slot, outcome, random) for slot in active for outcome in ENDINGS)


def _report(model: Model, slot: SlotId, outcome: Ending, random: Random) -> Report:
    results = tuple(_any(each.type, random) for each in model.request[slot[0]].results) if outcome == "ok" else ()
    return Report(*slot, outcome, results)
