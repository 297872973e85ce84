"""Conditions of the model as sets of the loop's states, computed from the model alone."""

from collections.abc import Iterator
from typing import assert_never

from exover.loop.finite.slot_predicates import ParameterOrders, SlotPredicates
from exover.loop.finite.state_sets import S
from exover.loop.finite.tested_bounds import TooLarge
from exover.loop.finite.variables import GuardedValue
from exover.model.evaluate import OPERATORS, Scope, bind, holds, value_of
from exover.model.event import Args
from exover.model.expression import (
    And,
    Compare,
    Cond,
    Const,
    Count,
    Last,
    Level,
    ModelTerm,
    Not,
    Or,
    Own,
    Param,
    Past,
    Reading,
    Status,
    Sum,
    Used,
    leaves,
)
from exover.model.model import Rule
from exover.model.types import Real, ordinal
from exover.ocrd.memory import CLEARING, RUNNING, STOPPING, WAITING
from exover.ocrd.vector import (
    LEFT,
    OUTCOMES,
    RIGHT,
    SAME,
    Arg,
    ArgRank,
    HasPast,
    InPlace,
    LastOutcome,
    Order,
    PlaceValue,
    Quantity,
    Rank,
    Slots,
    SlotValue,
    Stock,
    VariableValue,
    rank,
)

Cases = list[tuple[int, GuardedValue]]
"""The factors and terms of an integer expression `constant + sum(factor * term)`."""


class StatePredicates(SlotPredicates[S]):
    """Truth sets of conditions; `once_stopped`: with stopping slots as idle."""

    def rule(self, rule: Rule, once_stopped: bool) -> S:
        """Return the states in which the F of a rule holds."""
        if rule.slot_of is None:
            return self.truth(rule.condition, once_stopped)
        return self.space.disjunction(self._by_slot(rule, self.request[rule.slot_of], once_stopped))

    def _by_slot(self, rule: Rule, request: int, once_stopped: bool) -> Iterator[S]:
        """Yield the states in which the F of a rule holds of one slot, with arguments of one class."""
        for slot in self.slots(request):
            for number, kind in enumerate(self.loop.arguments[request].classes):
                held = self.space.conjunction((self.in_slot(slot, once_stopped), self.of_class(slot, number)))
                scope = Scope(bind(self.model.requests[request].params, kind.args))
                for chosen, orders in self.slot_orders(request, slot):
                    truth = self.truth(rule.condition, once_stopped, scope, orders)
                    yield self.space.conjunction((held, self.guarded(chosen), truth))

    def truth(
        self, cond: Cond, once_stopped: bool = False, scope: Scope | None = None, orders: ParameterOrders | None = None
    ) -> S:
        """Return the states in which a condition holds.

        The parameters of its subject have the values of `scope`, and compare with real posters as `orders` says.
        """
        match cond:
            case Compare():
                return self._compare(cond, once_stopped, scope, orders or {})
            case Status(phase, request, where):
                return self.space.disjunction(
                    map(self.guarded, self.guards(phase, request, where, once_stopped, scope))
                )
            case Past(request, where):
                return self.past_of(request, where, scope)
            case Last(request, outcome):
                return self.ended(request, outcome)
            case Not(part):
                return self.space.complement(self.truth(part, once_stopped, scope, orders))
            case And(parts):
                return self.space.conjunction(self.truth(each, once_stopped, scope, orders) for each in parts)
            case Or(parts):
                return self.space.disjunction(self.truth(each, once_stopped, scope, orders) for each in parts)
            case _:
                assert_never(cond)

    # ---- quantities ----

    def quantity(self, quantity: Quantity) -> list[GuardedValue]:
        """Return the terms whose sum is a quantity of the state; raises `TooLarge` for other quantities."""
        match quantity:
            case VariableValue(name):
                return [term for _, term in self._linear_reading(name)]
            case Rank(name):
                number = self.variable[name]
                cuts = self.thresholds.get((None, name), ())
                ranks = [rank(cuts, float(value)) for value in self.loop.samples[number]]
                return [self._by_value(self.loop.index["reading", number], ranks)]
            case Stock(resource):
                var = self.loop.index.get(("level", self.stock[resource]))
                if var is None:
                    raise TooLarge(f"the level of `{resource}`, which no table tests, is not followed")
                return [self._by_value(var, list(range(self.loop.variables[var].size)))]
            case HasPast(request, where):
                arguments = self.loop.arguments[self.request[request]]
                kinds = arguments.pasts.representatives
                those = self._which(kinds, (*arguments.params, *arguments.results), where, None)
                truths = [int(kind in those) for kind in range(len(kinds))]
                return [self._by_value(self.loop.index["past", self.request[request]], [0, *truths])]
            case LastOutcome(request):
                return [self._by_value(self.loop.index["last", self.request[request]], list(range(len(OUTCOMES))))]
            case Slots(request, slot, where, phase):
                slots = self.slots(self.request[request])
                return [self._counted(request, at, where, phase) for at in (slots if slot is None else [slots[slot]])]
            case InPlace(request, where, phase):
                phases = frozenset({WAITING if phase == "waiting" else CLEARING})
                guards = list(self.guards("waiting", request, where, False, None))
                return [((((guard[0][0], guard[0][1] & phases), *guard[1:]), 1),) for guard in guards]
            case SlotValue(request, slot, param):
                return [self._slot_value(self.request[request], slot, param)]
            case PlaceValue(request, param):
                return self._place_value(self.request[request], param)
            case Order(None, Reading(left), Reading(right)):
                var, flipped = self._pair(left, right)
                return [self._by_value(var, [RIGHT, SAME, LEFT] if flipped else [LEFT, SAME, RIGHT])]
            case Order() | Arg() | ArgRank():
                raise TooLarge("two reals that change are compared")
            case _:
                assert_never(quantity)

    def _counted(self, request: str, at: int, where: Cond | None, phase: str) -> GuardedValue:
        """Return a term: 1 if a slot is in this phase and its arguments satisfy `where`, which may read posters."""
        number = self.request[request]
        params = self.model.requests[number].params
        phases = frozenset({RUNNING if phase == "running" else STOPPING})
        cases = []
        for chosen, orders in self.slot_orders(number, at):
            which = set()
            for k, kind in enumerate(self.loop.arguments[number].classes):
                scope = Scope(bind(params, kind.args))
                if where is None or self.truth(where, False, scope, orders) == self.space.all:
                    which.add(k)
            guard = self.guard(("phase", at), ("class", at), phases, frozenset(which))
            cases.append(((*guard, *chosen), 1))
        return tuple(cases)

    def _by_value(self, var: int, numbers: list[int]) -> GuardedValue:
        return tuple((((var, frozenset({value})),), number) for value, number in enumerate(numbers))

    def _slot_value(self, request: int, slot: int, param: str) -> GuardedValue:
        at = self.slots(request)[slot]
        kinds = [each.args for each in self.loop.arguments[request].classes]
        return self._held_value(request, param, ("phase", at), ("class", at), {RUNNING, STOPPING}, kinds)

    def _place_value(self, request: int, param: str) -> list[GuardedValue]:
        if ("place", request) not in self.loop.index:
            return []
        kinds = [each.args for each in self.loop.arguments[request].cells]
        taken = {WAITING, CLEARING}
        return [self._held_value(request, param, ("place", request), ("cell", request), taken, kinds)]

    def _held_value(
        self,
        request: int,
        param: str,
        owner: tuple[object, ...],
        kind: tuple[object, ...],
        phases: set[int],
        kinds: list[Args],
    ) -> GuardedValue:
        """Return a term: the value of a parameter that an owner has while it is in one of these phases, else 0."""
        params = self.model.requests[request].params
        (declared,) = (parameter.type for parameter in params if parameter.name == param)
        cases = []
        for number, args in enumerate(kinds):
            guard = self.guard(owner, kind, frozenset(phases), frozenset({number}))
            cases.append((guard, ordinal(declared, bind(params, args)[param])))
        return tuple(cases)

    # ---- comparisons ----

    def _ordered(self, cond: Compare, orders: ParameterOrders) -> bool | None:
        """Return the outcome of comparing a parameter with a real poster; None for another comparison."""
        match cond.left, cond.right:
            case Param(param), Reading(poster) if (param, poster) in orders:
                return OPERATORS[cond.operator](orders[param, poster], SAME)
            case Reading(poster), Param(param) if (param, poster) in orders:
                return OPERATORS[cond.operator](SAME, orders[param, poster])
            case _:
                return None

    def _compare(self, cond: Compare, once_stopped: bool, scope: Scope | None, orders: ParameterOrders) -> S:
        ordered = self._ordered(cond, orders)
        if ordered is not None:
            return self.space.all if ordered else self.space.none
        match cond.left, cond.right:
            case Reading(one), Reading(two) if isinstance(self.loop.types[self.variable[one]], Real):
                return self._compare_posters(cond, one, two)
            case _:
                pass
        terms = [*leaves(cond.left), *leaves(cond.right)]
        if all(isinstance(term, Const | Param | Own) for term in terms):
            return self.space.all if holds(self.model, self._nothing, cond, scope or Scope()) else self.space.none
        readings = (term.name for term in terms if isinstance(term, Reading))
        symbols = [name for name in readings if not isinstance(self.loop.samples[self.variable[name]][0], int | bool)]
        if len(symbols) == 1:  # two enums of one type are compared by their ordinals
            return self._compare_values(cond, symbols[0], scope)
        left, constant = self._linear(cond.left, once_stopped, scope)
        right, other = self._linear(cond.right, once_stopped, scope)
        sums = self.space.sum_of(left + [(-factor, term) for factor, term in right])
        true = OPERATORS[cond.operator]
        return self.space.disjunction(states for total, states in sums.items() if true(total + constant, other))

    def _compare_posters(self, cond: Compare, left: str, right: str) -> S:
        """Return the states in which a comparison of two real posters is true, by the variable of their order."""
        var, flipped = self._pair(left, right)
        return self.space.among(var, [o for o in (LEFT, SAME, RIGHT) if self._turns_out(cond, o, flipped)])

    def _pair(self, left: str, right: str) -> tuple[int, bool]:
        """Return the variable of the order of two real posters, and whether it compares right with left."""
        var = self.loop.index.get(("pair", self.variable[left], self.variable[right]))
        if var is not None:
            return var, False
        return self.loop.index["pair", self.variable[right], self.variable[left]], True

    def _turns_out(self, cond: Compare, order: int, flipped: bool) -> bool:
        return OPERATORS[cond.operator](*((SAME, order) if flipped else (order, SAME)))

    def _compare_values(self, cond: Compare, name: str, scope: Scope | None) -> S:
        """Return the states in which a real or an enum reading compares so with a constant or a parameter."""
        var = self.loop.index["reading", self.variable[name]]
        found = []
        for cell, value in enumerate(self.loop.samples[self.variable[name]]):
            sides = []
            for term in (cond.left, cond.right):
                if term == Reading(name):
                    sides.append(value)
                elif isinstance(value, float) and not isinstance(term, Const):
                    raise TooLarge(f"`{name}` is compared with another real that changes")
                else:
                    sides.append(value_of(self.model, self._nothing, term, scope or Scope()))
            if OPERATORS[cond.operator](*sides):
                found.append(self.space.is_value(var, cell))
        return self.space.disjunction(found)

    def _linear(self, term: ModelTerm, once_stopped: bool, scope: Scope | None) -> tuple[Cases, int]:
        """Return an integer expression as factors of terms, and a constant."""
        match term:
            case Const(value):
                return [], int(value)
            case Param() | Own():
                return [], int(value_of(self.model, self._nothing, term, scope or Scope()))
            case Reading(name):
                return self._linear_reading(name), 0
            case Level(resource):
                return [(1, term) for term in self.quantity(Stock(resource))], 0
            case Count(requests):
                guards = [g for name in requests for g in self.guards("active", name, None, once_stopped, None)]
                return [(1, ((guard, 1),)) for guard in guards], 0
            case Used(resource):
                return list(self._shares(resource, once_stopped)), 0
            case Sum(constant, parts):
                cases: Cases = []
                for factor, part in parts:
                    more, extra = self._linear(part, once_stopped, scope)
                    cases += [(factor * f, t) for f, t in more]
                    constant += factor * extra
                return cases, constant
            case _:
                assert_never(term)

    def _linear_reading(self, name: str) -> Cases:
        number = self.variable[name]
        return [(1, self._by_value(self.loop.index["reading", number], self.loop.ordinals(number)))]

    def _shares(self, resource: str, once_stopped: bool) -> Iterator[tuple[int, GuardedValue]]:
        for request in self.model.requests:
            for share in request.shares:
                if share.resource == resource:
                    for guard in self.guards("active", request.name, share.when, once_stopped, None):
                        yield 1, ((guard, share.amount),)
