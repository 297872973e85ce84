"""Range allocation for reals: finitely many values that stand for all, by the comparisons that there are.

Which reals of a spec are compared with each other, and with which constants, decides how many positions between two
constants they need (Pnueli, Rodeh, Strichman, Siegel 1999).
"""

from collections.abc import Callable
from dataclasses import field
from fractions import Fraction

from exover.dataclass import dataclass
from exover.engines.aig.circuit.words import Grid
from exover.loop.tracked_predicates import TrackedPredicates, tracked_predicates
from exover.model.model import Model
from exover.model.property import Properties
from exover.model.types import Real, Value, finite_ends, resting_value
from exover.ocrd.compile import Compiled
from exover.ocrd.tables import Tables

Family = tuple[str | None, str]
"""A request and its parameter or result, or None and a poster: reals that take the same values."""


@dataclass
class RangeAllocation:
    """By family of reals the grid of those that it is compared with.

    `holders`: by family how many values of it there can be at once in a state, and with an event.
    """

    model: Model
    tables: Tables
    tracked: TrackedPredicates
    compared: dict[Family, Family] = field(default_factory=dict)
    """Union-find: by family another one that it is compared with, itself if it is the first of these."""
    _constants: dict[Family, set[Fraction]] = field(default_factory=dict)
    _holders: dict[Family, int] = field(default_factory=dict)
    _ordered: set[Family] = field(default_factory=set)

    def __post_init__(self) -> None:
        for request, row in zip(self.model.requests, self.tables.requests, strict=True):
            for number, parameter in enumerate((*request.params, *request.results)):
                if isinstance(parameter.type, Real):
                    cuts = self.tables.params[row.params + number]
                    held = request.instances + 3 if number < len(request.params) else 2
                    self._add((request.name, parameter.name), parameter.type, cuts.cuts, cuts.cuts_end, held)
        for number, variable in enumerate(self.model.variables):
            if isinstance(variable.type, Real):
                cut = self.tables.variables[number]
                self._add((None, variable.name), variable.type, cut.cuts, cut.cuts_end, 2)
                given = (variable.initial, variable.fallback)
                self._constants[None, variable.name] |= {fraction(v) for v in given if v is not None}
        for family, tracked_cuts in self.tracked.cuts.items():
            self._constants[family] |= {Fraction(cut) for cut in tracked_cuts}
        for launch in self.model.launches:
            params = self.model.request[launch.request].params
            for parameter, value in zip(params, launch.args, strict=True):
                if isinstance(parameter.type, Real):
                    self._constants[launch.request, parameter.name].add(fraction(value))
        self._compare()

    def _add(self, family: Family, kind: Real, first: int, end: int, holders: int) -> None:
        cuts = (*finite_ends(kind), resting_value(kind), *self.tables.reals[first:end])
        self._constants[family] = set(map(fraction, cuts))
        self._holders[family] = holders
        self.compared[family] = family

    def _compare(self) -> None:
        for request, row in zip(self.model.requests, self.tables.requests, strict=True):
            names = [p.name for p in (*request.params, *request.results)]
            for order in self.tables.orders[row.orders : row.orders_end]:
                left, right = (
                    (request.name, names[side]) if side >= 0 else (None, self.model.variables[-1 - side].name)
                    for side in (order.left, order.right)
                )
                self._join(left, right)
        for each in self.tables.variables:
            for order in self.tables.orders[each.orders : each.orders_end]:
                self._join(*((None, self.model.variables[-1 - side].name) for side in (order.left, order.right)))
        for request_name, parameter, poster in self.tracked.orders:
            self._join((request_name, parameter), (None, poster))
        for one, other in self.tracked.pairs:
            self._join((None, one), (None, other))
        for request_name in {name for name, _ in self.tracked.compared}:
            mine = [family for family in sorted(self.tracked.compared) if family[0] == request_name]
            for other_parameter in mine[1:]:
                self._join(mine[0], other_parameter)

    def absorb(self, other: "RangeAllocation", called: Callable[[Family], Family]) -> None:
        """Add the constants and comparisons of another allocation; `called`: what its families are called here."""
        for family, constants in other._constants.items():
            mine = called(family)
            self._constants.setdefault(mine, set()).update(constants)
            self._holders[mine] = self._holders.get(mine, 0) + other._holders[family]
            self.compared.setdefault(mine, mine)
        for family, another in other.compared.items():
            if self.first(called(family)) != self.first(called(another)):
                self._join(called(family), called(another))
        self._ordered |= {called(family) for family in other._ordered}

    def first(self, family: Family) -> Family:
        """Return the first of the families that a family is compared with."""
        while self.compared[family] != family:
            family = self.compared[family]
        return family

    def _join(self, one: Family, other: Family) -> None:
        self.compared[self.first(one)] = self.first(other)
        self._ordered |= {one, other}

    def ordered(self, family: Family) -> bool:
        """Return whether a real is compared with other reals that change."""
        return any(self.first(each) == self.first(family) for each in self._ordered)

    def grid(self, family: Family) -> Grid:
        """Return the grid of a family."""
        alike = [each for each in self.compared if self.first(each) == self.first(family)]
        constants = {constant for each in alike for constant in self._constants[each]}
        holders = sum(self._holders[each] for each in alike)
        return Grid(tuple(sorted(constants)), (holders - 1).bit_length() if self.ordered(family) else 0)


def allocate_ranges(compiled: Compiled, properties: Properties) -> RangeAllocation:
    """Return the grids of a spec and of what its properties ask."""
    return RangeAllocation(compiled.model, compiled.tables, tracked_predicates(compiled.model, properties))


def fraction(value: Value) -> Fraction:
    """Return the double that a number is, as a fraction."""
    assert not isinstance(value, str)
    return Fraction(float(value))
