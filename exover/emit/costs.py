"""What single events cost by themselves, and what they may change: walks by their longest path, read from the tables.

Quantities are numbered: the entries of the state vector, then the slots of every request, then the waiting places.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

from exover.ocrd import tables as t
from exover.ocrd.tables import NONE, RequestRow, Tables


@dataclass(slots=True)
class Doing:
    """What an event does itself, before any pass: tests, answers, and the quantities that it may change."""

    tests: int = 0
    answers: int = 1
    """At least one: the event may be invalid."""
    writes: set[int] = field(default_factory=set)


@dataclass
class Costs:
    """What single walks and updates cost, and what they write."""

    tables: Tables

    @cached_property
    def tests(self) -> list[int]:
        """The most tests on a path from each node; the last element is that of the end of a path."""
        found = [0] * (len(self.tables.nodes) + 1)
        for index in range(len(self.tables.nodes) - 1, -1, -1):
            node = self.tables.nodes[index]
            found[index] = found[node.low] if node.code < 0 else 1 + max(found[node.low], found[node.high])
        return found

    def walk(self, node: int) -> int:
        """Return the most tests of a walk; what is always true takes none."""
        return self.tests[node] if node >= 0 else 0

    def slots_of(self, request: int) -> int:
        """Return the number of the quantity that stands for the slots of a request."""
        return len(self.tables.entries) + request

    def place_of(self, request: int) -> int:
        """Return the number of the quantity that stands for its waiting place."""
        return len(self.tables.entries) + len(self.tables.requests) + request

    # ---- counting slots and places in or out ----

    @cached_property
    def slot(self) -> list[int]:
        """The most tests that count a slot of each request in or out."""
        return [self._counting(row, slots=True) for row in self.tables.requests]

    @cached_property
    def place(self) -> list[int]:
        """The most tests that count the waiting place of each request in or out."""
        return [self._counting(row, slots=False) for row in self.tables.requests]

    def _counting(self, row: RequestRow, slots: bool) -> int:
        """Return the tests of features of all slots, and of those of the slot that has most of its own."""
        own: dict[int, int] = {NONE: 0}
        for feature in self.tables.features[row.features : row.features_end]:
            own[feature.slot] = own.get(feature.slot, 0) + self.walk(feature.predicate)
        return own.pop(NONE) + (max(own.values(), default=0) if slots else 0)

    def slot_writes(self, request: int) -> set[int]:
        """Return what changes with the phase of a slot."""
        features = self._features(request)
        return self._sums(e for f in features for e in (f.running, f.stopping)) | {self.slots_of(request)}

    def place_writes(self, request: int) -> set[int]:
        """Return what changes with the waiting place."""
        features = self._features(request)
        return self._sums(e for f in features for e in (f.waiting, f.clearing)) | {self.place_of(request)}

    def _features(self, request: int) -> tuple[t.FeatureRow, ...]:
        row = self.tables.requests[request]
        return self.tables.features[row.features : row.features_end]

    def _sums(self, entries: Iterable[int]) -> set[int]:
        """Return the entries, and the sums of which they are part."""
        found = {entry for entry in entries if entry != NONE}
        for entry in tuple(found):
            row = self.tables.entries[entry]
            found |= {other for other, _ in self.tables.sums[row.sums : row.sums_end]}
        return found

    # ---- decisions and launches ----

    def launch(self, request: int) -> Doing:
        """Return what a launch does, the decision left out."""
        row = self.tables.requests[request]
        found = self._effects(row.on_launch, row.on_ok)
        taken = self.tables.amounts[row.consumes : row.produces]
        found.tests += self.slot[request] + sum(self.walk(amount.predicate) for amount in taken)
        found.writes |= self.slot_writes(request) | self._stocks(taken)
        return found

    def decision(self, request: int) -> Doing:
        """Return what deciding on a request and doing what is decided writes, and the tests of both but for kills."""
        row = self.tables.requests[request]
        found = self.launch(request)
        found.tests += self.walk(row.decide)
        found.writes |= self.place_writes(request)
        for index in self.tables.below(row.decide):
            node = self.tables.nodes[index]
            if node.code == -t.DISMISS:
                found.writes |= self.place_writes(node.high)
        for target in self.killed(row.decide):
            found.writes |= self.slot_writes(target)
        return found

    def killed(self, root: int) -> dict[int, set[int]]:
        """Return by request the slots, counted among all, that the diagram may kill."""
        found: dict[int, set[int]] = {}
        for index in self.tables.below(root):
            node = self.tables.nodes[index]
            if node.code == -t.KILL:
                request = node.high if node.high >= 0 else self.owner[-1 - node.high]
                row = self.tables.requests[request]
                slots = range(row.slots, row.slots + row.instances) if node.high >= 0 else [-1 - node.high]
                found.setdefault(request, set()).update(slots)
        return found

    @cached_property
    def owner(self) -> list[int]:
        """The request of each slot of all."""
        return [number for number, row in enumerate(self.tables.requests) for _ in range(row.instances)]

    def _stocks(self, amounts: Iterable[t.AmountRow]) -> set[int]:
        return self._sums(self.tables.stocks[amount.stock].entry for amount in amounts)

    def _effects(self, start: int, end: int) -> Doing:
        found = Doing()
        for effect in self.tables.effects[start:end]:
            if effect.kind == t.SET:
                one = self._read(effect.target)
                found.tests += one.tests
                found.writes |= one.writes
            else:
                row = self.tables.requests[effect.target]
                found.writes |= self._sums(past.entry for past in self.tables.pasts[row.pasts : row.pasts_end])
        return found

    def _read(self, variable: int) -> Doing:
        """Return what a new value of a variable costs: slots are counted out and in whose features read it."""
        row = self.tables.variables[variable]
        found = Doing(writes=self._sums([row.value, row.rank]))
        found.writes |= self._sums(order.entry for order in self.tables.orders[row.orders : row.orders_end])
        for request in self.tables.lists[row.refresh : row.refresh_end]:
            found.tests += 2 * self.tables.requests[request].instances * self.slot[request]
            found.writes |= self.slot_writes(request)
        return found

    @cached_property
    def latches(self) -> Doing:
        """What looking at all latches costs."""
        found = Doing()
        for latch in self.tables.latches:
            one = self._read(latch.variable)
            found.tests += self.walk(latch.condition) + one.tests
            found.writes |= one.writes
        return found

    # ---- events ----

    def ask(self, request: int) -> Doing:
        """Return what an ask does itself; what waited may be superseded, and is counted out of its place."""
        row = self.tables.requests[request]
        found = self.decision(request)
        found.tests += 2 * self.place[request]
        for target, slots in self.killed(row.decide).items():
            found.tests += 2 * self.slot[target] * len(slots)
        found.answers = 2 if row.interrupts_self else 1
        return found

    def report(self, request: int) -> Doing:
        """Return what the report of a slot does itself, whatever the outcome."""
        row = self.tables.requests[request]
        found = self._effects(row.on_ok, row.effects_end)
        pasts = self.tables.pasts[row.pasts : row.pasts_end]
        given = self.tables.amounts[row.produces : row.produces_end]
        found.tests += self.slot[request] + self.latches.tests
        found.tests += sum(self.walk(past.predicate) for past in pasts)
        found.tests += sum(self.walk(amount.predicate) for amount in given)
        found.writes |= self.slot_writes(request) | self.latches.writes | self._stocks(given)
        found.writes |= self._sums([row.last, *(past.entry for past in pasts)])
        return found

    def kill(self, request: int) -> Doing:
        """Return what the abort of a slot does itself."""
        return Doing(2 * self.slot[request], 1, self.slot_writes(request))

    def withdrawal(self, request: int) -> Doing:
        """Return what giving up a waiting request does itself."""
        return Doing(self.place[request], 1, self.place_writes(request))

    def reading(self, variable: int) -> Doing:
        """Return what an observation of a poster does itself."""
        found = self._read(variable)
        return Doing(found.tests + self.latches.tests, 1, found.writes | self.latches.writes)

    def level(self, stock: int) -> Doing:
        """Return what an observation of a level does itself."""
        writes = self._sums([self.tables.stocks[stock].entry]) | self.latches.writes
        return Doing(self.latches.tests, 1, writes)
