"""The state vector: the small integers that diagrams may test (docs/architecture.md).

A *quantity* is one integer that the machine keeps: a reading, a flag, a counter of slots, the rank of a real among the
constants that it is compared with. An *element* is a linear form of quantities without constant; the only kind of test
is `v[i] <= k` on an element.
"""

from bisect import bisect_left
from functools import cached_property
from typing import Literal, assert_never

from exover.dataclass import dataclass
from exover.model.conditions import comparisons, conditions
from exover.model.expression import (
    Compare,
    Cond,
    Const,
    Count,
    Outcome,
    Param,
    Reading,
    Used,
    atoms,
    leaves,
)
from exover.model.model import Model
from exover.model.types import Bool, Enum, Int, Real, Type

OUTCOMES: tuple[Outcome, ...] = ("none", "ok", "failed", "interrupted")
LEFT, SAME, RIGHT = 0, 1, 2
"""The values of an `Order`: left is less, they are equal, right is less."""


@dataclass(frozen=True, slots=True)
class VariableValue:
    """The ordinal of a bool, int or enum poster, state or latch."""

    name: str


@dataclass(frozen=True, slots=True)
class Rank:
    """The rank of a real poster among the constants that it is compared with."""

    name: str


@dataclass(frozen=True, slots=True)
class Stock:
    """The level of a consumable resource."""

    resource: str


@dataclass(frozen=True, slots=True)
class HasPast:
    """1 iff the request has a past whose values satisfy `where`."""

    request: str
    where: Cond | None


@dataclass(frozen=True, slots=True)
class LastOutcome:
    """The index in `OUTCOMES` of the outcome of the last instance."""

    request: str


@dataclass(frozen=True, slots=True)
class Slots:
    """The number of slots of the request (or of slot `slot` only) in `phase` whose arguments satisfy `where`."""

    request: str
    slot: int | None
    where: Cond | None
    phase: Literal["running", "stopping"]


@dataclass(frozen=True, slots=True)
class SlotValue:
    """The ordinal of an argument in a slot that is not idle; 0 for an idle one."""

    request: str
    slot: int
    param: str


@dataclass(frozen=True, slots=True)
class InPlace:
    """1 iff the waiting place is in `phase` and its arguments satisfy `where`."""

    request: str
    where: Cond | None
    phase: Literal["waiting", "clearing"]


@dataclass(frozen=True, slots=True)
class PlaceValue:
    """The ordinal of an argument in the waiting place of the request; 0 for an empty one."""

    request: str
    param: str


@dataclass(frozen=True, slots=True)
class Arg:
    """The ordinal of an argument or result of the request whose arguments are loaded."""

    request: str
    param: str


@dataclass(frozen=True, slots=True)
class ArgRank:
    """The rank of a real argument or result of the request whose arguments are loaded."""

    request: str
    param: str


@dataclass(frozen=True, slots=True)
class Order:
    """How two reals compare: `LEFT`, `SAME` or `RIGHT`.

    A side is a parameter of `request`, whose arguments are loaded, or a poster; `request` is None if both are posters.
    """

    request: str | None
    left: Param | Reading
    right: Param | Reading


Quantity = (
    VariableValue
    | Rank
    | Stock
    | HasPast
    | LastOutcome
    | Slots
    | SlotValue
    | InPlace
    | PlaceValue
    | Arg
    | ArgRank
    | Order
)
Element = tuple[tuple[int, Quantity], ...]
"""`sum(factor * quantity)`; factors without common divisor, the first positive, quantities distinct and sorted."""


Weights = dict[str, list[tuple[Cond | None, int]]]
"""For each request, conditions and amounts: a slot whose arguments satisfy a condition counts for its amount."""


@dataclass(frozen=True)
class Vocabulary:
    """What a model says of its quantities: their ranges, and the constants that reals are compared with."""

    model: Model

    @cached_property
    def thresholds(self) -> dict[tuple[str | None, str], tuple[float, ...]]:
        """The constants that a real is compared with, increasing, by (request, parameter) or (None, poster)."""
        found: dict[tuple[str | None, str], set[float]] = {}
        for request, cond in conditions(self.model):
            for subject, compare in comparisons(cond, request):
                for side, other in ((compare.left, compare.right), (compare.right, compare.left)):
                    if isinstance(other, Const) and isinstance(other.value, float):
                        match side:
                            case Param(name):
                                found.setdefault((subject, name), set()).add(other.value)
                            case Reading(name):
                                found.setdefault((None, name), set()).add(other.value)
                            case _:
                                pass
        return {key: tuple(sorted(values)) for key, values in found.items()}

    @cached_property
    def parameter_types(self) -> dict[tuple[str, str], Type]:
        """The types of parameters and results by (request, name)."""
        return {(r.name, p.name): p.type for r in self.model.requests for p in (*r.params, *r.results)}

    @cached_property
    def shares(self) -> dict[str, Weights]:
        """The conditions and amounts of `uses` clauses, by resource and request."""
        found: dict[str, Weights] = {resource.name: {} for resource in self.model.resources}
        for request in self.model.requests:
            for share in request.shares:
                found[share.resource].setdefault(request.name, []).append((share.when, share.amount))
        return found

    def counted(self, term: Used | Count) -> Weights:
        """Return the amounts for which active slots count in a term."""
        return self.shares[term.resource] if isinstance(term, Used) else {name: [(None, 1)] for name in term.requests}

    def reading_type(self, name: str) -> Type:
        """Return the type of a poster, state or latch."""
        variable = self.model.variable.get(name)
        return variable.type if variable else Bool()

    def pure(self, cond: Cond) -> bool:
        """Return whether each atom of a condition compares arguments of its subject, with constants or real posters."""
        for atom in atoms(cond):
            if not isinstance(atom, Compare):
                return False
            terms = [*leaves(atom.left), *leaves(atom.right)]
            if not any(isinstance(term, Param) for term in terms):
                return False
            for term in terms:
                real = isinstance(term, Reading) and isinstance(self.reading_type(term.name), Real)
                if not (real or isinstance(term, Const | Param)):
                    return False
        return True

    def range(self, quantity: Quantity) -> tuple[int, int]:
        """Return the least and the greatest value that a quantity can have."""
        match quantity:
            case VariableValue(name):
                return ordinal_range(self.reading_type(name))
            case Rank(name):
                return self._ranks((None, name), self.reading_type(name))
            case Stock(resource):
                return 0, self.model.resource[resource].capacity
            case HasPast() | InPlace():
                return 0, 1
            case LastOutcome():
                return 0, len(OUTCOMES) - 1
            case Slots(request, slot):
                return 0, self.model.request[request].instances if slot is None else 1
            case SlotValue(request, _, param) | PlaceValue(request, param):
                low, high = ordinal_range(self.parameter_types[request, param])
                return min(0, low), max(0, high)
            case Arg(request, param):
                return ordinal_range(self.parameter_types[request, param])
            case ArgRank(request, param):
                return self._ranks((request, param), self.parameter_types[request, param])
            case Order():
                return LEFT, RIGHT
            case _:
                assert_never(quantity)

    def _ranks(self, key: tuple[str | None, str], kind: Type) -> tuple[int, int]:
        assert isinstance(kind, Real)
        thresholds = self.thresholds.get(key, ())
        return rank(thresholds, kind.low), rank(thresholds, kind.high)


def rank(thresholds: tuple[float, ...], value: float) -> int:
    """Return `2 * (number of thresholds below value)`, one more if the value is a threshold itself."""
    below = bisect_left(thresholds, value)
    return 2 * below + (below < len(thresholds) and thresholds[below] == value)


def ordinal_range(kind: Type) -> tuple[int, int]:
    """Return the least and the greatest ordinal of a type."""
    match kind:
        case Bool():
            return 0, 1
        case Int(low, high):
            return low, high
        case Enum(values):
            return 0, len(values) - 1
        case Real():
            raise TypeError("a real has ranks, not ordinals")
        case _:
            assert_never(kind)
