"""Do the decoded tables decide as the rules say, in every state and for all arguments?

The rules are read once more into diagrams, unsorted and with nothing left out, over quantities that are evaluated on
the model; the tables are followed beside them. Two diagrams agree iff no state leads to two different actions.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from heapq import heappop, heappush
from itertools import product

from exover.model.decision import Reason
from exover.model.evaluate import bind
from exover.model.event import Args
from exover.model.expression import Param, Reading
from exover.model.model import Latch, Launch, Request, Rule
from exover.model.types import Type, Value, ordinal
from exover.ocrd import decision as do
from exover.ocrd import tables as t
from exover.ocrd.demand import Decider, Instance, Questions
from exover.ocrd.diagram import NO, Act, Manager, Test, deep
from exover.ocrd.entries import compare
from exover.ocrd.tables import NONE, Node
from exover.ocrd.vector import Arg, ArgRank, Order, Quantity, Vocabulary, rank
from exover.verify.bdd.holdings import Compared
from exover.verify.bdd.meaning import Meaning
from exover.verify.bdd.space import Set, Space
from exover.verify.cells import Cell, TooLarge
from exover.verify.records import unwatched, wrong_conflicts, wrong_rows
from exover.verify.states import Term

CODES: dict[type, int] = {
    do.DoReject: t.REJECT,
    do.DoWait: t.WAIT,
    do.DoClear: t.CLEAR,
    do.DoSettle: t.SETTLE,
    do.DoKill: t.KILL,
    do.DoDismiss: t.DISMISS,
    do.DoLaunch: t.LAUNCH,
    do.DoViolation: t.VIOLATION,
    do.DoAgree: t.AGREE,
}


@dataclass(frozen=True)
class Equivalence:
    """Compares tables with rules over one space of states."""

    space: Space
    meaning: Meaning
    _decisions: dict[str, Set] = field(default_factory=dict)
    _entries: dict[int, int | None] = field(default_factory=dict)
    _values: dict[int, dict[int, Set]] = field(default_factory=dict)

    def prevents(self, rules: Iterable[Rule]) -> bool:
        """Return whether rules can be seen never to be broken: they are false at first, and none but a launch could
        make them true, which the decisions of the tables prevent, being those of the rules in every state.
        """
        return all(
            not self.questions.restored(rule)
            and all(self.decision(request) == self.space.none for request in self.asking(rule))
            for rule in rules
        )

    def asking(self, rule: Rule) -> list[Request]:
        """Return the requests on whose decision a rule is in question."""
        return [self.space.loop.model.request[name] for name in self._in_question.get(id(rule), ())]

    @cached_property
    def _in_question(self) -> dict[int, list[str]]:
        found: dict[int, list[str]] = {}
        for name, rules in self.questions.rules.items():
            for rule in rules:
                found.setdefault(id(rule), []).append(name)
        return found

    @cached_property
    def questions(self) -> Questions:
        """What decisions need to know of the model."""
        return Questions(Vocabulary(self.space.loop.model))

    def entry(self, element: int) -> int | None:
        """Return the entry of the tables that is the element of this number; None if there is none."""
        if element not in self._entries:
            self._entries[element] = self.space.loop.entry_of.get(self.questions.numbers.elements[element])
        return self._entries[element]

    def values(self, element: int) -> dict[int, Set]:
        """Return for each value of an element of the state the states in which it has it, by the model."""
        if element not in self._values:
            terms = self.questions.numbers.elements[element]
            pairs = [(factor, term) for factor, quantity in terms for term in self.meaning.quantity(quantity)]
            self._values[element] = self.space.sum_of(pairs)
        return self._values[element]

    def decision(self, request: Request) -> Set:
        """Return the states in which, for some arguments, the tables decide otherwise on a newcomer of the request."""
        if request.name not in self._decisions:
            self._decisions[request.name] = self._decision(request)
        return self._decisions[request.name]

    def _decision(self, request: Request) -> Set:
        loop = self.space.loop
        number = self.meaning.request[request.name]
        manager = Manager()
        with deep():
            root = Decider(self.questions, manager).decide(request).compose(manager)
        found = self.space.none
        arguments = loop.arguments[number]
        for cell, choice in product(arguments.cells, arguments.choices()):
            fixed = arguments.with_orders(cell.args, choice)
            pairing = _Pairing(self, manager, request, cell.args, fixed, self._compared(number, choice))
            found |= pairing.differ(root, loop.tables.requests[number].decide, self.space.all)
        return self._possible(found)

    def where(
        self, manager: Manager, condition: int, number: int, cell: Cell, choice: tuple[int, ...], states: Set
    ) -> Set:
        """Return those of `states` in which a condition of a diagram holds of a newcomer with these arguments."""
        request, arguments = self.space.loop.model.requests[number], self.space.loop.arguments[number]
        fixed = arguments.with_orders(cell.args, choice)
        pairing = _Pairing(self, manager, request, cell.args, fixed, self._compared(number, choice))
        return pairing.differ(condition, NONE, states)

    def holding(self, manager: Manager, condition: int, states: Set) -> Set:
        """Return those of `states` in which a condition of a diagram holds that is not about a newcomer."""
        return self._plain(manager, condition, NONE, states)

    def _compared(self, number: int, choice: tuple[int, ...]) -> Compared:
        """Return how arguments of the request compare with posters, by the names of both."""
        loop = self.space.loop
        params = loop.model.requests[number].params
        pairs = zip(loop.arguments[number].poster_orders, choice, strict=True)
        return {(params[order.left].name, loop.names[-1 - order.right]): value for order, value in pairs}

    def rule(self, instance: Instance, root: int, states: Set) -> Set:
        """Return the states in which the tables restore a rule otherwise; `root` is NONE if they never need to."""
        manager = Manager()
        with deep():
            diagram = Decider(self.questions, manager).recover(instance)
        return self._plain(manager, diagram, root, states)

    def launch(self, launch: Launch, root: int) -> Set:
        """Return the states in which the tables are otherwise about whether a launch is required."""
        manager = Manager()
        with deep():
            diagram = Decider(self.questions, manager).required(launch)
        return self._possible(self._plain(manager, diagram, root, self.space.all))

    def latch(self, latch: Latch, root: int) -> Set:
        """Return the states in which the tables are otherwise about what sets a latch."""
        manager = Manager()
        with deep():
            diagram = Decider(self.questions, manager).condition(latch.condition)
        return self._possible(self._plain(manager, diagram, root, self.space.all))

    def _possible(self, states: Set) -> Set:
        """Return those of `states` whose variables all have one of their values.

        What two diagrams do is told state by state, and each tests few variables: following them through sets that
        constrain all would cost as many times more as there are requests.
        """
        return states & self.space.domain if states != self.space.none else states

    def _plain(self, manager: Manager, diagram: int, root: int, states: Set) -> Set:
        return _Pairing(self, manager, None, (), {}, {}).differ(diagram, root, states)

    def steps(self) -> Iterator[tuple[str, Set]]:
        """Yield what every step needs, with the states in which the tables are otherwise: rules, launches, latches.

        A rule that cannot come to be broken has no diagram of its own, and needs none.
        """
        loop, space = self.space.loop, self.space
        rows = iter(loop.tables.rules)
        for rule in loop.model.rules:
            if self.questions.restored(rule):
                for instance in self.questions.instances(rule, None):
                    row = next(rows, None)
                    root = NONE if row is None else row.root
                    if row is not None and loop.reasons[row.reason] != Reason(rule.name, rule.because):
                        yield f"the reason of rule `{rule.name}`", space.domain
                    yield f"rule `{rule.name}`", self._possible(self.rule(instance, root, space.all))
        for launch, required in zip(loop.model.launches, loop.tables.launches, strict=True):
            yield f"launch `{launch.name}`", self.launch(launch, required.condition)
        for latch, latching in zip(loop.model.latches, loop.tables.latches, strict=True):
            yield f"latch `{latch.name}`", self.latch(latch, latching.condition)

    def entries(self) -> Iterator[tuple[str, Set]]:
        """Yield each entry of the vector that a state fixes, with the states in which the tables count otherwise.

        And each whose change is not told to the rules that test it, and what is wrong with the bit rows, with all.
        """
        loop = self.space.loop
        wrong = (*unwatched(loop), *wrong_conflicts(loop), *wrong_rows(loop))
        yield from ((what, self.space.domain) for what in wrong)
        for entry, element in enumerate(self.space.loop.entries):
            if any(_is_argument(quantity) for _, quantity in element):
                continue
            pairs = [(factor, term) for factor, quantity in element for term in self.meaning.quantity(quantity)]
            mine, its = self.space.sum_of(pairs), self.space.distribution(entry)
            found = self.space.none
            for value in mine.keys() | its.keys():
                found |= self.space.bdd.apply("^", mine.get(value, self.space.none), its.get(value, self.space.none))
            yield f"entry {entry} of the state vector", self._possible(found)
            yield f"the initial value of entry {entry}", self._start(entry, pairs)

    def _start(self, entry: int, terms: Iterable[tuple[int, Term]]) -> Set:
        """Return the initial state if some test of the entry's initial value turns out otherwise there."""
        loop = self.space.loop
        value = sum(
            factor * weight
            for factor, term in terms
            for guard, weight in term
            if all(loop.variables[var].initial in values for var, values in guard)
        )
        sign = loop.bounds.sign(entry, loop.tables.entries[entry].initial)
        return self.space.none if loop.bounds.sign(entry, value) == sign else self.space.initial


def _is_argument(quantity: Quantity) -> bool:
    """Return whether a quantity is of the arguments that are looked at, and not of the state."""
    return isinstance(quantity, Arg | ArgRank) or (isinstance(quantity, Order) and quantity.request is not None)


@dataclass
class _Pairing:
    """Follows two diagrams at once, for one newcomer with given arguments."""

    whole: Equivalence
    manager: Manager
    request: Request | None
    args: Args
    fixed: dict[int, int]
    orders: Compared

    def differ(self, diagram: int, root: int, states: Set) -> Set:
        """Return the states of `states` in which the two do different things.

        Each pair of nodes is looked at once, with all states that come to it: below an action, which stands on every
        way, there would else be as many ways as there are sets of actions above.
        """
        space, nodes = self.whole.space, self.whole.space.loop.tables.nodes
        found = space.none
        at: dict[tuple[int, int], Set] = {}
        waiting: list[tuple[int, int, int]] = []

        def go(left: int, right: int, part: Set) -> None:
            pair = (left, right)
            if part != space.none and pair not in at:
                # Children have smaller numbers in the diagram, and larger ones in the tables: no pair comes too early.
                heappush(waiting, ((len(nodes) if right == NONE else right) - left, left, right))
            at[pair] = at.get(pair, space.none) | part

        go(diagram, root, states)
        while waiting:
            _, left, right = heappop(waiting)
            part = at.pop((left, right))
            mine = self.manager.node(left)
            its = None if right == NONE else nodes[right]
            # Where both ask the same, the rules are asked first, and only one way is left to go in the tables.
            alike = isinstance(mine, Test) and its is not None and its.code == self._entry(mine)
            if its is not None and its.code >= 0 and not alike:
                low: Set = part & space.test(its.code, its.bound, self.fixed)
                go(left, its.low, low)
                go(left, its.high, part & ~low)
            elif isinstance(mine, Act):
                if its is None or not self._same(mine, its):
                    found |= part
                else:
                    go(mine.child, its.low, part)
            elif mine is not None:
                values = self._values(self.manager.entries[mine.level])
                for above, most, child in zip((None, *mine.cuts), (*mine.cuts, None), mine.children, strict=True):
                    go(child, right, part & self._between(values, above, most))
            elif its is not None or left != NO:
                found |= part
        return found

    def _between(self, values: dict[int, Set], low: int | None, high: int | None) -> Set:
        found = self.whole.space.none
        for value, states in values.items():
            if (low is None or value > low) and (high is None or value <= high):
                found |= states
        return found

    def _entry(self, mine: Test) -> int | None:
        return self.whole.entry(self.manager.entries[mine.level])

    def _values(self, element: int) -> dict[int, Set]:
        """Return for each value of an element the states in which it has it, by the model."""
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

    def _same(self, mine: Act, its: Node) -> bool:
        """Return whether two action nodes say the same."""
        loop, meaning, action = self.whole.space.loop, self.whole.meaning, mine.action
        if CODES[type(action)] != -its.code:
            return False
        reason = getattr(action, "reason", None)
        if reason is not None and loop.reasons[its.bound] != reason:
            return False
        match action:
            case do.DoKill((name, slot)):
                request = meaning.request[name]
                target = request if slot is None else -1 - (loop.tables.requests[request].slots + slot)
                return its.high == target
            case do.DoDismiss(name):
                return its.high == meaning.request[name]
            case _:
                return True
