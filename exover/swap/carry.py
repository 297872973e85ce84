"""Carries the state of OLD over to NEW: what has the same name and the same meaning in both."""

from collections.abc import Iterator
from functools import cached_property

from exover.dataclass import dataclass
from exover.model.model import Model, Parameter, Request
from exover.model.types import Bool, Enum, Int, Real, Type
from exover.ocrd.compile import Compiled
from exover.ocrd.reasons import reasons
from exover.ocrd.vector import Vocabulary
from exover.swap.record import (
    Argument,
    CarriedLast,
    CarriedLevel,
    CarriedPast,
    CarriedPhase,
    CarriedReading,
    Origin,
    RecordField,
    Refusal,
    numbers,
)

AS_IT_IS: tuple[int, ...] = ()


@dataclass(frozen=True)
class Carry:
    """Which numbers of a record of OLD become which numbers of a record of NEW."""

    old: Compiled
    new: Compiled

    @cached_property
    def before(self) -> dict[RecordField, int]:
        """The fields of a record of OLD, with their places."""
        return numbers(self.old)

    @cached_property
    def after(self) -> dict[RecordField, int]:
        """The fields of a record of NEW, with their places."""
        return numbers(self.new)

    @cached_property
    def changed(self) -> frozenset[str]:
        """The requests of OLD that NEW lacks or changes, so their slots mean nothing there; they have to be idle."""
        return frozenset(request.name for request in self.old.model.requests if not self._same(request))

    def _same(self, request: Request) -> bool:
        other = self.new.model.request.get(request.name)
        return (
            other is not None
            and [p.name for p in request.params] == [p.name for p in other.params]
            and all(_within(mine.type, its.type) for mine, its in zip(request.params, other.params, strict=True))
            and (request.results, request.statuses) == (other.results, other.statuses)
            and request.instances <= other.instances
        )

    def ways(self) -> Iterator[tuple[int, tuple[int, ...]] | None]:
        """Yield for each field of NEW the place in OLD of its source, and the list that maps the source's number, empty
        if it stays as it is; None if the field gets its initial value.
        """
        return (self.way(number) for number in self.after)

    def way(self, number: RecordField) -> tuple[int, tuple[int, ...]] | None:
        """Return the source of one field of NEW, as `ways` yields it."""
        source: RecordField = number
        becomes: tuple[int, ...] | None = AS_IT_IS
        match number:
            case CarriedReading(name, how):
                source, becomes = self._reading(name, how)
            case CarriedLevel(resource):
                becomes = (
                    AS_IT_IS
                    if self._capacity(self.old.model, resource) <= self._capacity(self.new.model, resource)
                    else None
                )
            case CarriedLast() | CarriedPast() if number.request in self.changed:
                becomes = None
            case CarriedPhase(request) | Argument(request) if request in self.changed:
                becomes = None
            case Argument(request, _, name) if request in self.old.model.request:
                becomes = _becomes(
                    _param(self.old.model, request, name).type, _param(self.new.model, request, name).type
                )
            case Origin():
                becomes = self._origins
            case Refusal():
                becomes = None
            case _:
                pass
        if becomes is None or source not in self.before:
            return None
        return self.before[source], becomes

    @staticmethod
    def _capacity(model: Model, resource: str) -> int:
        return model.resource[resource].capacity if resource in model.resource else 0

    def _reading(self, name: str, how: str) -> tuple[RecordField, tuple[int, ...] | None]:
        source = CarriedReading(name, how)
        old, new = _kind(self.old.model, name), _kind(self.new.model, name)
        if how == "unread" or old is None or new is None or old[0] != new[0]:
            return source, None
        becomes = _becomes(old[1], new[1])
        if becomes is not None and how == "rank":
            becomes = _ranks(self._cuts(self.old, name), self._cuts(self.new, name))
        return source, becomes

    @staticmethod
    def _cuts(compiled: Compiled, name: str) -> tuple[float, ...]:
        return Vocabulary(compiled.model).thresholds.get((None, name), ())

    @cached_property
    def _origins(self) -> tuple[int, ...]:
        """The list that maps origins (0: asked for, else a reason plus 1) to NEW; 0 if NEW has no such launch rule."""
        known = {launch.name: launch for launch in self.new.model.launches}
        place = {reason.rule: number + 1 for number, reason in enumerate(reasons(self.new.model))}
        mine = {launch.name: launch for launch in self.old.model.launches}
        same = [
            r.rule in known and r.rule in mine and known[r.rule].request == mine[r.rule].request
            for r in reasons(self.old.model)
        ]
        return (0, *(place[r.rule] if kept else 0 for r, kept in zip(reasons(self.old.model), same, strict=True)))

    def remembers(self, number: RecordField) -> bool:
        """Return whether a field of NEW is carried over."""
        return self.way(number) is not None


def _param(model: Model, request: str, name: str) -> Parameter:
    (found,) = (parameter for parameter in model.request[request].params if parameter.name == name)
    return found


def _kind(model: Model, name: str) -> tuple[str, Type] | None:
    """Return the kind of what has this name (a variable's kind, or `latch`) and its type; None if nothing has it."""
    if name in model.variable:
        return model.variable[name].kind, model.variable[name].type
    return ("latch", Bool()) if any(latch.name == name for latch in model.latches) else None


def _within(old: Type, new: Type) -> bool:
    """Return whether every value of the old type is one of the new type."""
    match old, new:
        case Enum(mine), Enum(others):
            return set(mine) <= set(others)
        case (Int(low, high), Int(least, most)) | (Real(low, high), Real(least, most)):
            return least <= low and high <= most
        case _:
            return old == new


def _becomes(old: Type, new: Type) -> tuple[int, ...] | None:
    """Return the list that maps numbers of the old type to the new type; None if some value has no counterpart."""
    if not _within(old, new):
        return None
    if isinstance(old, Enum) and isinstance(new, Enum) and old.values != new.values[: len(old.values)]:
        return tuple(map(new.values.index, old.values))
    return AS_IT_IS


def _ranks(old: tuple[float, ...], new: tuple[float, ...]) -> tuple[int, ...] | None:
    """Return the list that maps ranks among the old constants to ranks among the new; None if some are not old."""
    if old == new:
        return AS_IT_IS
    if not set(new) <= set(old):
        return None
    below = [sum(cut < edge for cut in new) for edge in old]
    between = [2 * b + (edge in new) for b, edge in zip(below, old, strict=True)]
    after = [2 * sum(cut <= edge for cut in new) for edge in old]
    found = [0]
    for at, behind in zip(between, after, strict=True):
        found += [at, behind]
    return tuple(found)
