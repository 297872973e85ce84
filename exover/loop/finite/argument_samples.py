"""Samples of arguments and results: at least one of each kind that tests and conditions tell apart.

Reals are sampled at the constants that they are compared with, and between neighbouring constants at as many points as
there are reals that are compared with each other, so that every order of them occurs.
"""

import math
from itertools import product

from exover.dataclass import dataclass
from exover.loop.finite.tested_bounds import TestedBounds, TooLarge, points
from exover.loop.tracked_predicates import TrackedPredicates
from exover.model.event import Args
from exover.model.model import Model, Parameter
from exover.model.types import Real, Value, from_ordinal
from exover.ocrd.tables import NONE, OrderRow, ParamRow, Tables

MOST_SAMPLES = 50_000
"""The greatest number of argument tuples that are sampled for one request."""


@dataclass
class ArgumentSamples:
    """Samples the arguments and the results of one request; `orders`: the comparisons of its reals."""

    model: Model
    tables: Tables
    bounds: TestedBounds
    tracked: TrackedPredicates
    request: int
    orders: tuple[OrderRow, ...]

    def __post_init__(self) -> None:
        declared = self.model.requests[self.request]
        self._name, self._params, self._results = declared.name, declared.params, declared.results
        self._row = self.tables.requests[self.request]

    def of_arguments(self) -> list[Args]:
        """Return samples of the arguments; raises `TooLarge` if there are more than `MOST_SAMPLES`."""
        return self._samples(self._params, 0)

    def of_results(self) -> list[Args]:
        """Return samples of the results, as `of_arguments` does."""
        return self._samples(self._results, len(self._params))

    def cuts(self, number: int) -> tuple[float, ...]:
        """Return the constants that a real parameter or result is compared with, increasing."""
        row = self._param(number)
        name = (*self._params, *self._results)[number].name
        tracked = self.tracked.cuts.get((self._name, name), set())
        return tuple(sorted({*self.tables.reals[row.cuts : row.cuts_end], *tracked}))

    def _param(self, number: int) -> ParamRow:
        return self.tables.params[self._row.params + number]

    def _samples(self, params: tuple[Parameter, ...], first: int) -> list[Args]:
        choices: list[list[Value]] = []
        compared = {side for order in self.orders for side in (order.left, order.right)}
        compared |= {k for k, p in enumerate(params, first) if (self._name, p.name) in self.tracked.compared}
        shared = self._shared_constants(compared)
        for number, parameter in enumerate(params, first):
            if isinstance(parameter.type, Real):
                choices.append(self._real_samples(number, shared if number in compared else None))
            else:
                row, tracked = self._param(number), self.tracked.constants(self._name, parameter.name)
                numbers = self.bounds.samples(
                    f"{self._name}.{parameter.name}", self._entries(number, row), row.low, row.high, tracked
                )
                choices.append([from_ordinal(parameter.type, number) for number in numbers])
        if math.prod(map(len, choices)) > MOST_SAMPLES:
            raise TooLarge(f"`{self._name}` has more than {MOST_SAMPLES} kinds of arguments")
        return list(product(*choices))

    def _entries(self, number: int, row: ParamRow) -> list[int]:
        """Return the entries whose value an integer parameter contributes to: as a loaded argument, and where held."""
        features = self.tables.features[self._row.features : self._row.features_end]
        found = [entry for each in features if each.weight == number for entry in (each.running, each.waiting)]
        return [entry for entry in (row.value, *found) if entry != NONE]

    def _shared_constants(self, compared: set[int]) -> tuple[float, ...]:
        found: set[float] = set()
        for number in compared:
            if number >= 0:
                row = self._param(number)
                found |= {*self.cuts(number)}
                found |= {self.tables.reals[row.low], self.tables.reals[row.high]} - {math.inf, -math.inf}
        return tuple(sorted(found))

    def _real_samples(self, number: int, shared: tuple[float, ...] | None) -> list[Value]:
        row, cuts = self._param(number), self.cuts(number)
        low, high = self.tables.reals[row.low], self.tables.reals[row.high]
        if shared is not None:
            reals = [p for p in (*self._params, *self._results) if isinstance(p.type, Real)]
            return list(points(low, high, shared, len(reals)))
        if not cuts:
            return [low if math.isfinite(low) else min(0.0, high)]
        return list(points(low, high, cuts, 1))
