"""Cells and classes of arguments: the finite partition that tests and conditions induce, with representatives."""

from dataclasses import field
from functools import cached_property
from itertools import product

from exover.dataclass import dataclass
from exover.loop.finite.argument_loader import ArgumentLoader
from exover.loop.finite.argument_samples import ArgumentSamples
from exover.loop.finite.past_classes import PastClasses
from exover.loop.finite.tested_bounds import TestedBounds
from exover.loop.tracked_predicates import TrackedPredicates
from exover.model.evaluate import Scope, bind, holds
from exover.model.event import Args
from exover.model.model import Model
from exover.model.state import State, resting
from exover.model.types import ordinal
from exover.ocrd.tables import NONE, OrderRow, RequestRow, Tables
from exover.ocrd.vector import LEFT, RIGHT, rank


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
    _weights: dict[tuple[Args, tuple[int, ...]], tuple[int, ...]] = field(default_factory=dict)
    _part_weights: dict[tuple[tuple[int, ...], Args, tuple[int, ...]], list[int]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.row: RequestRow = self.tables.requests[self.request]
        declared = self.model.requests[self.request]
        self.params, self.results = declared.params, declared.results
        self.conditions = tuple(dict.fromkeys(self.tracked.conditions.get(declared.name, ())))
        orders = self.tables.orders[self.row.orders : self.row.orders_end]
        tested = [order for order in orders if order.right < 0]
        self.tracked_orders = self._tracked_orders({(order.left, order.right) for order in tested})
        self.poster_orders: tuple[OrderRow, ...] = (*tested, *self.tracked_orders)
        self.inner_orders: tuple[OrderRow, ...] = tuple(o for o in orders if o.right >= 0)
        self.loader = ArgumentLoader(self.model, self.tables, self.bounds, self.request, self.inner_orders)
        compared = (*self.inner_orders, *self.poster_orders)
        self.sampler = ArgumentSamples(self.model, self.tables, self.bounds, self.tracked, self.request, compared)
        self.result_samples = self.sampler.of_results()
        self.samples = self.sampler.of_arguments()
        tracked_past = self.tracked.pasts.get(declared.name)
        self.pasts = PastClasses(self.loader, tracked_past, self.nothing, self.samples, self.result_samples)

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

    def with_orders(self, args: Args, choice: tuple[int, ...]) -> dict[int, int]:
        """Return the loaded entries with the comparisons with posters, which have the values of `choice`."""
        return self.loader.loaded(args) | dict(self.compared(choice))

    def compared(self, choice: tuple[int, ...]) -> list[tuple[int, int]]:
        """Return the entries that compare arguments with posters, with the values of `choice`."""
        pairs = zip(self.poster_orders, choice, strict=True)
        return [(order.entry, value) for order, value in pairs if order.entry != NONE]

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
            read = self.loader.looked_at(feature.predicate) | {feature.weight} - {NONE}
            found.setdefault(tuple(sorted(read)), []).append(number)
        return found

    def _weight(self, number: int, args: Args, entries: dict[int, int]) -> int:
        """Return the weight of arguments in a feature; 0 if its predicate is false of them."""
        feature = self.tables.features[self.row.features + number]
        if not self.loader.agrees(feature.predicate, entries):
            return 0
        return 1 if feature.weight == NONE else ordinal(self.params[feature.weight].type, args[feature.weight])

    def cell_of(self, args: Args) -> Cell:
        """Return the cell of concrete arguments."""
        return self.cells[0] if len(self.cells) == 1 else self._by_sign[self._sign(args)]

    def _sign(self, args: Args) -> tuple[object, ...]:
        """Return the signature of a cell: the outcomes of tests of loaded entries, and the signature of the class."""
        return self._loaded_sign(args), self._class_sign(args)

    def _loaded_sign(self, args: Args) -> tuple[int, ...]:
        return tuple([self.bounds.sign(entry, value) for entry, value in self.loader.loaded(args).items()])

    def _tracked_sign(self, args: Args) -> tuple[object, ...]:
        """Return the part of the signature that conditions need: their truth, values in sums, ranks among constants."""
        scope = Scope(bind(self.params, args))
        truths = tuple(holds(self.model, self.nothing, cond, scope) for cond in self.conditions)
        name = self.model.requests[self.request].name
        pairs = zip(self.params, args, strict=True)
        exact = tuple(value for p, value in pairs if self.tracked.constants(name, p.name).exact)
        return truths, exact, tuple(self._rank(order.left, args) for order in self.poster_orders)

    def _rank(self, number: int, args: Args) -> int:
        return rank(self.sampler.cuts(number), float(args[number]))

    def _weight_signs(self, args: Args, choice: tuple[int, ...]) -> tuple[int, ...]:
        features = self.tables.features[self.row.features : self.row.features_end]
        pairs = zip(features, self.weights(args, choice), strict=True)
        return tuple(w if f.weight == NONE else self.bounds.sign(f.running, w) for f, w in pairs)

    def _class_sign(self, args: Args) -> tuple[object, ...]:
        """Return the signature of a class: conditions, weights, pasts, and what is produced at an ok."""
        produced = self.tables.amounts[self.row.produces : self.row.produces_end]
        entries = self.loader.loaded(args)
        return (
            self._tracked_sign(args),
            tuple(self._weight_signs(args, choice) for choice in self.choices()),
            self.pasts.signs(args),
            tuple(self.loader.agrees(amount.predicate, entries) for amount in produced),
        )

    @cached_property
    def cells(self) -> list[Cell]:
        """The cells, computed when first needed, since that takes long if there are thousands."""
        if len(self.samples) == 1:  # nothing tells these arguments apart
            args = self.samples[0]
            return [Cell(0, args, tuple(self.loader.loaded(args).items()), 0)]
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
                found[sign] = Cell(len(found), args, tuple(self.loader.loaded(args).items()), number)
        return found


def all_arguments(model: Model, tables: Tables, bounds: TestedBounds, tracked: TrackedPredicates) -> list[Arguments]:
    """Return the arguments of each request; raises `TooLarge` if one has more than `MOST_SAMPLES` samples."""
    start = resting(model)
    return [Arguments(model, tables, bounds, tracked, number, start) for number in range(len(model.requests))]
