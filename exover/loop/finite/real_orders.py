"""Comparisons of reals that change with each other, as of an argument with a poster.

The loop keeps only how they compare: less, equal or greater. Which of these are feasible depends on the intervals in
which both lie. That two arguments bound each other through one poster is not modelled: this is an over-approximation,
so a run of the loop may have no concrete one, which its replay finds out.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from itertools import pairwise, product

from exover.dataclass import dataclass
from exover.loop.finite.argument_classes import Arguments, Cell
from exover.loop.finite.tested_bounds import points
from exover.loop.tracked_predicates import TrackedPredicates
from exover.model.event import Ask, Event, Observe
from exover.model.model import Model
from exover.model.state import State
from exover.model.types import Value
from exover.ocrd.entries import compare
from exover.ocrd.tables import Tables
from exover.ocrd.vector import rank


@dataclass(frozen=True)
class RealCells:
    """The cells of a real: the partition of `low .. high` by `cuts`, each cut a cell of its own."""

    low: float
    high: float
    cuts: tuple[float, ...]

    @cached_property
    def samples(self) -> tuple[float, ...]:
        """One value for each cell."""
        found: dict[int, float] = {}
        for point in points(self.low, self.high, self.cuts, 1):
            found.setdefault(rank(self.cuts, point), point)
        return tuple(found.values())

    def beside(self, value: float, grid: tuple[float, ...]) -> list[float]:
        """Return values in the same cell: the points of the grid there, and two between any two of them."""
        return [v for v in points(self.low, self.high, grid, 2) if rank(self.cuts, v) == rank(self.cuts, value)]

    def cell(self, value: float) -> int:
        """Return the number of the cell of a value."""
        return [rank(self.cuts, sample) for sample in self.samples].index(rank(self.cuts, value))


def poster_cells(model: Model, tables: Tables, tracked: TrackedPredicates, number: int) -> RealCells:
    """Return the cells of real poster `number`: its constants, and arguments of required launches compared with it."""
    row = tables.variables[number]
    cuts = {*tables.reals[row.cuts : row.cuts_end], *tracked.cuts.get((None, model.variables[number].name), ())}
    for launch, its in zip(model.launches, tables.launches, strict=True):
        request = tables.requests[its.request]
        for order in tables.orders[request.orders : request.orders_end]:
            if order.right == -1 - number:
                cuts.add(float(launch.args[order.left]))
    return RealCells(tables.reals[row.low], tables.reals[row.high], tuple(sorted(cuts)))


@dataclass(frozen=True)
class RealOrders:
    """The feasible comparisons of one request's arguments with posters; `posters`: their cells, by number."""

    arguments: Arguments
    posters: dict[int, RealCells]

    def feasible(self, which: int, value: float, cell: int) -> tuple[int, ...]:
        """Return the feasible outcomes of `poster_orders[which]` for an argument in the cell of `value`, a poster in
        this one.
        """
        order = self.arguments.poster_orders[which]
        row = self.arguments.tables.params[self.arguments.row.params + order.left]
        reals, poster = self.arguments.tables.reals, self.posters[-1 - order.right]
        mine = RealCells(reals[row.low], reals[row.high], self.arguments.sampler.cuts(order.left))
        return feasible(mine, poster, value, poster.samples[cell])


def feasible(left: RealCells, right: RealCells, mine: float, its: float) -> tuple[int, ...]:
    """Return the feasible outcomes of comparing two reals that are in the cells of these values."""
    grid = tuple(sorted({*left.cuts, *right.cuts, left.low, left.high, right.low, right.high}))
    return tuple(sorted({compare(*pair) for pair in product(left.beside(mine, grid), right.beside(its, grid))}))


def candidates(event: Event, cell: Cell | None, arguments: Arguments | None, state: State) -> Iterator[Event]:
    """Yield `event` and variants of it whose reals are at, between or near those that `state` holds."""
    yield event
    live = sorted({v for v in _live(state) if isinstance(v, float)})
    between = [left + (right - left) / 2 for left, right in pairwise(live)]
    around = [*live, *between]
    match event:
        case Observe(_, float(value)):
            for other in (*around, *(value + (v - value) / 2 for v in live)):
                yield replace(event, value=other)
        case Ask(_, args) if arguments is not None and cell is not None:
            sides = {order.left for order in arguments.poster_orders}
            choices: list[tuple[Value, ...]] = [
                (v, *around, *(v + (other - v) / 2 for other in live)) if k in sides and isinstance(v, float) else (v,)
                for k, v in enumerate(args)
            ]
            for values in product(*choices):
                yield replace(event, args=values)
        case _:
            pass


def _live(state: State) -> Iterator[Value]:
    """Yield the values in a state: readings, arguments in slots and waiting places."""
    yield from state.readings.values()
    for slots in state.slots.values():
        for slot in slots:
            yield from slot.args if slot else ()
    for place in state.places.values():
        yield from place.args if place else ()
