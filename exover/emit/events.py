"""The events of a spec as functions of C: parameters with their types, what they are in a buffer, what is called."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal

from exover.bounds.events import Bound, EventBounds
from exover.emit.identifiers import Call, SpecIdentifiers, fields
from exover.model.index import ModelIndex
from exover.model.model import Model, Parameter, Request
from exover.model.types import Bool, Enum, Int, Real, Type
from exover.model.wording import value_text


@dataclass(frozen=True, slots=True)
class Field:
    """A parameter of a function or a member of a struct: its type and name in C, and the values it may have."""

    type: str
    name: str
    range: str
    real: bool


@dataclass(frozen=True, slots=True)
class Struct:
    """The arguments or the results of a request; there is none without fields."""

    name: str
    about: str
    fields: tuple[Field, ...]


Does = Literal["ask", "ok", "failed", "interrupted", "abort", "abort_waiting", "observe", "level"]
"""What an event is; `ok`, `failed` and `interrupted` are reports."""


@dataclass(frozen=True, slots=True)
class EventCall:
    """A function that raises an event, of the request, poster or consumable `number` among these.

    `generic` is the call underneath, without the checker: `{values}` stands for the values and their number, `{slot}`
    for the slot. In a buffer the values are a member of that type in the union; `members` are read from it.
    """

    does: Does
    number: int
    call: Call
    about: str
    bound: Bound
    has_slot: bool
    fields: tuple[Field, ...]
    generic: str
    member: str
    """The type of the member of the union; empty if the event has no values."""


def field_of(kind: Type, name: str, known: SpecIdentifiers) -> Field:
    """Return how C has a value of this type."""
    match kind:
        case Bool():
            return Field("bool", name, "", False)
        case Int(low, high):
            fits = low >= -(1 << 31) and high < 1 << 31
            return Field("int32_t" if fits else "int64_t", name, f"{low} .. {high}", False)
        case Enum():
            return Field(known.enums[kind].type, name, "", False)
        case Real(low, high):
            unbounded = low == -float("inf") and high == float("inf")
            return Field("double", name, "any that is finite" if unbounded else _between(low, high), True)


def _between(low: float, high: float) -> str:
    return f"{value_text(low)} .. {value_text(high)}"


def structs(model: Model, known: SpecIdentifiers) -> Iterator[tuple[Struct, Struct]]:
    """Yield the arguments and the results of each request."""
    for request, names in zip(model.requests, known.typed, strict=True):
        args, results = _fields(request.params, known), _fields(request.results, known)
        yield (
            Struct(names.args, f"The arguments of {request.name}", args),
            Struct(names.results, f"What {request.name} returns if it ends well", results),
        )


def _fields(params: Iterable[Parameter], known: SpecIdentifiers) -> tuple[Field, ...]:
    params = tuple(params)
    return tuple(field_of(p.type, name, known) for p, name in zip(params, fields(params), strict=True))


def calls(model: Model, known: SpecIdentifiers, most: EventBounds) -> Iterator[tuple[str, tuple[EventCall, ...]]]:
    """Yield the calls of each request, poster and consumable, with its name in the spec."""
    for number, request in enumerate(model.requests):
        yield request.name, tuple(_of_request(number, request, known, most))
    index = ModelIndex(model)
    for place, ((number, variable), call) in enumerate(zip(index.posters, known.observe, strict=True)):
        value, bound = field_of(variable.type, "value", known), most.readings[number]
        generic = f"exover_observe({{r2c}}, {known.posters[place][0]}, {{value}})"
        about = f"The poster {variable.name} reads a value"
        yield variable.name, (EventCall("observe", place, call, about, bound, False, (value,), generic, value.type),)
    for number, (resource, call) in enumerate(zip(index.consumables, known.level, strict=True)):
        value = field_of(Int(0, resource.capacity), "level", known)
        generic = f"exover_level({{r2c}}, {known.stocks[number][0]}, {value.name})"
        about, bound = f"The level of {resource.name} is known", most.levels[number]
        yield resource.name, (EventCall("level", number, call, about, bound, False, (value,), generic, value.type),)


def _of_request(number: int, request: Request, known: SpecIdentifiers, most: EventBounds) -> Iterator[EventCall]:
    names, (constant, _), name = known.typed[number], known.requests[number], request.name
    args, results = _fields(request.params, known), _fields(request.results, known)
    several = request.instances > 1
    status = Field(names.statuses.type, "status", "", False)
    report = f"exover_report({{r2c}}, {constant}, {{slot}}, "
    ended = most.reports[number]
    yield EventCall(
        "ask", number, names.ask, f"Somebody asks for {name}", most.asks[number], False, args,
        f"exover_ask({{r2c}}, {constant}, {{values}})", names.args if args else "",
    )  # fmt: skip
    yield EventCall(
        "ok", number, names.ok, f"{name} has ended well", ended, several, results,
        f"{report}EXOVER_OK, -1, {{values}})", names.results if results else "",
    )  # fmt: skip
    statuses = (status,) if request.statuses else ()
    code = "(int32_t)status" if statuses else "-1"
    yield EventCall(
        "failed", number, names.failed, f"{name} has failed", ended, several, statuses,
        f"{report}EXOVER_FAILED, {code}, NULL, 0)", status.type if statuses else "",
    )  # fmt: skip
    yield EventCall(
        "interrupted", number, names.interrupted, f"{name} has ended since it was told to", ended, several, (),
        f"{report}EXOVER_INTERRUPTED, -1, NULL, 0)", "",
    )  # fmt: skip
    yield EventCall(
        "abort", number, names.abort, f"{name} shall end", most.aborts[number], several, (),
        f"exover_abort({{r2c}}, {constant}, {{slot}})", "",
    )  # fmt: skip
    yield EventCall(
        "abort_waiting", number, names.withdraw, f"The {name} that waits is given up", most.withdrawals[number],
        False, (), f"exover_abort_waiting({{r2c}}, {constant})", "",
    )  # fmt: skip
