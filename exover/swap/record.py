"""The fields of a record, in their order (docs/runtime.md, "Restarts, and other tables")."""

from collections.abc import Iterator
from itertools import count

from exover.dataclass import dataclass
from exover.model.expression import Cond
from exover.model.index import ModelIndex
from exover.model.types import Real
from exover.ocrd.compile import Compiled
from exover.ocrd.tables import NONE
from exover.ocrd.vector import HasPast


@dataclass(frozen=True, slots=True)
class CarriedReading:
    """The value of a poster, state or latch; `how`: as `bits` or `rank` of a real, as `ordinal`, `unread` if unused."""

    name: str
    how: str


@dataclass(frozen=True, slots=True)
class CarriedLevel:
    """The level of a consumable resource; `kept` iff something reads it."""

    resource: str
    kept: bool


@dataclass(frozen=True, slots=True)
class CarriedLast:
    """How the last instance of a request ended; `kept` iff something reads it."""

    request: str
    kept: bool


@dataclass(frozen=True, slots=True)
class CarriedPast:
    """Whether the past of a request satisfies a condition."""

    request: str
    where: Cond | None


@dataclass(frozen=True, slots=True)
class CarriedPhase:
    """The phase of a slot; slot -1 is the waiting place."""

    request: str
    slot: int


@dataclass(frozen=True, slots=True)
class Argument:
    """An argument of a slot, or of the waiting place."""

    request: str
    slot: int
    name: str


@dataclass(frozen=True, slots=True)
class Origin:
    """The launch rule that put the request into its waiting place, or none."""

    request: str


@dataclass(frozen=True, slots=True)
class Refusal:
    """The refusal of a launch rule: for what the last step refused it, or none."""

    launch: str


RecordField = CarriedReading | CarriedLevel | CarriedLast | CarriedPast | CarriedPhase | Argument | Origin | Refusal
PLACE = -1


def numbers(compiled: Compiled) -> dict[RecordField, int]:
    """Return the fields of a record of these tables, each with its place from 0."""
    return dict(zip(_numbers(compiled), count(), strict=False))


def _numbers(compiled: Compiled) -> Iterator[RecordField]:
    model, tables = compiled.model, compiled.tables
    index = ModelIndex(model)
    for (name, kind), row in zip(index.typed_readings, tables.variables, strict=True):
        kept = "bits" if row.raw != NONE else "rank" if isinstance(kind, Real) else "ordinal"
        entry = row.rank if kept == "rank" else row.value
        yield CarriedReading(name, kept if kept == "bits" or entry != NONE else "unread")
    yield from (CarriedLevel(name, row.entry != NONE) for name, row in zip(index.stocks, tables.stocks, strict=True))
    for request, its in zip(model.requests, tables.requests, strict=True):
        yield CarriedLast(request.name, its.last != NONE)
        for past in tables.pasts[its.pasts : its.pasts_end]:
            quantity = compiled.entries[past.entry][0][1]
            assert isinstance(quantity, HasPast)
            yield CarriedPast(request.name, quantity.where)
        for slot in (*range(request.instances), PLACE):
            yield CarriedPhase(request.name, slot)
            yield from (Argument(request.name, slot, parameter.name) for parameter in request.params)
            if slot == PLACE and model.launches:
                yield Origin(request.name)
    yield from (Refusal(launch.name) for launch in model.launches)
