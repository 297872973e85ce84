"""The memory of a running checker: the state vector, the slots and waiting places, the reals that must be kept.

Its operations do what those of the C runtime do (docs/runtime.md); `exover.ocrd.machine` calls them.
"""

from dataclasses import field

from exover.dataclass import dataclass
from exover.model.decision import Reason
from exover.model.event import Action, Args
from exover.model.index import ModelIndex
from exover.model.model import Model
from exover.model.types import Value, ordinal
from exover.ocrd import tables as t
from exover.ocrd.entries import compare
from exover.ocrd.reasons import reasons
from exover.ocrd.tables import NONE, Node, Tables
from exover.ocrd.vector import rank

IDLE, RUNNING, STOPPING = range(3)
EMPTY, WAITING, CLEARING = range(3)
SLOT_COUNTERS = {RUNNING: "running", STOPPING: "stopping"}
"""By phase of a slot the column of a feature that names the entry which counts it."""
PLACE_COUNTERS = {WAITING: "waiting", CLEARING: "clearing"}
"""The same by phase of a waiting place."""


@dataclass
class Memory:
    """The state vector, the contents of slots and waiting places, and what is remembered within a step."""

    model: Model
    tables: Tables
    vector: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.reasons = reasons(self.model)
        index = ModelIndex(self.model)
        self.index, self.variable, self.stock = index.request, index.reading, index.stock
        self.types = tuple(kind for _, kind in index.typed_readings)
        self.slots = sum(request.instances for request in self.tables.requests)
        self.initial = [entry.initial for entry in self.tables.entries]
        self.conflicts = [self.tables.conflicting(request) for request in range(len(self.tables.requests))]
        self.restart()

    def restart(self) -> None:
        """Go back to the initial state."""
        tables = self.tables
        self.vector = list(self.initial)
        self.phase = [IDLE] * self.slots
        self.held = [0] * len(tables.requests)
        self.slot_args: list[Args] = [()] * self.slots
        self.place = [EMPTY] * len(tables.requests)
        self.place_args: list[Args] = [()] * len(tables.requests)
        self.place_rule: list[Reason | None] = [None] * len(tables.requests)
        self.refused: list[int | None] = [None] * len(tables.launches)
        self.raw = {v.raw: tables.reals[v.initial] for v in tables.variables if v.raw != NONE}
        self.broken = [False] * len(tables.rules)
        self.dirty = [True] * len(tables.rules)
        self.actions: list[Action] = []
        self.changed = False

    # ---- the vector ----

    def add(self, entry: int, delta: int) -> None:
        """Add to an entry, and to the sums that it is part of; mark the rules that read them. NONE is no entry."""
        if entry == NONE or not delta:
            return
        row = self.tables.entries[entry]
        self.vector[entry] += delta
        for rule in self.tables.lists[row.rules : row.rules_end]:
            self.dirty[rule] = True
        for other, factor in self.tables.sums[row.sums : row.sums_end]:
            self.add(other, factor * delta)

    def put(self, entry: int, value: int) -> None:
        """Give an entry a value, as `add` does."""
        if entry != NONE:
            self.add(entry, value - self.vector[entry])

    def walk(self, node: int) -> list[Node]:
        """Return the action nodes on the path from `node` that the state vector selects."""
        found = []
        while node != NONE:
            here = self.tables.nodes[node]
            if here.code < 0:
                found.append(here)
                node = here.low
            else:
                node = here.low if self.vector[here.code] <= here.bound else here.high
        return found

    def agrees(self, predicate: int) -> bool:
        """Return whether a predicate is true of the vector: it is `ALWAYS`, or its diagram leads to an action."""
        return predicate == t.ALWAYS or bool(self.walk(predicate))

    # ---- arguments ----

    def load(self, request: int, values: Args) -> None:
        """Store arguments, and results if there are any, in the entries through which nodes test them."""
        row = self.tables.requests[request]
        for number, value in enumerate(values):
            param = self.tables.params[row.params + number]
            if param.type == t.REAL:
                self.put(param.rank, rank(self.tables.reals[param.cuts : param.cuts_end], float(value)))
            else:
                self.put(param.value, self._number(request, number, value))
        for order in self.tables.orders[row.orders : row.orders_end]:
            if order.left < len(values) and order.right < len(values):
                self.put(order.entry, compare(self._side(order.left, values), self._side(order.right, values)))

    def _number(self, request: int, number: int, value: Value) -> int:
        params = (*self.model.requests[request].params, *self.model.requests[request].results)
        return ordinal(params[number].type, value)

    def _side(self, side: int, values: Args) -> float:
        return float(values[side]) if side >= 0 else self.raw[self.tables.variables[-1 - side].raw]

    def _count(self, request: int, args: Args, slot: int, phase: str, sign: int) -> None:
        """Add a slot or waiting place with these arguments to the counters of its request, or, sign -1, remove it."""
        row = self.tables.requests[request]
        features = self.tables.features[row.features : row.features_end]
        if any(feature.predicate != t.ALWAYS or feature.weight != NONE for feature in features):
            self.load(request, args)
        for feature in features:
            if feature.slot in (NONE, slot) and self.agrees(feature.predicate):
                weight = 1 if feature.weight == NONE else self._number(request, feature.weight, args[feature.weight])
                self.add(getattr(feature, phase), sign * weight)

    def set_slot(self, request: int, slot: int, phase: int, args: Args) -> None:
        """Give a slot a phase and arguments, and count it in the entries of its request as it is now."""
        number = self.tables.requests[request].slots + slot
        if self.phase[number] != IDLE:
            self._count(request, self.slot_args[number], slot, SLOT_COUNTERS[self.phase[number]], -1)
        self.phase[number], self.slot_args[number] = phase, args
        if phase != IDLE:
            self._count(request, args, slot, SLOT_COUNTERS[phase], 1)
        self.changed = True

    def set_place(self, request: int, phase: int, args: Args) -> None:
        """Give a waiting place a phase and arguments, and count it as `set_slot` does; nothing if it has them."""
        if self.place[request] == phase and self.place_args[request] == args:
            return
        if self.place[request] != EMPTY:
            self._count(request, self.place_args[request], NONE, PLACE_COUNTERS[self.place[request]], -1)
        self.place[request], self.place_args[request] = phase, args
        if phase != EMPTY:
            self._count(request, args, NONE, PLACE_COUNTERS[phase], 1)
        self.changed = True

    def read(self, variable: int, value: Value) -> None:
        """Give a poster, state or latch this value, and update the counters that depend on it."""
        row = self.tables.variables[variable]
        held = [
            (request, slot, SLOT_COUNTERS[self.phase[number]], self.slot_args[number])
            for request in self.tables.lists[row.refresh : row.refresh_end]
            for slot in range(self.tables.requests[request].instances)
            if self.phase[number := self.tables.requests[request].slots + slot] != IDLE
        ]
        for request, slot, phase, args in held:
            self._count(request, args, slot, phase, -1)
        if row.type == t.REAL:
            self.put(row.rank, rank(self.tables.reals[row.cuts : row.cuts_end], float(value)))
            if row.raw != NONE:
                self.raw[row.raw] = float(value)
        else:
            self.put(row.value, ordinal(self.types[variable], value))
        for order in self.tables.orders[row.orders : row.orders_end]:
            self.put(order.entry, compare(self._side(order.left, ()), self._side(order.right, ())))
        for request, slot, phase, args in held:
            self._count(request, args, slot, phase, 1)
