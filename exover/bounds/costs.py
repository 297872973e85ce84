"""What each event costs by itself, and which quantities it may change; a walk costs the longest path of its diagram.

A *move* is a quantity q that increases (written `q`) or decreases (`~q`). Quantities are numbered: the entries of the
state vector, then for every request how many of its slots run.
"""

from collections.abc import Iterable
from dataclasses import field
from functools import cached_property
from typing import Literal

from exover.dataclass import dataclass
from exover.ocrd import tables as t
from exover.ocrd.tables import NONE, RequestRow, Tables


@dataclass(slots=True)
class Doing:
    """What an event does itself, before any pass: at most so many tests and answers, and the moves that it may make.

    Tests and answers do not count the kills of `slots`, and what leaves `places`, which are waiting places of others.
    """

    tests: int = 0
    answers: int = 1
    """At least one: the event may be invalid."""
    moves: set[int] = field(default_factory=set)
    slots: frozenset[int] = frozenset()
    places: frozenset[int] = frozenset()


Phase = Literal["running", "stopping", "waiting", "clearing"]


@dataclass
class Costs:
    """Upper bounds of the tests of single walks and updates, and the moves that they make."""

    tables: Tables

    @cached_property
    def tests(self) -> list[int]:
        """The most tests on a path from each node; the last element, for index NONE, is 0."""
        found = [0] * (len(self.tables.nodes) + 1)
        for index in range(len(self.tables.nodes) - 1, -1, -1):
            node = self.tables.nodes[index]
            found[index] = found[node.low] if node.code < 0 else 1 + max(found[node.low], found[node.high])
        return found

    def walk(self, node: int) -> int:
        """Return the most tests of a walk from a node; 0 for NONE and ALWAYS."""
        return self.tests[node] if node >= 0 else 0

    def running(self, request: int) -> int:
        """Return the number of the quantity that counts the running slots of a request."""
        return len(self.tables.entries) + request

    # ---- counting slots and waiting places in or out ----

    @cached_property
    def slot(self) -> list[int]:
        """The most tests that count a slot of each request in or out."""
        return [self._counting(row, slots=True) for row in self.tables.requests]

    @cached_property
    def place(self) -> list[int]:
        """The most tests that count the waiting place of each request in or out."""
        return [self._counting(row, slots=False) for row in self.tables.requests]

    def _counting(self, row: RequestRow, slots: bool) -> int:
        """Return the tests of the features of any slot, and with `slots` the most that features of one slot add."""
        own: dict[int, int] = {NONE: 0}
        for feature in self.tables.features[row.features : row.features_end]:
            own[feature.slot] = own.get(feature.slot, 0) + self.walk(feature.predicate)
        return own.pop(NONE) + (max(own.values(), default=0) if slots else 0)

    def turn(self, request: int, before: Phase | None, after: Phase | None) -> set[int]:
        """Return the moves when a slot or the waiting place goes from one phase to another; None: idle, or empty.

        An entry that counts both phases alike makes no move.
        """
        found: set[int] = set()
        row = self.tables.requests[request]
        for feature in self.tables.features[row.features : row.features_end]:
            counts: dict[int, int] = {}
            for phase, sign in ((before, -1), (after, 1)):
                entry = NONE if phase is None else getattr(feature, phase)
                for other, factor in self._sums(entry):
                    counts[other] = counts.get(other, 0) + sign * factor
            least, most = self._weights(row, feature)
            for entry, count in counts.items():
                found |= {entry} if count * least > 0 or count * most > 0 else set()
                found |= {~entry} if count * least < 0 or count * most < 0 else set()
        return found

    def _weights(self, row: RequestRow, feature: t.FeatureRow) -> tuple[int, int]:
        """Return the least and the greatest amount that a slot adds to an entry of a feature."""
        if feature.weight == NONE:
            return 1, 1
        param = self.tables.params[row.params + feature.weight]
        return param.low, param.high

    def launched(self, request: int) -> set[int]:
        """Return the moves when a slot starts to run, its effects left out."""
        return self.turn(request, None, "running") | {self.running(request)}

    def placed(self, request: int) -> set[int]:
        """Return the moves when the waiting place is taken, left, or turns between waiting and clearing."""
        pairs: tuple[tuple[Phase | None, Phase | None], ...] = (
            (None, "waiting"), ("waiting", None), (None, "clearing"), ("clearing", None),
            ("waiting", "clearing"), ("clearing", "waiting"),
        )  # fmt: skip
        return {move for before, after in pairs for move in self.turn(request, before, after)}

    def _sums(self, entry: int) -> list[tuple[int, int]]:
        """Return an entry and the sums of which it is part, with its factor in each; nothing for no entry."""
        if entry == NONE:
            return []
        row = self.tables.entries[entry]
        return [(entry, 1), *((other, factor) for other, factor in self.tables.sums[row.sums : row.sums_end])]

    def _any(self, entries: Iterable[int]) -> set[int]:
        """Return all moves of entries and of the sums of which they are part."""
        return {move for entry in entries for other, _ in self._sums(entry) for move in (other, ~other)}

    # ---- rules that are walked again ----

    def looking(self, moves: Iterable[int]) -> int:
        """Return the tests of the rules that must be walked again after these moves."""
        entries = {move if move >= 0 else ~move for move in moves}
        rows = [self.tables.entries[entry] for entry in entries if entry < len(self.tables.entries)]
        rules = {rule for row in rows for rule in self.tables.lists[row.rules : row.rules_end]}
        return sum(self.walk(self.tables.rules[rule].root) for rule in rules)

    @cached_property
    def killing(self) -> list[int]:
        """By request the tests of killing a slot, with those of the rules that are walked again then."""
        every = [self.kill(request) for request in range(len(self.tables.requests))]
        return [doing.tests + self.looking(doing.moves) for doing in every]

    @cached_property
    def leaving(self) -> list[int]:
        """By request the tests of leaving the waiting place, with those of the rules that are walked again then."""
        requests = range(len(self.tables.requests))
        return [self.place[request] + self.looking(self.placed(request)) for request in requests]

    # ---- decisions and launches ----

    def launch(self, request: int) -> Doing:
        """Return the cost of a launch, without the decision."""
        row = self.tables.requests[request]
        found = self._effects(row.on_launch, row.on_ok)
        taken = self.tables.amounts[row.consumes : row.produces]
        found.tests += self.slot[request] + sum(self.walk(amount.predicate) for amount in taken)
        found.moves |= self.launched(request) | self._stocks(taken)
        return found

    def decision(self, request: int) -> Doing:
        """Return the cost of deciding on a request and doing what is decided, but for the tests of kills."""
        row = self.tables.requests[request]
        found = self.launch(request)
        found.tests += self.walk(row.decide)
        found.moves |= self.placed(request)
        nodes = [self.tables.nodes[index] for index in self.tables.below(row.decide)]
        found.places = frozenset(node.high for node in nodes if node.code == -t.DISMISS)
        for other in found.places:
            found.moves |= self.turn(other, "waiting", None) | self.turn(other, "clearing", None)
        killed = self.killed(row.decide)
        found.slots = frozenset().union(*killed.values())
        for target in killed:
            found.moves |= self.kill(target).moves
        return found

    def killed(self, root: int) -> dict[int, set[int]]:
        """Return by request the slots, counted among all, that the diagram may kill."""
        found: dict[int, set[int]] = {}
        for index in self.tables.below(root):
            node = self.tables.nodes[index]
            if node.code == -t.KILL:
                request = node.high if node.high >= 0 else self.tables.request_of(-1 - node.high)
                row = self.tables.requests[request]
                slots = range(row.slots, row.slots + row.instances) if node.high >= 0 else [-1 - node.high]
                found.setdefault(request, set()).update(slots)
        return found

    def _stocks(self, amounts: Iterable[t.AmountRow]) -> set[int]:
        return self._any(self.tables.stocks[amount.stock].entry for amount in amounts)

    def _effects(self, start: int, end: int) -> Doing:
        found = Doing()
        for effect in self.tables.effects[start:end]:
            if effect.kind == t.SET:
                one = self._read(effect.target)
                found.tests += one.tests
                found.moves |= one.moves
            else:
                row = self.tables.requests[effect.target]
                found.moves |= self._any(past.entry for past in self.tables.pasts[row.pasts : row.pasts_end])
        return found

    def _read(self, variable: int) -> Doing:
        """Return the cost of a new value of a variable: slots whose features read it are counted out and in again."""
        row = self.tables.variables[variable]
        found = Doing(moves=self._any([row.value, row.rank]))
        found.moves |= self._any(order.entry for order in self.tables.orders[row.orders : row.orders_end])
        for request in self.tables.lists[row.refresh : row.refresh_end]:
            found.tests += 2 * self.tables.requests[request].instances * self.slot[request]
            features = self.tables.requests[request].features, self.tables.requests[request].features_end
            counting = self.tables.features[slice(*features)]
            found.moves |= self._any(entry for each in counting for entry in (each.running, each.stopping))
        return found

    @cached_property
    def latches(self) -> Doing:
        """The cost of walking the conditions of all latches and setting them."""
        found = Doing()
        for latch in self.tables.latches:
            one = self._read(latch.variable)
            found.tests += self.walk(latch.condition) + one.tests
            found.moves |= one.moves
        return found

    # ---- events ----

    def ask(self, request: int) -> Doing:
        """Return the cost of an ask itself; what waited may be superseded, and is counted out of its place."""
        row = self.tables.requests[request]
        found = self.decision(request)
        found.tests += 2 * self.place[request]
        found.answers = 2 if row.interrupts_self else 1
        return found

    def report(self, request: int) -> Doing:
        """Return the cost of the report of a slot itself, whatever the outcome."""
        row = self.tables.requests[request]
        found = self._effects(row.on_ok, row.effects_end)
        pasts = self.tables.pasts[row.pasts : row.pasts_end]
        given = self.tables.amounts[row.produces : row.produces_end]
        found.tests += self.slot[request] + self.latches.tests
        found.tests += sum(self.walk(past.predicate) for past in pasts)
        found.tests += sum(self.walk(amount.predicate) for amount in given)
        found.moves |= self.turn(request, "running", None) | self.turn(request, "stopping", None)
        found.moves |= self.latches.moves | self._stocks(given)
        found.moves |= self._any([row.last, *(past.entry for past in pasts)])
        return found

    def kill(self, request: int) -> Doing:
        """Return the cost of the abort of a slot itself."""
        return Doing(2 * self.slot[request], 1, self.turn(request, "running", "stopping"))

    def withdrawal(self, request: int) -> Doing:
        """Return the cost of the abort of a waiting request itself."""
        return Doing(self.place[request], 1, self.placed(request))

    def reading(self, variable: int) -> Doing:
        """Return the cost of an observation of a poster itself."""
        found = self._read(variable)
        return Doing(found.tests + self.latches.tests, 1, found.moves | self.latches.moves)

    def level(self, stock: int) -> Doing:
        """Return the cost of an observation of a level itself."""
        moves = self._any([self.tables.stocks[stock].entry]) | self.latches.moves
        return Doing(self.latches.tests, 1, moves)
