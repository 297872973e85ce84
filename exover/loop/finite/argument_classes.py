"""Cells and classes of arguments: the finite partition that tests and conditions induce, with representatives.

Reals are sampled at the constants that they are compared with, and between neighbouring constants at as many points as
there are reals that are compared with each other, so that every order of them occurs.
"""

import math
from dataclasses import field
from functools import cached_property
from itertools import product

from exover.dataclass import dataclass
from exover.loop.finite.tested_bounds import TestedBounds, TooLarge, points
from exover.loop.tracked_predicates import TrackedConstants, TrackedPast, TrackedPredicates
from exover.model.evaluate import Scope, bind, holds
from exover.model.event import Args
from exover.model.expression import Param, operands
from exover.model.model import Model, Parameter
from exover.model.state import State, resting
from exover.model.types import Real, Value, from_ordinal, ordinal
from exover.ocrd.entries import compare
from exover.ocrd.tables import ALWAYS, NONE, OrderRow, ParamRow, RequestRow, Tables
from exover.ocrd.vector import LEFT, RIGHT, rank

MOST_SAMPLES = 50_000
"""The greatest number of argument tuples that are sampled for one request."""


@dataclass(frozen=True, slots=True)
class Class:
    """An argument class, which is what a slot keeps of its arguments: its number, and a representative."""

    number: int
    args: Args


@dataclass(frozen=True, slots=True)
class Cell:
    """Arguments that are decided alike: a representative, its loaded entries as pairs, and its class in a slot."""

    number: int
    args: Args
    entries: tuple[tuple[int, int], ...]
    slot_class: int


@dataclass
class Arguments:
    """The cells and classes of one request."""

    model: Model
    tables: Tables
    bounds: TestedBounds
    tracked: TrackedPredicates
    request: int
    nothing: State
    """Any state, for the evaluation of conditions that read only arguments."""
    _loaded: dict[Args, dict[int, int]] = field(default_factory=dict)
    _weights: dict[tuple[Args, tuple[int, ...]], tuple[int, ...]] = field(default_factory=dict)
    _part_weights: dict[tuple[tuple[int, ...], Args, tuple[int, ...]], list[int]] = field(default_factory=dict)
    _past_signs: dict[Args, tuple[tuple[object, ...], ...]] = field(default_factory=dict)
    _part_pasts: dict[tuple[tuple[int, ...], tuple[int, ...]], list[bool]] = field(default_factory=dict)
    _kinds: dict[tuple[Args, Args], int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.row: RequestRow = self.tables.requests[self.request]
        declared = self.model.requests[self.request]
        self.params, self.results = declared.params, declared.results
        self.conditions = tuple(dict.fromkeys(self.tracked.conditions.get(declared.name, ())))
        self.tracked_past = self.tracked.pasts.get(declared.name)
        orders = self.tables.orders[self.row.orders : self.row.orders_end]
        tested = [order for order in orders if order.right < 0]
        self.tracked_orders = self._tracked_orders({(order.left, order.right) for order in tested})
        self.poster_orders: tuple[OrderRow, ...] = (*tested, *self.tracked_orders)
        self.inner_orders: tuple[OrderRow, ...] = tuple(o for o in orders if o.right >= 0)
        self.result_samples = self._samples(self.results, len(self.params))
        self.samples = self._samples(self.params, 0)

    def _tracked_orders(self, tested: set[tuple[int, int]]) -> list[OrderRow]:
        """Return the comparisons of arguments with posters that conditions make and no table does."""
        posters = {variable.name: -1 - number for number, variable in enumerate(self.model.variables)}
        params = {parameter.name: number for number, parameter in enumerate(self.params)}
        own = self.model.requests[self.request].name
        tracked = [
            (params[name], posters[poster]) for request, name, poster in sorted(self.tracked.orders) if request == own
        ]
        return [OrderRow(*pair, NONE) for pair in tracked if pair not in tested]

    def choices(self) -> list[tuple[int, ...]]:
        """Return every combination of orders between arguments and posters, in the order of `poster_orders`."""
        return list(product(range(LEFT, RIGHT + 1), repeat=len(self.poster_orders)))

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
        for order in self.inner_orders:
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
        mine |= {order.entry for order in self.inner_orders}
        held = [self.tables.entries[entry] for entry in mine - {NONE}]
        totals = {total for entry in held for total, _ in self.tables.sums[entry.sums : entry.sums_end]}
        return [(total, self.bounds.sums[total]) for total in sorted(totals)]

    @cached_property
    def remembered(self) -> range:
        """The indices of the comparisons with posters that a slot keeps: all if they matter there, else none."""
        if not self.poster_orders:
            return range(0)
        choices = self.choices()
        varies = bool(self.tracked_orders) or any(
            len({self.weights(kind.args, choice) for choice in choices}) > 1 for kind in self.classes
        )
        return range(len(self.poster_orders) if varies else 0)

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

    def pasts(self, args: Args, results: Args) -> tuple[int, ...]:
        """Return the values of the entries of the past after an ok with these arguments and results.

        They are cached by the values of the entries that they depend on.
        """
        entries = self.loaded(args + results)
        found = [0] * (self.row.pasts_end - self.row.pasts)
        for tested, numbers in self._pasts_by_tested.items():
            key = tested, tuple([entries[entry] for entry in tested])
            if key not in self._part_pasts:
                rows = (self.tables.pasts[self.row.pasts + number] for number in numbers)
                self._part_pasts[key] = [self.agrees(row.predicate, entries) for row in rows]
            for number, agreed in zip(numbers, self._part_pasts[key], strict=True):
                found[number] = int(agreed)
        return tuple(found)

    @cached_property
    def _pasts_by_tested(self) -> dict[tuple[int, ...], list[int]]:
        """The entries of the past, by number, by the entries that their predicates test."""
        found: dict[tuple[int, ...], list[int]] = {}
        for number, row in enumerate(self.tables.pasts[self.row.pasts : self.row.pasts_end]):
            found.setdefault(tuple(sorted(self._tested(row.predicate))), []).append(number)
        return found

    @property
    def remembers_past(self) -> bool:
        """Whether anything reads the past of the request."""
        return self.tracked_past is not None or self.row.pasts < self.row.pasts_end

    @cached_property
    def past_kinds(self) -> list[Args]:
        """One tuple of arguments and results for each class of pasts that something tells apart."""
        return [kind.args for kind in self._pasts_by_sign.values()]

    @cached_property
    def _pasts_by_sign(self) -> dict[tuple[object, ...], Class]:
        found: dict[tuple[object, ...], Class] = {}
        for kind in self.classes:
            for results, sign in zip(self.result_samples, self._signs_of_pasts(kind.args), strict=True):
                found.setdefault(sign, Class(len(found), kind.args + results))
        return found

    def _signs_of_pasts(self, args: Args) -> tuple[tuple[object, ...], ...]:
        """Return for each sample of the results the signature of a past with these arguments.

        It is cached by the arguments that anything reads of a past.
        """
        if not self.remembers_past:
            return self._told_of_nothing
        known = tuple([args[number] for number in self._kept])
        if known not in self._past_signs:
            self._past_signs[known] = tuple(self._past_sign(args, results) for results in self.result_samples)
        return self._past_signs[known]

    @cached_property
    def _told_of_nothing(self) -> tuple[tuple[object, ...], ...]:
        return tuple(((), (), ()) for _ in self.result_samples)

    @cached_property
    def _kept(self) -> tuple[int, ...]:
        """The indices of the arguments that a test or a condition reads of a past."""
        tracked, rows = self.tracked_past or TrackedPast(), self.tables.pasts[self.row.pasts : self.row.pasts_end]
        read = {
            term.name for each in tracked.comparisons for term in operands(each) if isinstance(term, Param)
        } | tracked.exact
        named = {number for number, parameter in enumerate(self.params) if parameter.name in read}
        return tuple(sorted(named.union(*(self._looked_at(row.predicate) for row in rows))))

    def _looked_at(self, predicate: int) -> set[int]:
        """Return the indices of the arguments on which the truth of a predicate depends."""
        tested = self._tested(predicate)
        tested |= {part for entry in tested for part, _ in self.bounds.sums.get(entry, ())}
        compared = {side for order in self.inner_orders if order.entry in tested for side in (order.left, order.right)}
        loading = enumerate(self.tables.params[self.row.params : self.row.params_end][: len(self.params)])
        loaded = {number for number, row in loading if {row.value, row.rank} & tested}
        return loaded | {side for side in compared if 0 <= side < len(self.params)}

    def _tested(self, predicate: int) -> set[int]:
        """Return the entries that a predicate tests."""
        below = self.tables.below(predicate) if predicate >= 0 else ()
        return {node.code for node in map(self.tables.nodes.__getitem__, below) if node.code >= 0}

    def past_kind(self, args: Args, results: Args) -> int:
        """Return the index in `past_kinds` of the past that an ok with these arguments and results leaves."""
        key = tuple([args[number] for number in self._kept]), results
        if key not in self._kinds:
            self._kinds[key] = self._pasts_by_sign[self._past_sign(args, results)].number
        return self._kinds[key]

    def _past_sign(self, args: Args, results: Args) -> tuple[object, ...]:
        """Return the signature of a past: equal iff no test of the tables and no condition tells two pasts apart."""
        tracked = self.tracked_past or TrackedPast()
        values = bind((*self.params, *self.results), args + results)
        truths = tuple(holds(self.model, self.nothing, each, Scope(values)) for each in tracked.comparisons)
        return self.pasts(args, results), truths, tuple(values[name] for name in sorted(tracked.exact))

    def with_orders(self, args: Args, choice: tuple[int, ...]) -> dict[int, int]:
        """Return the loaded entries with the comparisons with posters, which have the values of `choice`."""
        return self.loaded(args) | dict(self.compared(choice))

    def compared(self, choice: tuple[int, ...]) -> list[tuple[int, int]]:
        """Return the entries that compare arguments with posters, with the values of `choice`."""
        pairs = zip(self.poster_orders, choice, strict=True)
        return [(order.entry, value) for order, value in pairs if order.entry != NONE]

    def cuts(self, number: int) -> tuple[float, ...]:
        """Return the constants that a real parameter or result is compared with, increasing."""
        row = self.tables.params[self.row.params + number]
        name = (*self.params, *self.results)[number].name
        tracked = self.tracked.cuts.get((self.model.requests[self.request].name, name), set())
        return tuple(sorted({*self.tables.reals[row.cuts : row.cuts_end], *tracked}))

    def weights(self, args: Args, choice: tuple[int, ...]) -> tuple[int, ...]:
        """Return for each feature the weight of these arguments, if they compare with posters as `choice` says."""
        if (args, choice) not in self._weights:
            self._weights[args, choice] = self._weigh(args, choice)
        return self._weights[args, choice]

    def _weigh(self, args: Args, choice: tuple[int, ...]) -> tuple[int, ...]:
        """Return `weights`, computed; each weight is cached by the arguments that it depends on."""
        found = [0] * (self.row.features_end - self.row.features)
        for numbers, features in self._features.items():
            key = numbers, tuple([args[number] for number in numbers]), choice
            if key not in self._part_weights:
                entries = self.with_orders(args, choice)
                self._part_weights[key] = [self._weight(feature, args, entries) for feature in features]
            for feature, weight in zip(features, self._part_weights[key], strict=True):
                found[feature] = weight
        return tuple(found)

    @cached_property
    def _features(self) -> dict[tuple[int, ...], list[int]]:
        """Maps indices of arguments to the features whose weights depend on just these."""
        found: dict[tuple[int, ...], list[int]] = {}
        for number, feature in enumerate(self.tables.features[self.row.features : self.row.features_end]):
            read = self._looked_at(feature.predicate) | {feature.weight} - {NONE}
            found.setdefault(tuple(sorted(read)), []).append(number)
        return found

    def _weight(self, number: int, args: Args, entries: dict[int, int]) -> int:
        """Return the weight of arguments in a feature; 0 if its predicate is false of them."""
        feature = self.tables.features[self.row.features + number]
        if not self.agrees(feature.predicate, entries):
            return 0
        return 1 if feature.weight == NONE else ordinal(self.params[feature.weight].type, args[feature.weight])

    def cell_of(self, args: Args) -> Cell:
        """Return the cell of concrete arguments."""
        return self.cells[0] if len(self.cells) == 1 else self._by_sign[self._sign(args)]

    def _sign(self, args: Args) -> tuple[object, ...]:
        """Return the signature of a cell: the outcomes of tests of loaded entries, and the signature of the class."""
        return self._loaded_sign(args), self._class_sign(args)

    def _loaded_sign(self, args: Args) -> tuple[int, ...]:
        return tuple([self.bounds.sign(entry, value) for entry, value in self.loaded(args).items()])

    def _tracked_sign(self, args: Args) -> tuple[object, ...]:
        """Return the part of the signature that conditions need: their truth, values in sums, ranks among constants."""
        scope = Scope(bind(self.params, args))
        truths = tuple(holds(self.model, self.nothing, cond, scope) for cond in self.conditions)
        name = self.model.requests[self.request].name
        pairs = zip(self.params, args, strict=True)
        exact = tuple(value for p, value in pairs if self._tracked_constants(name, p.name).exact)
        return truths, exact, tuple(self._rank(order.left, args) for order in self.poster_orders)

    def _rank(self, number: int, args: Args) -> int:
        return rank(self.cuts(number), float(args[number]))

    def _tracked_constants(self, request: str, param: str) -> TrackedConstants:
        return self.tracked.params.get((request, param)) or TrackedConstants()

    def _weight_signs(self, args: Args, choice: tuple[int, ...]) -> tuple[int, ...]:
        features = self.tables.features[self.row.features : self.row.features_end]
        pairs = zip(features, self.weights(args, choice), strict=True)
        return tuple(w if f.weight == NONE else self.bounds.sign(f.running, w) for f, w in pairs)

    def _class_sign(self, args: Args) -> tuple[object, ...]:
        """Return the signature of a class: conditions, weights, pasts, and what is produced at an ok."""
        row, entries = self.row, self.loaded(args)
        return (
            self._tracked_sign(args),
            tuple(self._weight_signs(args, choice) for choice in self.choices()),
            self._signs_of_pasts(args),
            tuple(self.agrees(a.predicate, entries) for a in self.tables.amounts[row.produces : row.produces_end]),
        )

    @cached_property
    def cells(self) -> list[Cell]:
        """The cells, computed when first needed, since that takes long if there are thousands."""
        if len(self.samples) == 1:  # nothing tells these arguments apart
            args = self.samples[0]
            return [Cell(0, args, tuple(self.loaded(args).items()), 0)]
        return list(self._by_sign.values())

    @cached_property
    def classes(self) -> list[Class]:
        """The classes."""
        found: dict[int, Class] = {}
        for cell in self.cells:
            found.setdefault(cell.slot_class, Class(cell.slot_class, cell.args))
        return list(found.values())

    @cached_property
    def _by_sign(self) -> dict[tuple[object, ...], Cell]:
        found: dict[tuple[object, ...], Cell] = {}
        classes: dict[tuple[object, ...], int] = {}
        for args in self.samples:
            class_sign = self._class_sign(args)
            sign = self._loaded_sign(args), class_sign
            if sign not in found:
                number = classes.setdefault(class_sign, len(classes))
                found[sign] = Cell(len(found), args, tuple(self.loaded(args).items()), number)
        return found

    def _samples(self, params: tuple[Parameter, ...], first: int) -> list[Args]:
        choices: list[list[Value]] = []
        compared = {side for o in (*self.inner_orders, *self.poster_orders) for side in (o.left, o.right)}
        name = self.model.requests[self.request].name
        compared |= {k for k, p in enumerate(params, first) if (name, p.name) in self.tracked.compared}
        shared = self._shared_constants(compared)
        for number, parameter in enumerate(params, first):
            row = self.tables.params[self.row.params + number]
            if isinstance(parameter.type, Real):
                choices.append(self._real_samples(number, shared if number in compared else None))
            else:
                tracked = self._tracked_constants(name, parameter.name)
                numbers = self.bounds.samples(
                    f"{name}.{parameter.name}", self._entries(number, row), row.low, row.high, tracked
                )
                choices.append([from_ordinal(parameter.type, number) for number in numbers])
        if math.prod(map(len, choices)) > MOST_SAMPLES:
            raise TooLarge(f"`{name}` has more than {MOST_SAMPLES} kinds of arguments")
        return list(product(*choices))

    def _entries(self, number: int, row: ParamRow) -> list[int]:
        """Return the entries whose value an integer parameter contributes to: as a loaded argument, and from a slot."""
        features = self.tables.features[self.row.features : self.row.features_end]
        found = [feature.running for feature in features if feature.weight == number]
        return [entry for entry in (row.value, *found) if entry != NONE]

    def _shared_constants(self, compared: set[int]) -> tuple[float, ...]:
        found: set[float] = set()
        for number in compared:
            if number >= 0:
                row = self.tables.params[self.row.params + number]
                found |= {*self.cuts(number)}
                found |= {self.tables.reals[row.low], self.tables.reals[row.high]} - {math.inf, -math.inf}
        return tuple(sorted(found))

    def _real_samples(self, number: int, shared: tuple[float, ...] | None) -> list[Value]:
        row, cuts = self.tables.params[self.row.params + number], self.cuts(number)
        low, high = self.tables.reals[row.low], self.tables.reals[row.high]
        if shared is not None:
            reals = [p for p in (*self.params, *self.results) if isinstance(p.type, Real)]
            return list(points(low, high, shared, len(reals)))
        if not cuts:
            return [low if math.isfinite(low) else min(0.0, high)]
        return list(points(low, high, cuts, 1))


def all_arguments(model: Model, tables: Tables, bounds: TestedBounds, tracked: TrackedPredicates) -> list[Arguments]:
    """Return the arguments of each request; raises `TooLarge` if one has more than `MOST_SAMPLES` samples."""
    start = resting(model)
    return [Arguments(model, tables, bounds, tracked, number, start) for number in range(len(model.requests))]
