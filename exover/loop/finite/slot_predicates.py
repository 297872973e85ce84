"""Conditions on slots, waiting places and pasts, as guards and as sets of states."""

from collections.abc import Iterator
from itertools import product
from typing import Generic

from exover.loop.finite.state_sets import S, StateSets
from exover.loop.finite.variables import StateGuard
from exover.model.evaluate import Scope, bind, holds
from exover.model.expression import Cond, Outcome
from exover.model.index import ModelIndex
from exover.model.model import Parameter
from exover.model.state import resting
from exover.model.types import Value
from exover.ocrd.memory import CLEARING, RUNNING, STOPPING, WAITING
from exover.ocrd.vector import LEFT, OUTCOMES, RIGHT, Vocabulary

ParameterOrders = dict[tuple[str, str], int]
"""Maps the names of a parameter and a real poster to how they compare, as in an `Order`."""


class SlotPredicates(Generic[S]):
    """Conditions on slots, waiting places and pasts of the finite loop."""

    def __init__(self, space: StateSets[S]) -> None:
        self.space = space
        self.loop = space.loop
        self.model = space.loop.model
        index = ModelIndex(self.model)
        self.request, self.variable, self.stock = index.request, index.reading, index.stock
        self.thresholds = Vocabulary(self.model).thresholds
        self._nothing = resting(self.model)

    def slot_orders(self, request: int, slot: int) -> Iterator[tuple[StateGuard, ParameterOrders]]:
        """Yield each outcome of comparing a slot's arguments with posters, after the guard of its states."""
        arguments, remembered = self.loop.arguments[request], self.loop.arguments[request].remembered
        for choice in product(range(LEFT, RIGHT + 1), repeat=len(remembered)):
            guard = tuple((self.loop.index["order", slot, k], frozenset({choice[k]})) for k in remembered)
            orders = {}
            for which in remembered:
                order = arguments.poster_orders[which]
                name = self.model.requests[request].params[order.left].name
                orders[name, self.loop.names[-1 - order.right]] = choice[which]
            yield guard, orders

    def slots(self, request: int) -> range:
        """Return the numbers of a request's slots."""
        row = self.loop.tables.requests[request]
        return range(row.slots, row.slots + row.instances)

    def in_slot(self, slot: int, once_stopped: bool) -> S:
        """Return the states in which this slot is active or, if `once_stopped`, running."""
        return self.space.among(self.loop.index["phase", slot], (RUNNING,) if once_stopped else (RUNNING, STOPPING))

    def of_class(self, slot: int, number: int) -> S:
        """Return the states in which this slot holds arguments of this class."""
        var = self.loop.index.get(("class", slot))
        return self.space.all if var is None else self.space.is_value(var, number)

    def waiting(self, request: str) -> S:
        """Return the states in which the request's waiting place is taken."""
        var = self.loop.index.get(("place", self.request[request]))
        return self.space.none if var is None else self.space.among(var, (WAITING, CLEARING))

    def guarded(self, guard: StateGuard) -> S:
        """Return the states that a guard describes."""
        return self.space.conjunction(self.space.among(var, values) for var, values in guard)

    def guards(
        self, phase: str, request: str, where: Cond | None, once_stopped: bool, scope: Scope | None
    ) -> Iterator[StateGuard]:
        """Yield, for each slot or place, the guard that it is in this phase with arguments that satisfy `where`."""
        number = self.request[request]
        arguments = self.loop.arguments[number]
        params = self.model.requests[number].params
        if phase == "waiting":
            if ("place", number) in self.loop.index:
                args = [cell.args for cell in arguments.cells]
                taken = frozenset({WAITING, CLEARING})
                yield self.guard(("place", number), ("cell", number), taken, self._which(args, params, where, scope))
            return
        phases = {"active": {RUNNING, STOPPING}, "running": {RUNNING}, "stopping": {STOPPING}}[phase]
        phases -= {STOPPING} if once_stopped else set()
        args = [kind.args for kind in arguments.classes]
        which = self._which(args, params, where, scope)
        for slot in self.slots(number):
            yield self.guard(("phase", slot), ("class", slot), frozenset(phases), which)

    def guard(
        self, owner: tuple[object, ...], kind: tuple[object, ...], phases: frozenset[int], which: frozenset[int]
    ) -> StateGuard:
        """Return the guard that the owner is in one of these phases, with arguments of these classes or cells."""
        guard: StateGuard = ((self.loop.index[owner], phases),)
        if kind in self.loop.index:
            return (*guard, (self.loop.index[kind], which))
        return guard if which else ((self.loop.index[owner], frozenset()),)

    def _which(
        self, args: list[tuple[Value, ...]], params: tuple[Parameter, ...], where: Cond | None, scope: Scope | None
    ) -> frozenset[int]:
        """Return the numbers of the argument tuples that satisfy `where`."""
        own = (scope or Scope()).params
        found = set()
        for number, values in enumerate(args):
            inner = Scope(bind(params, values), own)
            if where is None or holds(self.model, self._nothing, where, inner):
                found.add(number)
        return frozenset(found)

    def past_of(self, request: str, where: Cond | None, scope: Scope | None) -> S:
        """Return the states in which the request has a past that satisfies `where`."""
        number = self.request[request]
        arguments = self.loop.arguments[number]
        fields = (*arguments.params, *arguments.results)
        those = self._which(arguments.pasts.representatives, fields, where, scope)
        return self.space.among(self.loop.index["past", number], [1 + kind for kind in those])

    def ended(self, request: str, outcome: Outcome) -> S:
        """Return the states in which the last instance of the request ended with this outcome."""
        return self.space.is_value(self.loop.index["last", self.request[request]], OUTCOMES.index(outcome))
