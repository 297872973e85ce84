"""The events of a spec as functions of a typed API, independent of the language: their parameters and texts."""

from collections.abc import Collection, Iterable, Iterator
from typing import Literal

from exover.bounds.events import Bound, EventBounds
from exover.dataclass import dataclass
from exover.emit.identifiers import Call, SpecIdentifiers, fields
from exover.model.index import ModelIndex
from exover.model.model import Model, Parameter, Request
from exover.model.types import Bool, Enum, Int, Real, Type
from exover.model.wording import value_text

Scalar = Literal["bool", "int32", "int64", "double"]
"""A type that each target language has."""
Does = Literal["ask", "ok", "failed", "interrupted", "abort", "abort_waiting", "observe", "level"]
"""The kinds of events; `ok`, `failed` and `interrupted` are reports."""


@dataclass(frozen=True, slots=True)
class Statuses:
    """The type of the statuses with which the request of this number can fail."""

    request: int


FieldType = Scalar | Enum | Statuses


@dataclass(frozen=True, slots=True)
class Field:
    """A parameter of a function or a member of a struct; `range`: the values that it may have, empty if all."""

    type: FieldType
    name: str
    range: str = ""


@dataclass(frozen=True, slots=True)
class Struct:
    """The arguments or the results of a request; no struct is written if it has no fields."""

    about: str
    fields: tuple[Field, ...]


@dataclass(frozen=True, slots=True)
class EventCall:
    """A function that raises an event; `number`: of its request, poster or consumable, each counted by itself.

    `has_slot`: its first parameter, before the fields, is the number of a slot.
    """

    does: Does
    number: int
    about: str
    bound: Bound
    has_slot: bool = False
    fields: tuple[Field, ...] = ()


def field_of(kind: Type, name: str) -> Field:
    """Return a field with the values of a type."""
    match kind:
        case Bool():
            return Field("bool", name)
        case Int(low, high):
            fits = low >= -(1 << 31) and high < 1 << 31
            return Field("int32" if fits else "int64", name, f"{low} .. {high}")
        case Enum():
            return Field(kind, name)
        case Real(low, high):
            unbounded = low == -float("inf") and high == float("inf")
            return Field("double", name, "any that is finite" if unbounded else _between(low, high))


def _between(low: float, high: float) -> str:
    return f"{value_text(low)} .. {value_text(high)}"


def structs(model: Model, taken: Collection[str]) -> Iterator[tuple[Struct, Struct]]:
    """Yield the arguments and the results of each request; no field gets a name in `taken`."""
    for request in model.requests:
        yield (
            Struct(f"The arguments of {request.name}", _fields(request.params, taken)),
            Struct(f"What {request.name} returns if it ends well", _fields(request.results, taken)),
        )


def _fields(params: Iterable[Parameter], taken: Collection[str]) -> tuple[Field, ...]:
    params = tuple(params)
    return tuple(field_of(p.type, name) for p, name in zip(params, fields(params, taken), strict=True))


def calls(model: Model, most: EventBounds, taken: Collection[str]) -> Iterator[tuple[str, tuple[EventCall, ...]]]:
    """Yield for each request, poster and consumable its name in the spec and its calls.

    No argument or result gets a name in `taken`.
    """
    for number, request in enumerate(model.requests):
        yield request.name, tuple(_of_request(number, request, most, taken))
    index = ModelIndex(model)
    for place, (number, variable) in enumerate(index.posters):
        about, value = f"The poster {variable.name} reads a value", field_of(variable.type, "value")
        yield variable.name, (EventCall("observe", place, about, most.readings[number], fields=(value,)),)
    for number, resource in enumerate(index.consumables):
        about, value = f"The level of {resource.name} is known", field_of(Int(0, resource.capacity), "level")
        yield resource.name, (EventCall("level", number, about, most.levels[number], fields=(value,)),)


def _of_request(number: int, request: Request, most: EventBounds, taken: Collection[str]) -> Iterator[EventCall]:
    name, several, ended = request.name, request.instances > 1, most.reports[number]
    statuses = (Field(Statuses(number), "status"),) if request.statuses else ()
    args, results = _fields(request.params, taken), _fields(request.results, taken)
    yield EventCall("ask", number, f"Somebody asks for {name}", most.asks[number], fields=args)
    yield EventCall("ok", number, f"{name} has ended well", ended, several, results)
    yield EventCall("failed", number, f"{name} has failed", ended, several, statuses)
    yield EventCall("interrupted", number, f"{name} has ended since it was told to", ended, several)
    yield EventCall("abort", number, f"{name} shall end", most.aborts[number], several)
    yield EventCall("abort_waiting", number, f"The {name} that waits is given up", most.withdrawals[number])


def function_of(event: EventCall, known: SpecIdentifiers) -> Call:
    """Return the function that raises an event, and the enumerator of the event in a buffer."""
    if event.does == "observe":
        return known.observe[event.number]
    if event.does == "level":
        return known.level[event.number]
    names = known.typed[event.number]
    return {
        "ask": names.ask,
        "ok": names.ok,
        "failed": names.failed,
        "interrupted": names.interrupted,
        "abort": names.abort,
        "abort_waiting": names.abort_waiting,
    }[event.does]
