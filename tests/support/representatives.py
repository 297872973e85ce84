"""Finitely many values and states that stand for all: what a spec cannot tell apart is one.

Nothing here is shared with the engines but the model. A real that is compared with constants alone counts by where it
lies among these. Reals that are compared with each other count by their order too: in every gap between constants the
values that the state holds are spread evenly, and a new one may come to lie between any two of them, so the order of
the finitely many representatives is as dense as that of the reals.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise, product
from typing import assert_never

from exover.model.event import Args
from exover.model.expression import And, Compare, Cond, Const, Last, Not, Or, Own, Param, Past, Reading, Status, leaves
from exover.model.model import Consumption, Model, Parameter, Share
from exover.model.state import Slot, State
from exover.model.types import Bool, Enum, Int, Real, Type, Value

Key = tuple[str | None, str]
"""A parameter or result by its request and name, a poster by None and its name."""
MOST = 40
"""Values of one int that are tried at most; a spec with more is too large."""


class TooLarge(Exception):
    """The spec has more values or states than can be counted here."""


@dataclass
class Reads:
    """What the conditions of a model read, collected by walking them."""

    args: set[Key] = field(default_factory=set)
    """Parameters of slots, waiting places and newcomers, and posters."""
    past: set[Key] = field(default_factory=set)
    """Parameters and results of pasts."""
    pasts: set[str] = field(default_factory=set)
    lasts: set[str] = field(default_factory=set)
    cuts: dict[Key, set[float]] = field(default_factory=dict)
    """The constants that a real is compared with."""
    paired: set[Key] = field(default_factory=set)
    """The reals that are compared with other reals."""

    def walk(self, cond: Cond, subject: str | None, own: str | None = None, past: bool = False) -> None:
        """Note what a condition on `subject` reads; `own`: the request that `self` means."""
        match cond:
            case Compare():
                self._compare(cond, subject, own, past)
            case Status(_, name, where):
                if where is not None:
                    self.walk(where, name, subject)
            case Past(name, where):
                self.pasts.add(name)
                if where is not None:
                    self.walk(where, name, subject, past=True)
            case Last(name, _):
                self.lasts.add(name)
            case Not(part):
                self.walk(part, subject, own, past)
            case And(parts) | Or(parts):
                for part in parts:
                    self.walk(part, subject, own, past)
            case _:
                assert_never(cond)

    def _compare(self, compare: Compare, subject: str | None, own: str | None, past: bool) -> None:
        keys: list[Key] = []
        for term in (*leaves(compare.left), *leaves(compare.right)):
            match term:
                case Param(name):
                    keys.append((subject, name))
                    (self.past if past else self.args).add(keys[-1])
                case Own(name):
                    self.args.add((own, name))
                case Reading(name):
                    keys.append((None, name))
                    self.args.add(keys[-1])
                case _:
                    pass
        for side in (compare.left, compare.right):
            if isinstance(side, Const) and isinstance(side.value, float):
                self.cuts.setdefault(keys[0], set()).add(side.value)
        if len(keys) == 2:
            self.paired.update(keys)  # of ints too, where it means nothing


def reads_of(model: Model) -> Reads:
    """Return what all conditions of a model read; a launch rule reads the arguments of its request."""
    found = Reads()
    for request in model.requests:
        for guard in request.guards:
            found.walk(guard.condition, request.name)
        clauses: tuple[Share | Consumption, ...] = (*request.shares, *request.consumptions, *request.productions)
        for clause in clauses:
            if clause.when is not None:
                found.walk(clause.when, request.name)
    for rule in model.rules:
        found.walk(rule.condition, rule.slot_of)
    for latch in model.latches:
        found.walk(latch.condition, None)
    for launch in model.launches:
        found.walk(launch.condition, None)
        for parameter, value in zip(model.request[launch.request].params, launch.args, strict=True):
            found.args.add((launch.request, parameter.name))
            if isinstance(value, float):
                found.cuts.setdefault((launch.request, parameter.name), set()).add(value)
    return found


class Representatives:
    """The values to try and the states to remember, for one model."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.reads = reads_of(model)
        self.types: dict[Key, Type] = {(None, variable.name): variable.type for variable in model.variables}
        for request in model.requests:
            self.types |= {(request.name, each.name): each.type for each in (*request.params, *request.results)}
        self.paired = {key for key in self.reads.paired if isinstance(self.types.get(key), Real)}
        shared = {cut for key in self.paired for cut in self.reads.cuts.get(key, set())}
        for key in self.paired:
            kind = self.types[key]
            assert isinstance(kind, Real)
            shared |= {end for end in (kind.low, kind.high) if abs(end) != math.inf}
        self.shared = sorted(shared)

    # ---- values ----

    def arguments(self, state: State, request: str, parameters: tuple[Parameter, ...]) -> Iterator[Args]:
        """Yield the arguments (or results) to try in a state."""
        keys = [(request, parameter.name) for parameter in parameters]
        together = max(1, sum(key in self.paired for key in keys))
        return product(*(self.values(state, key, together) for key in keys))

    def values(self, state: State, key: Key, together: int = 1) -> list[Value]:
        """Return the values to try; `together`: how many reals that may be compared are chosen at once."""
        kind = self.types[key]
        if key not in self.reads.args | self.reads.past:
            return [_any(kind)]
        match kind:
            case Bool():
                return [False, True]
            case Enum(names):
                return list(names)
            case Int(low, high):
                if high - low >= MOST:
                    raise TooLarge("an int has too many values")
                return list(range(low, high + 1))
            case Real(low, high):
                if key in self.paired:
                    return list(_points({*self.shared, *self._live(state)}, kind, together))
                return list(_points(self.reads.cuts.get(key, set()), kind, 1))
            case _:
                assert_never(kind)

    # ---- states ----

    def canonical(self, state: State) -> State:
        """Return the state that stands for this one and for all that the spec cannot tell from it."""
        past = {name: self._past(name, values) for name, values in state.past.items()}
        last = {name: ending if name in self.reads.lasts else "none" for name, ending in state.last.items()}
        state = replace(state, past=past, last=last)
        moved = self._spread(self._live(state))
        slots = {
            name: tuple(slot and Slot(slot.phase, self._moved(name, slot.args, moved)) for slot in slots)
            for name, slots in state.slots.items()
        }
        places = {
            name: place and replace(place, args=self._moved(name, place.args, moved))
            for name, place in state.places.items()
        }
        past = {name: values and self._moved(name, values, moved) for name, values in past.items()}
        readings = {name: self._one(None, name, value, moved) for name, value in state.readings.items()}
        return replace(state, slots=slots, places=places, past=past, readings=readings)

    def _past(self, name: str, values: Args | None) -> Args | None:
        if values is None or name not in self.reads.pasts:
            return None
        fields = zip(self._fields(name), values, strict=True)
        return tuple(v if (name, each.name) in self.reads.past else _any(each.type) for each, v in fields)

    def _fields(self, request: str) -> tuple[Parameter, ...]:
        return (*self.model.request[request].params, *self.model.request[request].results)

    def _live(self, state: State) -> set[float]:
        """Return the reals of a state that may be compared with others."""
        found: set[float] = set()
        for name in self.model.request:
            place, past = state.places[name], state.past[name]
            held = [slot.args for slot in state.slots[name] if slot]
            held += [place.args] if place else []
            held += [past] if past is not None else []
            for args in held:
                pairs = zip(self._fields(name), args, strict=False)
                found |= {float(value) for each, value in pairs if (name, each.name) in self.paired}
        return found | {float(state.readings[name]) for request, name in self.paired if request is None}

    def _spread(self, live: set[float]) -> dict[float, float]:
        """Return by value the one that stands for it: those in one gap are spread evenly, in their order."""
        moved = {cut: cut for cut in self.shared}
        for low, high in _gaps(self.shared):
            inside = sorted(value for value in live if low < value < high)
            first, last = _ends(low, high)
            for index, value in enumerate(inside, 1):
                moved[value] = first + (last - first) * index / (len(inside) + 1)
        return moved

    def _moved(self, name: str, values: Args, moved: dict[float, float]) -> Args:
        return tuple(
            self._one(name, each.name, value, moved) for each, value in zip(self._fields(name), values, strict=False)
        )

    def _one(self, request: str | None, name: str, value: Value, moved: dict[float, float]) -> Value:
        if not isinstance(value, float):
            return value
        key = (request, name)
        if key in self.paired:
            return moved[value]
        kind = self.types[key]
        cuts = self.reads.cuts.get(key, set())
        assert isinstance(kind, Real)
        return next(point for point in _points(cuts, kind, 1) if _same_side(point, value, cuts))


def _any(kind: Type) -> Value:
    """Return some value of a type: the one that stands for all where nobody looks."""
    match kind:
        case Bool():
            return False
        case Int(low, _):
            return low
        case Enum(names):
            return names[0]
        case Real():
            return next(_points(set(), kind, 1))
        case _:
            assert_never(kind)


def _same_side(first: float, second: float, cuts: Iterable[float]) -> bool:
    return all((first < cut, first == cut) == (second < cut, second == cut) for cut in cuts)


def _gaps(cuts: Iterable[float]) -> list[tuple[float, float]]:
    """Return the open intervals between neighbouring cuts, and those below and above all."""
    return list(pairwise([-math.inf, *sorted(cuts), math.inf]))


def _ends(low: float, high: float) -> tuple[float, float]:
    """Return finite ends of a gap."""
    if low == -math.inf:
        return (high - 1, high) if high != math.inf else (0.0, 1.0)
    return (low, high) if high != math.inf else (low, low + 1)


def _points(cuts: set[float], kind: Real, together: int) -> Iterator[float]:
    """Yield the cuts of a range, and so many values in each gap between them; they are in the range."""
    for below, above in _gaps(cuts):
        low, high = max(below, kind.low), min(above, kind.high)
        if low < high:
            first, last = _ends(low, high)
            for index in range(1, together + 1):
                yield first + (last - first) * index / (together + 1)
        elif low == high and low not in cuts:
            yield low
    yield from (cut for cut in sorted(cuts) if kind.low <= cut <= kind.high)
