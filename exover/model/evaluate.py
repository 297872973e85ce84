"""The value of a term and the truth of a condition in a state: the reference evaluation, slow and obvious."""

import operator
from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Any, assert_never

from exover.dataclass import dataclass
from exover.model.expression import (
    And,
    Compare,
    Cond,
    Const,
    Count,
    Last,
    Level,
    ModelTerm,
    Not,
    Or,
    Own,
    Param,
    Past,
    Reading,
    Status,
    Sum,
    Used,
)
from exover.model.model import Model, Parameter
from exover.model.state import Slot, State
from exover.model.types import Value

OPERATORS: dict[str, Callable[[Any, Any], bool]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


@dataclass(frozen=True, slots=True)
class Scope:
    """The values of parameters: `params` are what `Param` reads, `own` what `Own` reads (`self.p`)."""

    params: Mapping[str, Value] = field(default_factory=dict)
    own: Mapping[str, Value] = field(default_factory=dict)

    def about(self, params: Mapping[str, Value]) -> "Scope":
        """Return the scope inside a `where` whose subject has these parameters."""
        return Scope(params, self.params)


NOTHING = Scope()


def bind(parameters: tuple[Parameter, ...], values: tuple[Value, ...]) -> dict[str, Value]:
    """Return the values by parameter name; values past the last parameter are left out."""
    return {parameter.name: value for parameter, value in zip(parameters, values, strict=False)}


def value_of(model: Model, state: State, term: ModelTerm, scope: Scope) -> Any:
    """Return the value of a term: a bool, an int, a float or the name of an enum value."""
    match term:
        case Const(value):
            return value
        case Param(name):
            return scope.params[name]
        case Own(name):
            return scope.own[name]
        case Reading(name):
            return state.readings[name]
        case Level(resource):
            return state.levels[resource]
        case Used(resource):
            return sum(share_of(model, state, name, slot, resource) for name, slot in each_active(state))
        case Count(requests):
            return len(state.active(requests))
        case Sum(constant, terms):
            return constant + sum(factor * value_of(model, state, part, scope) for factor, part in terms)
        case _:
            assert_never(term)


def each_active(state: State) -> list[tuple[str, Slot]]:
    """Return the active slots with the names of their requests."""
    return [(name, slot) for name, slots in state.slots.items() for slot in slots if slot]


def share_of(model: Model, state: State, name: str, slot: Slot, resource: str) -> int:
    """Return how much of a renewable resource this slot of request `name` holds."""
    request = model.request[name]
    shares = [share for share in request.shares if share.resource == resource]
    if not shares:
        return 0
    scope = Scope(bind(request.params, slot.args))
    return sum(share.amount for share in shares if applies(model, state, share.when, scope))


def applies(model: Model, state: State, when: Cond | None, scope: Scope) -> bool:
    """Return whether a clause with this `when` counts: it has none, or the condition holds."""
    return when is None or holds(model, state, when, scope)


def holds(model: Model, state: State, cond: Cond, scope: Scope = NOTHING) -> bool:
    """Return whether a condition is true in a state."""
    match cond:
        case Compare(op, left, right):
            return OPERATORS[op](value_of(model, state, left, scope), value_of(model, state, right, scope))
        case Status(phase, name, where):
            if where is None:
                return bool(_arguments(state, phase, name))
            params = model.request[name].params
            return any(
                holds(model, state, where, scope.about(bind(params, args))) for args in _arguments(state, phase, name)
            )
        case Past(name, where):
            past = state.past[name]
            request = model.request[name]
            values = None if past is None else bind(request.params + request.results, past)
            return values is not None and (where is None or holds(model, state, where, scope.about(values)))
        case Last(name, outcome):
            return state.last[name] == outcome
        case Not(part):
            return not holds(model, state, part, scope)
        case And(parts):
            return all(holds(model, state, part, scope) for part in parts)
        case Or(parts):
            return any(holds(model, state, part, scope) for part in parts)
        case _:
            assert_never(cond)


def _arguments(state: State, phase: str, name: str) -> list[tuple[Value, ...]]:
    """Return the arguments of every slot of the request that is in this phase, or of its waiting place."""
    if phase == "waiting":
        place = state.places[name]
        return [place.args] if place else []
    return [slot.args for slot in state.slots[name] if slot and phase in ("active", slot.phase)]
