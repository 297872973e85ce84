"""The abstraction of a concrete state, and the concretizations of an event of the loop."""

from exover.loop.finite.builder import ClosedLoop, LoopEvent
from exover.loop.finite.real_orders import candidates
from exover.model.event import Ask, Event, Observe
from exover.model.index import ModelIndex
from exover.model.state import Place, Slot, State
from exover.model.types import Real, contains, ordinal
from exover.ocrd.entries import compare
from exover.ocrd.memory import CLEARING, EMPTY, IDLE, RUNNING, STOPPING, WAITING
from exover.ocrd.vector import OUTCOMES


def abstract(loop: ClosedLoop, state: State) -> list[int]:
    """Return the values of the loop's variables in a concrete state, between two steps."""
    values = [0] * len(loop.variables)
    stocks = ModelIndex(loop.model).stocks
    slots = [(k, slot) for k, r in enumerate(loop.model.requests) for slot in state.slots[r.name]]
    for var, variable in enumerate(loop.variables):
        match variable.key:
            case ("reading", int(number)):
                values[var] = loop.reading_cell(number, _number(loop, number, state))
            case ("level", int(number)):
                values[var] = state.levels[stocks[number]]
            case ("phase", int(number)):
                values[var] = _phase(slots[number][1])
            case ("class", int(number)):
                request, slot = slots[number]
                values[var] = loop.arguments[request].cell_of(slot.args).slot_class if slot else 0
            case ("place", int(number)):
                values[var] = _standing(state.places[loop.model.requests[number].name])
            case ("cell", int(number)):
                place = state.places[loop.model.requests[number].name]
                values[var] = loop.arguments[number].cell_of(place.args).number if place else 0
            case ("order", int(number), int(which)):
                request, slot = slots[number]
                values[var] = _order(loop, request, which, slot, state)
            case ("standing", int(number), int(which)):
                values[var] = _order(loop, number, which, state.places[loop.model.requests[number].name], state)
            case ("pair", int(left), int(right)):
                sides = (float(state.readings[loop.names[side]]) for side in (left, right))
                values[var] = compare(*sides)
            case ("past", int(number)):
                values[var] = _past(loop, number, state)
            case ("last", int(number)):
                values[var] = OUTCOMES.index(state.last[loop.model.requests[number].name])
            case _:
                pass
    return values


def _number(loop: ClosedLoop, reading: int, state: State) -> float:
    value, kind = state.readings[loop.names[reading]], loop.types[reading]
    return float(value) if isinstance(kind, Real) else ordinal(kind, value)


def _order(loop: ClosedLoop, request: int, which: int, held: Slot | Place | None, state: State) -> int:
    if held is None:
        return 0
    order = loop.arguments[request].poster_orders[which]
    return compare(float(held.args[order.left]), float(state.readings[loop.names[-1 - order.right]]))


def _phase(slot: Slot | None) -> int:
    if slot is None:
        return IDLE
    return RUNNING if slot.phase == "running" else STOPPING


def _standing(place: Place | None) -> int:
    if place is None:
        return EMPTY
    return CLEARING if place.clearing else WAITING


def _past(loop: ClosedLoop, request: int, state: State) -> int:
    past = state.past[loop.model.requests[request].name]
    if past is None:
        return 0
    split = len(loop.arguments[request].params)
    return 1 + loop.arguments[request].pasts.number(past[:split], past[split:])


def concretes(loop: ClosedLoop, event: LoopEvent, state: State) -> list[Event]:
    """Return concrete events for which `event` stands, with reals in several orders to those that `state` holds."""
    arguments = None
    if isinstance(event.event, Ask):
        arguments = loop.arguments[loop.request_number[event.event.request]]
    return [each for each in candidates(event.event, event.cell, arguments, state) if _like(loop, each, event)]


def _like(loop: ClosedLoop, concrete: Event, event: LoopEvent) -> bool:
    """Return whether a concrete event is one of those that `event` stands for."""
    match concrete:
        case Ask(name, args):
            arguments = loop.arguments[loop.request_number[name]]
            fits = all(contains(p.type, v) for p, v in zip(arguments.params, args, strict=True))
            return fits and arguments.cell_of(args) == event.cell
        case Observe(name, float(value)) if isinstance(event.event, Observe):
            if not contains(loop.model.variable[name].type, value):
                return False
            number = loop.names.index(name)
            return number not in loop.samples or loop.reading_cell(number, value) == loop.reading_cell(
                number, float(event.event.value)
            )
        case _:
            return True
