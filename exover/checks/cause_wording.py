"""What keeps a request from a launch, and what there is in a state, in words."""

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType

from exover.checks.blocking import Blocked, reason_reads
from exover.model.evaluate import NOTHING, bind, value_of
from exover.model.event import Args
from exover.model.expression import Cond, Param, Status, Used, atoms, operands
from exover.model.model import Model, Request
from exover.model.reads import Read
from exover.model.state import State
from exover.model.wording import named_text, value_text

MOST = 6
"""So many values are told of a moment."""


def asked_text(request: Request, args: Args) -> str:
    """Return a request with the arguments with which it is asked."""
    return f"`{request.name}({named_text(request.params, args)})`"


def reason_text(model: Model, state: State, link: Blocked, where: str = "there") -> str:
    """Return a rule, its text, and what there is of it: all that a guard of the request reads, of a rule who is active,
    with the arguments that are read.

    Of a consumable it is the level.
    """
    request, reason = link.request, link.reason
    because = f" ({reason.because})" if reason.because else ""
    guards = [guard.condition for guard in request.guards if guard.name == reason.rule]
    rules = [rule.condition for rule in model.rules if rule.name == reason.rule]
    values = bind(request.params, link.args)
    asked = dict.fromkeys(term.name for guard in guards for term in operands(guard) if isinstance(term, Param))
    given = [f"{name} == {value_text(values[name])}" for name in asked]
    read = reason_reads(model, state, request, reason)
    told = read_there(model, state, read, given, where, arguments_read([*guards, *rules]))
    return ", ".join([f"`{reason.rule}`{because}", *told])


def arguments_read(conditions: Iterable[Cond]) -> dict[str, list[str]]:
    """Return, by request, the arguments that conditions read of its slots."""
    found: dict[str, list[str]] = {}
    for each in (each for condition in conditions for each in atoms(condition)):
        if isinstance(each, Status) and each.where is not None:
            names = (term.name for term in operands(each.where) if isinstance(term, Param))
            found.setdefault(each.request, []).extend(names)
    return found


def read_there(
    model: Model,
    state: State,
    read: Iterable[Read],
    given: Sequence[str] = (),
    where: str = "there",
    asked: Mapping[str, Sequence[str]] = MappingProxyType({}),
) -> list[str]:
    """Return what is given, and what a state has of what is read, as one part of a sentence, if there is anything.

    `asked`: by request the arguments that are told, too, where it is active.
    """
    told = list(given)
    for each in dict.fromkeys(read):
        names = asked.get(each.name, ()) if each.kind == "active" else ()
        slots = [slot for slot in state.slots[each.name] if slot] if names else []
        params = model.request[each.name].params if slots else ()
        for slot in slots:
            values = ", ".join(f"{n} == {value_text(v)}" for n, v in bind(params, slot.args).items() if n in names)
            told.append(f"{slot.phase}({each.name} with {values})")
        told += [] if slots else [_read_text(model, state, each)]
    more = [f"{len(told) - MOST} more"] if len(told) > MOST else []
    return [f"{where} {', '.join([*told[:MOST], *more])}"] if told else []


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
