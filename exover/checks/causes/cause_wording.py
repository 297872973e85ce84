"""Obstacles of launches, and the values of a state that matter for them, in words."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

from exover.checks.causes.blocking import Blocked
from exover.checks.causes.hindrances import reason_reads
from exover.model.decision import Decisions
from exover.model.evaluate import NOTHING, Scope, applies, bind, value_of
from exover.model.event import Args
from exover.model.expression import Compare, Cond, Own, Param, Past, Status, Used, atoms, operands
from exover.model.model import Consumption, Model, Request, Resource, Share
from exover.model.reads import Read
from exover.model.state import State
from exover.model.wording import named_text, value_text

MOST = 6
"""The greatest number of values of one moment in a message."""


def asked_text(request: Request, args: Args) -> str:
    """Return a request with the arguments with which it is asked."""
    return f"`{request.name}({named_text(request.params, args)})`"


def reason_text(model: Model, state: State, link: Blocked, where: str = "there") -> str:
    """Return the rule that blocks a request, its `because`, and the values in the state that explain it.

    Of a guard these are all values that it reads, of a rule the active requests with the arguments that are read, and
    values with those that the launch would give them, of a consumable its level.
    """
    request, reason = link.request, link.reason
    because = f" ({reason.because})" if reason.because else ""
    wants = _wanted(model, state, link)
    more = f" (it wants {wants} of {model.resource[reason.rule].capacity})" if wants else ""
    guards = [guard.condition for guard in request.guards if guard.name == reason.rule]
    rules = [rule.condition for rule in model.rules_named(reason.rule)]
    values = bind(request.params, link.args)
    asked = dict.fromkeys(name for guard in guards for name in _own_parameters(guard))
    given = [f"{name} == {value_text(values[name])}" for name in asked]
    read = reason_reads(model, state, request, reason)
    launched = Decisions(model).launching(state, request, link.args, 0) if rules else None
    told = read_there(model, state, read, where, arguments_read([*guards, *rules]), given, launched)
    return ", ".join([f"`{reason.rule}`{because}{more}", *told])


def _own_parameters(guard: Cond) -> Iterator[str]:
    """Yield the parameters of its request that a guard reads, those of `self.p` too."""
    for each in atoms(guard):
        match each:
            case Status(where=where) | Past(where=where) if where is not None:
                yield from (term.name for term in operands(where) if isinstance(term, Own))
            case Compare():
                yield from (term.name for term in operands(each) if isinstance(term, Param))
            case _:
                pass


def _wanted(model: Model, state: State, link: Blocked) -> int:
    """Return how much the request wants of the resource that blocks it if that exceeds its capacity, else 0."""
    resource, request = model.resource.get(link.reason.rule), link.request
    if resource is None:
        return 0
    scope = Scope(bind(request.params, link.args))
    return _beyond(request, resource, lambda when: applies(model, state, when, scope))


def beyond_capacity(model: Model, request: Request) -> Iterator[str]:
    """Yield, in words, the resources of which a request wants more than the capacity, whatever its arguments."""
    for resource in model.resources:
        wants = _beyond(request, resource, lambda when: when is None)
        if wants:
            yield f"it wants {wants} of `{resource.name}`, of which there are {resource.capacity}"


def _beyond(request: Request, resource: Resource, counts: Callable[[Cond | None], bool]) -> int:
    """Return how much a request wants by the clauses that count if that exceeds the capacity, else 0."""
    clauses: Iterable[Share | Consumption] = (*request.shares, *request.consumptions)
    wants = sum(each.amount for each in clauses if each.resource == resource.name and counts(each.when))
    return wants if wants > resource.capacity else 0


def arguments_read(conditions: Iterable[Cond]) -> dict[Read, list[str]]:
    """Return, for slots, waiting places and pasts of which conditions read more than whether they are taken, the names
    of the arguments that they read; none if they read only whether a slot is running or stopping.
    """
    found: dict[Read, list[str]] = {}
    for each in (each for condition in conditions for each in atoms(condition)):
        match each:
            case Status(phase, request, where) if where is not None or phase in ("running", "stopping"):
                read = Read("waiting" if phase == "waiting" else "active", request)
            case Past(request, where) if where is not None:
                read = Read("past", request)
            case _:
                continue
        names = (term.name for term in operands(where) if isinstance(term, Param)) if where else ()
        found.setdefault(read, []).extend(names)
    return found


def read_there(
    model: Model,
    state: State,
    read: Iterable[Read],
    where: str,
    asked: Mapping[Read, Sequence[str]],
    given: Sequence[str] = (),
    launched: State | None = None,
) -> list[str]:
    """Return `given` and the values of a state that are `read`, as at most one part of a sentence.

    `asked`: maps reads to the arguments that are named with them. `launched`: the state after the launch of a request,
    of which values are named that are others.
    """
    told = list(given)
    for each in dict.fromkeys(read):
        found = _taken(state, each) if each in asked else []
        named = (_named(model.request[each.name], phase, values, asked[each]) for phase, values in found)
        told += dict.fromkeys(named) if found else [_before(model, state, each, launched)]
    more = [f"{len(told) - MOST} more"] if len(told) > MOST else []
    return [f"{where} {', '.join([*told[:MOST], *more])}"] if told else []


def _before(model: Model, state: State, read: Read, launched: State | None) -> str:
    """Return a value, with the one after a launch if that is another and the launch sets it."""
    said = _read_text(model, state, read)
    if launched is None or read.kind not in ("reading", "level", "past"):
        return said
    then = _read_text(model, launched, read)
    return said if then == said else f"{said} (once it is launched: {then})"


def _taken(state: State, read: Read) -> list[tuple[str, Args]]:
    """Return the arguments in the slots, the waiting place or the past of a request, each after its phase."""
    place, past = state.places[read.name], state.past[read.name]
    match read.kind:
        case "active":
            return [(slot.phase, slot.args) for slot in state.slots[read.name] if slot]
        case "waiting":
            return [("waiting", place.args)] if place else []
        case _:
            return [("past", past)] if past is not None else []


def _named(request: Request, phase: str, values: Args, names: Sequence[str]) -> str:
    bound = bind((*request.params, *request.results)[: len(values)], values)
    told = ", ".join(f"{name} == {value_text(value)}" for name, value in bound.items() if name in names)
    return f"{phase}({request.name} with {told})" if told else f"{phase}({request.name})"


def _read_text(model: Model, state: State, read: Read) -> str:
    match read.kind:
        case "active":
            phases = {slot.phase for slot in state.slots[read.name] if slot}
            return f"{'stopping' if phases == {'stopping'} else 'active' if phases else 'not active'}({read.name})"
        case "waiting":
            return f"waiting({read.name})" if state.places[read.name] else f"not waiting({read.name})"
        case "past":
            return f"past({read.name})" if state.past[read.name] is not None else f"not past({read.name})"
        case "last":
            return f"last({read.name}) == {state.last[read.name]}"
        case "level":
            return f"level({read.name}) == {state.levels[read.name]}"
        case "reading":
            return f"{read.name} == {value_text(state.readings[read.name])}"
        case "used":
            return f"used({read.name}) == {value_of(model, state, Used(read.name), NOTHING)}"
