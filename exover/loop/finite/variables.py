"""The states of the finite loop: its variables, and each entry of the state vector as a sum over them."""

from bisect import bisect_right
from dataclasses import field

from exover.dataclass import dataclass
from exover.loop.finite.argument_classes import all_arguments
from exover.loop.finite.program import FiniteVariable
from exover.loop.finite.real_orders import RealCells, RealOrders, poster_cells
from exover.loop.finite.tested_bounds import TestedBounds, TooLarge
from exover.loop.tracked_predicates import TrackedConstants, tracked_predicates
from exover.model.index import ModelIndex
from exover.model.model import Model
from exover.model.property import NO_PROPERTIES, Properties, happened
from exover.model.types import Value, from_ordinal, ordinal
from exover.ocrd import tables as t
from exover.ocrd.entries import compare
from exover.ocrd.memory import CLEARING, EMPTY, IDLE, RUNNING, STOPPING, WAITING
from exover.ocrd.reasons import reasons
from exover.ocrd.tables import NONE, Node, Tables, VariableRow
from exover.ocrd.vector import LEFT, OUTCOMES, RIGHT, Element, Vocabulary, rank

VariableKey = tuple[object, ...]
"""The kind of a variable and its owner: `reading`, `level` with a number; `pair` of two posters; `phase`, `class`,
`order` of a slot; `place`, `cell`, `standing`, `past`, `last` of a request; `happened` of the predicate of this number;
and what a step remembers: `tried` of a launch rule, `fallen`, `chosen` of a request.
"""
StateGuard = tuple[tuple[int, frozenset[int]], ...]
"""Variables and the values that each must have."""
GuardedValue = tuple[tuple[StateGuard, int], ...]
"""A value for each of several disjoint guards, 0 elsewhere."""
MOST_LEVELS = 4096
"""The greatest capacity of a consumable in the finite loop."""
MEMORY = ("tried", "fallen", "chosen")
"""Kinds of variables that are 0 between steps."""

PLACES = ("place", "cell", "standing")
"""Kinds of variables of a waiting place; they are 0 while nothing waits."""


@dataclass
class LoopStates:
    """The state of docs/language.md section 3, up to what the tables and the properties tell apart.

    Slots hold classes of arguments, waiting places cells, and readings their representatives.
    """

    model: Model
    tables: Tables
    entries: tuple[Element, ...]
    """The element that each entry of the vector counts."""
    properties: Properties = NO_PROPERTIES
    """The properties whose conditions are tracked, too, and whose predicates on steps have history variables."""
    variables: list[FiniteVariable] = field(default_factory=list)
    index: dict[VariableKey, int] = field(default_factory=dict)
    terms: dict[int, list[GuardedValue]] = field(default_factory=dict)
    _actions_below: dict[int, list[tuple[int, Node]]] = field(default_factory=dict, init=False, repr=False)
    _tested_below: dict[int, set[int]] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        self.bounds = TestedBounds(self.tables)
        self.reasons = reasons(self.model)
        self.may_wait, self.may_fall = self.tables.may_wait(), self.tables.may_fall()
        self.entry_of = {element: entry for entry, element in enumerate(self.entries)}
        index = ModelIndex(self.model)
        self.names, self.request_number = index.readings, index.request
        self.types = tuple(kind for _, kind in index.typed_readings)
        self.tracked = tracked_predicates(self.model, self.properties)
        self.thresholds = Vocabulary(self.model).thresholds
        self.arguments = all_arguments(self.model, self.tables, self.bounds, self.tracked)
        self.samples: dict[int, list[Value]] = {}
        self.posters: dict[int, RealCells] = {}
        for number in range(len(self.tables.variables)):
            self._declare_variable(number)
        self.orders = [RealOrders(arguments, self.posters) for arguments in self.arguments]
        self._declare_pairs()
        for number in range(len(self.tables.stocks)):
            self._declare_stock(number)
        for request in range(len(self.model.requests)):
            self._declare_request(request)
        for number in range(len(self.tables.launches)):
            self._declare(("tried", number), 2, 0)
        self.observed = tuple(dict.fromkeys(happened(self.properties)))
        self.history = {each: self._declare(("happened", n), 2, 0) for n, each in enumerate(self.observed)}

    @property
    def bit_count(self) -> int:
        """The number of bits of a state."""
        return sum((variable.size - 1).bit_length() for variable in self.variables)

    # ---- variables ----

    def _declare(self, key: VariableKey, size: int, initial: int) -> int:
        self.index[key] = len(self.variables)
        self.variables.append(FiniteVariable(key, size, initial))
        return self.index[key]

    def _term(self, entry: int, *cases: tuple[StateGuard, int]) -> None:
        if entry != NONE:
            self.terms.setdefault(entry, []).append(cases)

    def _declare_variable(self, number: int) -> None:
        """Declare a poster, state or latch: two readings share a value iff no test or condition tells them apart."""
        row = self.tables.variables[number]
        name = self.names[number]
        if row.value == NONE and row.rank == NONE and row.raw == NONE and name not in self.tracked.readings:
            return
        if row.type == t.REAL:
            self.posters[number] = poster_cells(self.model, self.tables, self.tracked, number)
        values, numbers = self._readings(number, row)
        self.samples[number] = values
        entry = row.rank if row.type == t.REAL else row.value
        initial = self.tables.reals[row.initial] if row.type == t.REAL else row.initial
        first = self.reading_cell(number, initial)
        var = self._declare(("reading", number), len(values), first)
        self._term(entry, *((((var, frozenset({cell})),), n) for cell, n in enumerate(numbers)))

    def _readings(self, number: int, row: VariableRow) -> tuple[list[Value], list[int]]:
        if row.type == t.REAL:
            cuts = self.tables.reals[row.cuts : row.cuts_end]
            found = self.posters[number].samples
            return list(found), [rank(cuts, value) for value in found]
        name = self.names[number]
        tracked = self.tracked.readings.get(name) or TrackedConstants()
        numbers = self.bounds.samples(name, [row.value] if row.value != NONE else [], row.low, row.high, tracked)
        return [from_ordinal(self.types[number], n) for n in numbers], numbers

    def reading_cell(self, number: int, value: float) -> int:
        """Return the value of the loop's variable for a reading: a double, or the ordinal of another type."""
        row = self.tables.variables[number]
        if row.type == t.REAL:
            return self.posters[number].cell(value)
        return bisect_right(self.ordinals(number), int(value)) - 1

    def ordinals(self, number: int) -> list[int]:
        """Return the ordinals of the samples of a reading that is no real."""
        return [ordinal(self.types[number], value) for value in self.samples[number]]

    def _declare_pairs(self) -> None:
        """Declare, for two real posters that are compared, a variable for their order."""
        rows = {o for v in self.tables.variables for o in self.tables.orders[v.orders : v.orders_end]}
        for order in sorted(rows, key=lambda order: order.entry):
            var = self._declare_pair(-1 - order.left, -1 - order.right)
            self._term(order.entry, *((((var, frozenset({value})),), value) for value in range(LEFT, RIGHT + 1)))
        for pair in sorted(self.tracked.pairs):
            left, right = (self.names.index(name) for name in pair)
            if not {("pair", left, right), ("pair", right, left)} & self.index.keys():
                self._declare_pair(left, right)

    def _declare_pair(self, left: int, right: int) -> int:
        rows = (self.tables.variables[side] for side in (left, right))
        start = compare(*(self.tables.reals[row.initial] for row in rows))
        return self._declare(("pair", left, right), 3, start)

    def _declare_stock(self, number: int) -> None:
        row = self.tables.stocks[number]
        name = ModelIndex(self.model).stocks[number]
        if row.entry == NONE and name not in self.tracked.levels:
            return
        if row.capacity > MOST_LEVELS:
            raise TooLarge(f"consumable `{name}` has {row.capacity + 1} levels; {MOST_LEVELS} at most are followed")
        var = self._declare(("level", number), row.capacity + 1, row.initial)
        self._term(row.entry, *((((var, frozenset({n})),), n) for n in range(row.capacity + 1)))

    def _declare_request(self, request: int) -> None:
        row, arguments = self.tables.requests[request], self.arguments[request]
        for slot in range(row.slots, row.slots + row.instances):
            self._declare(("phase", slot), 3, IDLE)
            if len(arguments.classes) > 1:
                self._declare(("class", slot), len(arguments.classes), 0)
            for which in self.arguments[request].remembered:
                self._declare(("order", slot, which), 3, LEFT)
        self._declare_memory(request)
        if self.may_wait[request]:
            self._declare(("place", request), 3, EMPTY)
            if len(arguments.cells) > 1:
                self._declare(("cell", request), len(arguments.cells), 0)
            if self.may_fall[request]:
                self._declare(("fallen", request), 2, 0)
        for which in range(len(arguments.poster_orders)):
            self._declare(("chosen", request, which), 3, LEFT)
            if self.may_wait[request]:
                self._declare(("standing", request, which), 3, LEFT)
        self._count(request)

    def _declare_memory(self, request: int) -> None:
        """Declare the last outcome, and the past: 0 if there is none, else 1 plus the number of its class."""
        row, arguments = self.tables.requests[request], self.arguments[request]
        if arguments.pasts.remembered:
            kinds = arguments.pasts.representatives
            var = self._declare(("past", request), 1 + len(kinds), 0)
            split = len(arguments.params)
            truths = [arguments.pasts.entries(kind[:split], kind[split:]) for kind in kinds]
            for number, past in enumerate(self.tables.pasts[row.pasts : row.pasts_end]):
                those = frozenset(k for k, truth in enumerate(truths, 1) if truth[number])
                self._term(past.entry, (((var, those),), 1))
        if row.last != NONE or self.model.requests[request].name in self.tracked.lasts:
            var = self._declare(("last", request), len(OUTCOMES), 0)
            self._term(row.last, *((((var, frozenset({n})),), n) for n in range(len(OUTCOMES))))

    def _count(self, request: int) -> None:
        """Add the terms of a request's slots and waiting place to the entries of its features."""
        row, arguments = self.tables.requests[request], self.arguments[request]
        features = self.tables.features[row.features : row.features_end]
        remembered = self.arguments[request].remembered
        choices = arguments.choices() if remembered else arguments.choices()[:1]
        by_class = [[arguments.weights(kind.args, choice) for kind in arguments.classes] for choice in choices]
        cells = arguments.cells if self.may_wait[request] else []
        by_cell = [arguments.weights(cell.args, choices[0]) for cell in cells]
        for number, feature in enumerate(features):
            for slot in range(row.instances):
                if feature.slot not in (NONE, slot):
                    continue
                at = row.slots + slot
                entries = {RUNNING: feature.running, STOPPING: feature.stopping}
                cases: list[tuple[StateGuard, list[int]]] = []
                for choice, weights in zip(choices, by_class, strict=True):
                    chosen = tuple((self.index["order", at, k], frozenset({choice[k]})) for k in remembered)
                    cases.append((chosen, [each[number] for each in weights]))
                self._count_phases(("phase", at), ("class", at), entries, cases)
            if self.may_wait[request] and feature.slot == NONE:
                entries = {WAITING: feature.waiting, CLEARING: feature.clearing}
                waiting = [each[number] for each in by_cell]
                self._count_phases(("place", request), ("cell", request), entries, [((), waiting)])

    def _count_phases(
        self,
        where: VariableKey,
        which: VariableKey,
        entries: dict[int, int],
        chosen: list[tuple[StateGuard, list[int]]],
    ) -> None:
        """Add terms to the entry of each phase: the weights by class or cell, under each of several disjoint guards."""
        phase = self.index[where]
        kind = self.index.get(which)
        for entry in sorted(set(entries.values()) - {NONE}):
            phases = frozenset(p for p, e in entries.items() if e == entry)
            cases = []
            for extra, weights in chosen:
                for weight in sorted(set(weights) - {0}):
                    guard: StateGuard = ((phase, phases), *extra)
                    if kind is not None:
                        guard += ((kind, frozenset(k for k, w in enumerate(weights) if w == weight)),)
                    cases.append((guard, weight))
            self._term(entry, *cases)

    def vars_of(self, entry: int) -> set[int]:
        """Return the variables on which an entry of the vector depends."""
        return {var for _, term in self.all_terms(entry) for guard, _ in term for var, _ in guard}

    def all_terms(self, entry: int) -> list[tuple[int, GuardedValue]]:
        """Return the factors and terms whose sum is the entry."""
        parts = [(entry, 1), *self.bounds.sums.get(entry, ())]
        return [(factor, term) for part, factor in parts for term in self.terms.get(part, ())]

    # ---- nodes ----

    def _actions(self, root: int) -> list[tuple[int, Node]]:
        if root not in self._actions_below:
            nodes = [(number, self.tables.nodes[number]) for number in self.tables.below(root)]
            self._actions_below[root] = [(number, node) for number, node in nodes if node.code < 0]
        return self._actions_below[root]

    def tested(self, root: int) -> set[int]:
        """Return the entries that the nodes below a root test."""
        if root not in self._tested_below:
            self._tested_below[root] = self.tables.tested(root)
        return self._tested_below[root]
