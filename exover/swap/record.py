"""What the numbers of a record are (docs/runtime.md, "Restarts, and other tables"), in their order."""

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
    """What a poster, state or latch reads: `bits` of a real, its `rank`, an `ordinal`; `unread` if nothing reads it."""

    name: str
    how: str


@dataclass(frozen=True, slots=True)
class CarriedLevel:
    """The level of a consumable resource; `kept` iff something reads it."""

    resource: str
    kept: bool


@dataclass(frozen=True, slots=True)
class CarriedLast:
    """How the last instance ended; `kept` iff something reads it."""

    request: str
    kept: bool


@dataclass(frozen=True, slots=True)
class CarriedPast:
    """Whether the past of a request satisfies a condition."""

    request: str
    where: Cond | None


@dataclass(frozen=True, slots=True)
class CarriedPhase:
    """What a slot holds; slot -1 is the waiting place."""

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
    """The launch rule that put there what waits."""

    request: str


@dataclass(frozen=True, slots=True)
class Refusal:
    """For what a launch rule was refused by the last step."""

    launch: str


RecordField = CarriedReading | CarriedLevel | CarriedLast | CarriedPast | CarriedPhase | Argument | Origin | Refusal
PLACE = -1


def numbers(compiled: Compiled) -> dict[RecordField, int]:
    """Return what the numbers of a record of these tables are, each with its place."""
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
