"""Whether the numbers of tables are what they are taken for: every index leads to a record, and every walk ends.

Checksums tell that bytes are as they were written, not who wrote them. What is read with the tables of a spec is
verified against its model, before anything is walked.
"""

from collections.abc import Callable, Iterator
from itertools import accumulate
from typing import Any

from exover.dataclass import dataclass
from exover.model.model import Model, Request
from exover.model.types import Bool, Enum, Int, Real, Type
from exover.ocrd import tables as t
from exover.ocrd.compile import most_passes
from exover.ocrd.packing import DamagedTable
from exover.ocrd.reasons import reasons
from exover.ocrd.tables import ALWAYS, BLOCK, NONE, Tables
from exover.ocrd.vector import ordinal_range

RANGES = {
    "entries": (("rules", "rules_end", "lists"), ("sums", "sums_end", "sums")),
    "requests": (
        ("params", "results", "params"),
        ("results", "params_end", "params"),
        ("orders", "orders_end", "orders"),
        ("features", "features_end", "features"),
        ("pasts", "pasts_end", "pasts"),
        ("consumes", "produces", "amounts"),
        ("produces", "produces_end", "amounts"),
        ("on_launch", "on_ok", "effects"),
        ("on_ok", "on_failed", "effects"),
        ("on_failed", "on_interrupted", "effects"),
        ("on_interrupted", "effects_end", "effects"),
        ("conflicts", "conflicts_end", "conflicts"),
    ),
    "params": (("cuts", "cuts_end", "reals"),),
    "variables": (
        ("cuts", "cuts_end", "reals"),
        ("refresh", "refresh_end", "lists"),
        ("orders", "orders_end", "orders"),
    ),
    "latches": (("resets", "resets_end", "lists"),),
}
"""By section the pairs of fields that are a range of records, and of which section."""
ENTRY, ROOT, PREDICATE = ("entries", (NONE,)), ("nodes", (NONE,)), ("nodes", (NONE, ALWAYS))
REASON: tuple[str, tuple[int, ...]] = ("reasons", ())
INDICES: dict[str, dict[str, tuple[str, tuple[int, ...]]]] = {
    "requests": {"decide": ("nodes", ()), "last": ENTRY},
    "params": {"value": ENTRY, "rank": ENTRY},
    "orders": {"entry": ENTRY},
    "features": {"predicate": PREDICATE} | dict.fromkeys(("running", "stopping", "waiting", "clearing"), ENTRY),
    "pasts": {"predicate": PREDICATE, "entry": ENTRY},
    "amounts": {"stock": ("stocks", ()), "predicate": PREDICATE},
    "variables": {"value": ENTRY, "rank": ENTRY},
    "latches": {"condition": ROOT},
    "stocks": {"entry": ENTRY},
    "rules": {"root": ROOT, "reason": REASON},
    "launches": {"condition": ROOT, "request": ("requests", ()), "reason": REASON},
    "invariants": {"root": ROOT, "reason": REASON},
}
"""By section and field the section of which it is an index, and what else it may be."""
TYPE_CODES: dict[type, int] = {Bool: t.BOOL, Int: t.INT, Enum: t.ENUM, Real: t.REAL}
"""By kind of types their codes in tables."""


def verify(tables: Tables, model: Model) -> None:
    """Raise `DamagedTable` unless the tables have the shape of the model, and each number is one of those it may be."""
    for section, number in _Structure(tables, model).faults():
        raise DamagedTable(f"record {number} of the section {section} cannot be of this spec")


Fault = tuple[str, int]
"""A section, and the number of a record in it that has a fault."""


@dataclass
class _Structure:
    """Looks for faults, each under the condition that those before it were not found."""

    tables: Tables
    model: Model

    def faults(self) -> Iterator[Fault]:
        """Yield the faults."""
        yield from self._counts()
        for section in RANGES:
            yield from self._each(section, self._has_ranges)
        for section in INDICES:
            yield from self._each(section, self._has_indices)
        yield from ((section, number) for section, number, good in self._records() if not good)

    def _each(self, section: str, is_good: Callable[[str, Any], bool]) -> Iterator[Fault]:
        rows = enumerate(getattr(self.tables, section))
        yield from ((section, number) for number, row in rows if not is_good(section, row))

    def _counts(self) -> Iterator[Fault]:
        """Yield the sections that have not as many records as the model has of what they describe."""
        model = self.model
        wanted = {
            "requests": len(model.requests),
            "variables": len(model.variables) + len(model.latches),
            "latches": len(model.latches),
            "stocks": sum(resource.consumable for resource in model.resources),
            "launches": len(model.launches),
            "reasons": len(reasons(model)),
            "limits": 1,
        }
        for section, count in wanted.items():
            found = len(getattr(self.tables, section))
            if found != count:
                yield section, min(found, count)

    def _has_ranges(self, section: str, row: Any) -> bool:
        return all(
            0 <= getattr(row, first) <= getattr(row, end) <= len(getattr(self.tables, of))
            for first, end, of in RANGES[section]
        )

    def _has_indices(self, section: str, row: Any) -> bool:
        return all(
            getattr(row, name) in others or 0 <= getattr(row, name) < len(getattr(self.tables, of))
            for name, (of, others) in INDICES[section].items()
        )

    def _records(self) -> Iterator[tuple[str, int, bool]]:
        """Yield section, number and whether the record is good, for what one section tells of another."""
        tables, model = self.tables, self.model
        yield from (("nodes", number, self._is_node(number)) for number in range(len(tables.nodes)))
        yield from (("entries", number, self._is_entry(row)) for number, row in enumerate(tables.entries))
        starts = accumulate((request.instances for request in model.requests), initial=0)
        for number, (request, start) in enumerate(zip(model.requests, starts, strict=False)):
            yield "requests", number, tables.requests[number].slots == start and self._is_request(number, request)
        for number, variable in enumerate(model.variables):
            yield "variables", number, self._is_variable(number, variable.type)
        for number in range(len(model.latches)):
            at = len(model.variables) + number
            yield "variables", at, self._is_variable(at, Bool())
            row = tables.latches[number]
            yield "latches", number, row.variable == at and self._names_requests(row.resets, row.resets_end)
        for number, effect in enumerate(tables.effects):
            yield "effects", number, self._is_effect(effect)
        for number, launch in enumerate(model.launches):
            found = tables.launches[number]
            asked = model.requests[found.request].name == launch.request
            yield "launches", number, asked and 0 <= found.args <= len(tables.lists) - len(launch.args)
        yield "limits", 0, tables.limits[0].passes == most_passes(model)

    def _is_node(self, number: int) -> bool:
        """Return whether a node tests an entry or does an action, and its children follow it."""
        node, size = self.tables.nodes[number], len(self.tables.nodes)
        after = [node.low] if node.code < 0 else [node.low, node.high]
        if not all(child == NONE or number < child < size for child in after):
            return False
        if node.code >= 0:
            return node.code < len(self.tables.entries)
        slots, requests = sum(request.instances for request in self.model.requests), len(self.model.requests)
        least = {t.KILL: -slots, t.DISMISS: 0}.get(-node.code)
        good = -node.code in range(t.REJECT, t.AGREE + 1) and 0 <= node.bound < len(self.tables.reasons)
        return good and (least is None or least <= node.high < requests)

    def _is_entry(self, row: t.Entry) -> bool:
        """Return whether an entry is read by rules, and part of sums that are parts of nothing."""
        entries = self.tables.entries
        sums = [other for other, _ in self.tables.sums[row.sums : row.sums_end]]
        rules = self.tables.lists[row.rules : row.rules_end]
        return all(0 <= rule < len(self.tables.rules) for rule in rules) and all(
            0 <= other < len(entries) and entries[other].sums == entries[other].sums_end for other in sums
        )

    def _is_request(self, number: int, request: Request) -> bool:
        row, tables = self.tables.requests[number], self.tables
        types = [each.type for each in (*request.params, *request.results)]
        params = tables.params[row.params : row.params_end]
        shape = (row.instances, row.interrupts_self, row.statuses, row.results - row.params)
        if shape != (request.instances, int(request.interrupts_self), len(request.statuses), len(request.params)):
            return False
        if [param.type for param in params] != [TYPE_CODES[type(kind)] for kind in types]:
            return False
        features = tables.features[row.features : row.features_end]
        orders = tables.orders[row.orders : row.orders_end]
        blocks = tables.conflicts[row.conflicts : row.conflicts_end]
        return (
            self._always_acts(row.decide)
            and all(self._is_feature(each, request) for each in features)
            and all(self._is_side(side, types) for order in orders for side in (order.left, order.right))
            and all(0 <= each.block <= len(tables.requests) // BLOCK for each in blocks)
            and all(other < len(tables.requests) for other in tables.conflicting(number))
        )

    def _always_acts(self, root: int) -> bool:
        """Return whether every path of a decision does something."""
        stack, seen = [root], set[int]()
        while stack:
            number = stack.pop()
            if number == NONE:
                return False
            if number not in seen:
                seen.add(number)
                node = self.tables.nodes[number]
                stack += [] if node.code < 0 else [node.low, node.high]
        return True

    def _is_feature(self, row: t.FeatureRow, request: Request) -> bool:
        weighed = row.weight == NONE or (
            0 <= row.weight < len(request.params) and isinstance(request.params[row.weight].type, Int)
        )
        return weighed and (row.slot == NONE or 0 <= row.slot < request.instances)

    def _is_side(self, side: int, types: list[Type]) -> bool:
        """Return whether a side of a comparison is a real: of these parameters, or of a poster whose value is kept."""
        if side >= 0:
            return side < len(types) and isinstance(types[side], Real)
        at = -1 - side
        return at < len(self.tables.variables) and self.tables.variables[at].raw != NONE

    def _is_variable(self, number: int, kind: Type) -> bool:
        row, tables = self.tables.variables[number], self.tables
        orders = tables.orders[row.orders : row.orders_end]
        sides = all(self._is_side(side, []) for order in orders for side in (order.left, order.right))
        if row.type != TYPE_CODES[type(kind)] or not sides or not self._names_requests(row.refresh, row.refresh_end):
            return False
        if isinstance(kind, Real):
            return all(0 <= each < len(tables.reals) for each in (row.low, row.high, row.initial, row.fallback))
        low, high = ordinal_range(kind)
        return row.raw == NONE and (row.low, row.high) == (low, high) and low <= row.initial <= high

    def _names_requests(self, start: int, end: int) -> bool:
        return all(0 <= request < len(self.tables.requests) for request in self.tables.lists[start:end])

    def _is_effect(self, row: t.EffectRow) -> bool:
        if row.kind == t.FORGET:
            return 0 <= row.target < len(self.model.requests)
        if row.kind != t.SET or not 0 <= row.target < len(self.model.variables):
            return False
        kind = self.model.variables[row.target].type
        if isinstance(kind, Real):
            return False
        low, high = ordinal_range(kind)
        return low <= row.value <= high
