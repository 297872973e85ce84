"""Do the decoded tables decide as the rules say, in every state and for all arguments?

The rules are read once more into diagrams, unsorted and with nothing left out, over quantities that are evaluated on
the model; the tables are followed beside them. Two diagrams agree iff no state leads to two different actions; where
they are alike that is seen without sets of states.
"""

from collections.abc import Iterable, Iterator
from dataclasses import field
from functools import cached_property, partial
from itertools import product

from exover.dataclass import dataclass
from exover.engines.bdd.loopsets import LoopSets
from exover.engines.bdd.manager import Set
from exover.engines.bdd.space import Space
from exover.equivalence.diagram_equivalence import (
    alike,
    different_diagrams,
    differing,
    listed,
    same_action,
)
from exover.equivalence.entry_equivalence import plain_entries
from exover.equivalence.record_equivalence import Records, different_for_all
from exover.loop.finite.argument_classes import Cell
from exover.loop.finite.builder import ClosedLoop
from exover.loop.finite.predicates import StatePredicates
from exover.loop.finite.slot_predicates import ParameterOrders
from exover.loop.finite.tested_bounds import TooLarge
from exover.loop.finite.variables import GuardedValue
from exover.model.evaluate import Scope, applies, bind
from exover.model.event import Args
from exover.model.expression import Cond, Param, Reading
from exover.model.model import Request, Rule
from exover.model.types import Type, Value, ordinal
from exover.ocrd.decision_context import DecisionContext
from exover.ocrd.demand import Decider
from exover.ocrd.diagram import Act, Manager, deep
from exover.ocrd.entries import compare
from exover.ocrd.roots import composed
from exover.ocrd.tables import NONE, Node
from exover.ocrd.vector import Arg, ArgRank, Element, Order, Quantity, Vocabulary, rank


@dataclass(frozen=True)
class StateComparison:
    """Compares tables with rules: as they stand, and where they are not alike over a space of states."""

    sets: LoopSets
    _decisions: dict[str, bool] = field(default_factory=dict)
    _entries: dict[int, int | None] = field(default_factory=dict)
    _seen: dict[int, int | None] = field(default_factory=dict)
    _values: dict[int, dict[int, Set]] = field(default_factory=dict)

    @cached_property
    def loop(self) -> ClosedLoop:
        """The closed loop of the tables."""
        return self.sets.loop

    @property
    def meaning(self) -> StatePredicates[Set]:
        """Conditions of the model as sets."""
        return self.sets.meaning

    @property
    def space(self) -> Space:
        """Sets of states."""
        return self.sets.space

    def asking(self, rule: Rule) -> list[Request]:
        """Return the requests on whose decision a rule is in question."""
        return [self.loop.model.request[name] for name in self.questions.asking(rule)]

    @cached_property
    def questions(self) -> DecisionContext:
        """What decisions need to know of the model."""
        return DecisionContext(Vocabulary(self.loop.model))

    @cached_property
    def plain(self) -> dict[int, Element]:
        """What entries count, where the records say that plainly."""
        return plain_entries(self.loop.model, self.loop.tables)

    def entry(self, element: int) -> int | None:
        """Return the entry of the tables that is the element of this number; None if there is none."""
        if element not in self._entries:
            self._entries[element] = self.loop.entry_of.get(self.questions.numbers.elements[element])
        return self._entries[element]

    def values(self, element: int) -> dict[int, Set]:
        """Return for each value of an element of the state the states in which it has it, by the model."""
        if element not in self._values:
            terms = self.questions.numbers.elements[element]
            pairs = [(factor, term) for factor, quantity in terms for term in self.meaning.quantity(quantity)]
            self._values[element] = self.space.sum_of(pairs)
        return self._values[element]

    def decides(self, request: Request) -> bool:
        """Return whether in every state, for all arguments, the tables decide on a newcomer as the rules do."""
        if request.name not in self._decisions:
            self._decisions[request.name] = self._decides(request)
        return self._decisions[request.name]

    def _decides(self, request: Request) -> bool:
        number = self.loop.request_number[request.name]
        its = self.loop.tables.requests[number].decide
        with deep():
            manager = Manager()
            decision = Decider(self.questions, manager).decide(request)
            if listed(manager, decision, self.loop.tables.nodes, its, self._sure, self.same):
                return True
            manager, root = composed(manager, decision)
        if self._alike(manager, root, its):
            return True
        found = self.space.none
        arguments = self.loop.arguments[number]
        for cell, choice in product(arguments.cells, arguments.choices()):
            fixed = arguments.with_orders(cell.args, choice)
            pairing = _Pairing(self, manager, request, cell.args, fixed, self._compared(number, choice))
            found |= pairing.differ(root, its, self.space.all)
        return bool(self._possible(found) == self.space.none)

    def _alike(self, manager: Manager, diagram: int, root: int) -> bool:
        return alike(manager, diagram, self.loop.tables.nodes, root, self._sure, self.same)

    def _sure(self, element: int) -> int | None:
        """Return the entry that is an element; None for one of arguments of which it is not seen that they are it."""
        if element not in self._seen:
            entry, terms = self.entry(element), self.questions.numbers.elements[element]
            seen = entry is not None and self.plain.get(entry) == terms
            self._seen[element] = entry if seen or not any(_is_argument(quantity) for _, quantity in terms) else None
        return self._seen[element]

    def same(self, mine: Act, its: Node) -> bool:
        """Return whether two action nodes say the same."""
        return same_action(mine, its, self.loop.tables, self.loop.request_number, self.loop.reasons)

    def where(
        self, manager: Manager, condition: int, number: int, cell: Cell, choice: tuple[int, ...], states: Set
    ) -> Set:
        """Return those of `states` in which a condition of a diagram holds of a newcomer with these arguments."""
        request, arguments = self.loop.model.requests[number], self.loop.arguments[number]
        fixed = arguments.with_orders(cell.args, choice)
        pairing = _Pairing(self, manager, request, cell.args, fixed, self._compared(number, choice))
        return pairing.differ(condition, NONE, states)

    def holding(self, manager: Manager, condition: int, states: Set) -> Set:
        """Return those of `states` in which a condition of a diagram holds that is not about a newcomer."""
        return self._plain(manager, condition, NONE, states)

    def _compared(self, number: int, choice: tuple[int, ...]) -> ParameterOrders:
        """Return how arguments of the request compare with posters, by the names of both."""
        loop = self.loop
        params = loop.model.requests[number].params
        pairs = zip(loop.arguments[number].poster_orders, choice, strict=True)
        return {(params[order.left].name, loop.names[-1 - order.right]): value for order, value in pairs}

    def _possible(self, states: Set) -> Set:
        """Return those of `states` whose variables all have one of their values.

        What two diagrams do is told state by state, and each tests few variables: following them through sets that
        constrain all would cost as many times more as there are requests.
        """
        return states & self.space.domain if states != self.space.none else states

    def _plain(self, manager: Manager, diagram: int, root: int, states: Set) -> Set:
        return _Pairing(self, manager, None, (), {}, {}).differ(diagram, root, states)

    def _same(self, manager: Manager, diagram: int, root: int) -> bool:
        """Return whether a diagram of the tables does, in every state, what that of the rules does."""
        if self._alike(manager, diagram, root):
            return True
        return bool(self._possible(self._plain(manager, diagram, root, self.space.all)) == self.space.none)

    def differences(self) -> Iterator[str]:
        """Yield what every step needs and the tables have otherwise: entries, rules, launches, latches."""
        yield from different_for_all(self.records)
        yield from self._different_entries()
        yield from different_diagrams(self.questions, self.loop.tables, self.loop.reasons, self._same)

    @cached_property
    def records(self) -> Records:
        """The records of the tables, to be compared with the model."""
        return Records(self.loop.model, self.loop.tables, self.loop.entries, partial(_same_predicate, self.loop))

    def _different_entries(self) -> Iterator[str]:
        """Yield the entries of the vector that a state fixes and the tables count otherwise."""
        for entry, element in enumerate(self.loop.entries):
            if self.plain.get(entry) == element or any(_is_argument(quantity) for _, quantity in element):
                continue
            pairs = [(factor, term) for factor, quantity in element for term in self.meaning.quantity(quantity)]
            mine, its = self.space.sum_of(pairs), self.space.distribution(entry)
            found = self.space.none
            for value in mine.keys() | its.keys():
                found |= self.space.bdd.apply("^", mine.get(value, self.space.none), its.get(value, self.space.none))
            if self._possible(found) != self.space.none:
                yield f"entry {entry} of the state vector"
            if not self._starts(entry, pairs):
                yield f"the initial value of entry {entry}"

    def _starts(self, entry: int, terms: Iterable[tuple[int, GuardedValue]]) -> bool:
        """Return whether every test of the entry's initial value turns out in the initial state as it should."""
        loop = self.loop
        value = sum(
            factor * weight
            for factor, term in terms
            for guard, weight in term
            if all(loop.variables[var].initial in values for var, values in guard)
        )
        return loop.bounds.sign(entry, value) == loop.bounds.sign(entry, loop.tables.entries[entry].initial)


def _is_argument(quantity: Quantity) -> bool:
    """Return whether a quantity is of the arguments that are looked at, and not of the state."""
    return isinstance(quantity, Arg | ArgRank) or (isinstance(quantity, Order) and quantity.request is not None)


@dataclass
class _Pairing:
    """Follows two diagrams at once, for one newcomer with given arguments."""

    whole: StateComparison
    manager: Manager
    request: Request | None
    args: Args
    fixed: dict[int, int]
    orders: ParameterOrders
    _known: dict[int, dict[int, Set]] = field(default_factory=dict)

    def differ(self, diagram: int, root: int, states: Set) -> Set:
        """Return the states of `states` in which the two do different things."""
        return differing(self.manager, diagram, self.whole.loop.tables.nodes, root, states, self)

    @property
    def none(self) -> Set:
        """No state."""
        return self.whole.space.none

    def either(self, one: Set, other: Set) -> Set:
        """Return the states of both."""
        return one | other

    def tested(self, states: Set, entry: int, bound: int) -> tuple[Set, Set]:
        """Return those in which the entry of the tables is at most `bound`, and the others."""
        low: Set = states & self.whole.space.test(entry, bound, self.fixed)
        return low, states & ~low

    def between(self, states: Set, element: int, above: int | None, most: int | None) -> Set:
        """Return those in which the element of this number is more than `above`, and `most` at most."""
        found = self.whole.space.none
        for value, where in self._values(element).items():
            if (above is None or value > above) and (most is None or value <= most):
                found |= where
        return states & found

    def entry(self, element: int) -> int | None:
        """Return the entry of the tables that is the element of this number; None if there is none."""
        return self.whole.entry(element)

    def same(self, mine: Act, its: Node) -> bool:
        """Return whether two actions are the same."""
        return self.whole.same(mine, its)

    def _values(self, element: int) -> dict[int, Set]:
        """Return for each value of an element the states in which it has it, by the model; asked once."""
        if element not in self._known:
            self._known[element] = self._summed(element)
        return self._known[element]

    def _summed(self, element: int) -> dict[int, Set]:
        quantities = self.whole.questions.numbers.elements[element]
        if not any(_is_argument(quantity) for _, quantity in quantities):
            return self.whole.values(element)
        constant = 0
        terms = []
        for factor, quantity in quantities:
            fixed = self._argument(quantity)
            if fixed is None:
                terms += [(factor, term) for term in self.whole.meaning.quantity(quantity)]
            else:
                constant += factor * fixed
        return {value + constant: states for value, states in self.whole.space.sum_of(terms).items()}

    def _argument(self, quantity: Quantity) -> int | None:
        """Return the value of a quantity that the arguments fix; None for another."""
        match quantity:
            case Arg(_, name):
                return ordinal(self._type(name), self._value(name))
            case ArgRank(request, name):
                return rank(self.whole.questions.vocabulary.thresholds[request, name], float(self._value(name)))
            case Order(str(), Param(left), Param(right)):
                return compare(float(self._value(left)), float(self._value(right)))
            case Order(str(), Param(param), Reading(poster)):
                if (param, poster) not in self.orders:
                    raise TooLarge(f"`{param}` is compared with `{poster}` as the tables do not compare it")
                return self.orders[param, poster]
            case _:
                return None

    def _value(self, name: str) -> Value:
        assert self.request is not None
        return bind(self.request.params, self.args)[name]

    def _type(self, name: str) -> Type:
        assert self.request is not None
        return self.whole.questions.vocabulary.parameter_types[self.request.name, name]


def _same_predicate(loop: ClosedLoop, number: int, predicate: int, where: Cond | None, results: bool) -> bool:
    """Return whether a predicate of the tables is true of the arguments of which a condition is."""
    arguments = loop.arguments[number]
    held = [cell.args for cell in arguments.cells]
    if results:
        held = [kind.args + more for kind in arguments.classes for more in arguments.result_samples]
    params = (*arguments.params, *arguments.results) if results else arguments.params
    return all(
        arguments.loader.agrees(predicate, arguments.loader.loaded(values))
        == applies(loop.model, arguments.nothing, where, Scope(bind(params, values)))
        for values in held
    )
