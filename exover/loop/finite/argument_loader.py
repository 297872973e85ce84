"""Arguments as the tables load them: the entries that they are written into, and predicates of these."""

from dataclasses import field
from functools import cached_property

from exover.dataclass import dataclass
from exover.loop.finite.tested_bounds import TestedBounds
from exover.model.event import Args
from exover.model.model import Model
from exover.model.types import ordinal
from exover.ocrd.entries import compare
from exover.ocrd.tables import ALWAYS, NONE, OrderRow, Tables
from exover.ocrd.vector import rank


@dataclass
class ArgumentLoader:
    """Loads arguments (and results) of one request; `orders`: the comparisons of these with each other."""

    model: Model
    tables: Tables
    bounds: TestedBounds
    request: int
    orders: tuple[OrderRow, ...]
    _loaded: dict[Args, dict[int, int]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        declared = self.model.requests[self.request]
        self.row, self.params, self.results = self.tables.requests[self.request], declared.params, declared.results

    def loaded(self, values: Args) -> dict[int, int]:
        """Return the entries that arguments (and results) are loaded into, without comparisons with posters.

        The dictionary is cached: callers must not change it.
        """
        if values not in self._loaded:
            self._loaded[values] = self._load(values)
        return self._loaded[values]

    def _load(self, values: Args) -> dict[int, int]:
        found: dict[int, int] = {}
        for number, (parameter, value) in enumerate(zip((*self.params, *self.results), values, strict=False)):
            row = self.tables.params[self.row.params + number]
            if row.rank != NONE:
                found[row.rank] = rank(self.tables.reals[row.cuts : row.cuts_end], float(value))
            if row.value != NONE:
                found[row.value] = ordinal(parameter.type, value)
        for order in self.orders:
            if max(order.left, order.right) < len(values):
                found[order.entry] = compare(float(values[order.left]), float(values[order.right]))
        for total, parts in self._sums:
            if all(part in found for part, _ in parts):
                found[total] = sum(factor * found[part] for part, factor in parts)
        return found

    @cached_property
    def _sums(self) -> list[tuple[int, list[tuple[int, int]]]]:
        """The sums of which some argument or result is a part."""
        rows = self.tables.params[self.row.params : self.row.params_end]
        mine = {entry for row in rows for entry in (row.value, row.rank)}
        mine |= {order.entry for order in self.orders}
        held = [self.tables.entries[entry] for entry in mine - {NONE}]
        totals = {total for entry in held for total, _ in self.tables.sums[entry.sums : entry.sums_end]}
        return [(total, self.bounds.sums[total]) for total in sorted(totals)]

    def agrees(self, predicate: int, entries: dict[int, int]) -> bool:
        """Return whether a predicate is true of loaded entries."""
        if predicate == ALWAYS:
            return True
        while predicate != NONE:
            node = self.tables.nodes[predicate]
            if node.code < 0:
                return True
            predicate = node.low if entries[node.code] <= node.bound else node.high
        return False

    def looked_at(self, predicate: int) -> set[int]:
        """Return the indices of the arguments on which the truth of a predicate depends."""
        tested = self.tables.tested(predicate)
        tested |= {part for entry in tested for part, _ in self.bounds.sums.get(entry, ())}
        compared = {side for order in self.orders if order.entry in tested for side in (order.left, order.right)}
        loading = enumerate(self.tables.params[self.row.params : self.row.params_end][: len(self.params)])
        loaded = {number for number, row in loading if {row.value, row.rank} & tested}
        return loaded | {side for side in compared if 0 <= side < len(self.params)}
