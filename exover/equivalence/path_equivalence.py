"""Equivalence of the tables' diagrams with those of the rules in every state, path by path.

Both are built in one manager under the order of the tables, where diagrams of the same function are identical. Where
they differ, the compiler may have left out tests that no consistent state needs: paths are followed in both, and
dropped as soon as the known ranges of their elements are contradictory. A path that leads to two different ends is
checked by an exact decision procedure (`possible`). No argument cells and no sets of states are needed.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import field
from functools import cached_property, partial
from itertools import pairwise
from typing import NamedTuple

from exover.dataclass import dataclass
from exover.equivalence.bound_propagation import EMPTY, BoundPropagation, KnownRanges, learned
from exover.equivalence.diagram_equivalence import (
    CODES,
    alike,
    built,
    concerned,
    different_diagrams,
    listed,
    same_action,
)
from exover.equivalence.entry_equivalence import Counting
from exover.equivalence.record_equivalence import Records, different_for_all, different_records
from exover.model.decision import Reason
from exover.model.expression import TRUE, Cond
from exover.ocrd import tables as t
from exover.ocrd.compile import DecodedTables
from exover.ocrd.decision import asked_anew
from exover.ocrd.decision_context import DecisionContext
from exover.ocrd.demand import Decider
from exover.ocrd.diagram import NO, YES, Act, Manager, Test, children, cofactors, deep, union
from exover.ocrd.forms import Range
from exover.ocrd.roots import composed
from exover.ocrd.tables import ALWAYS, NONE, Node
from exover.ocrd.vector import Element, Vocabulary

MOST_PAIRS = 50_000
"""The greatest number of pairs of nodes, with known ranges, that are visited for one diagram."""
MOST_PATHS = 200
"""The greatest number of infeasible paths, not refuted by bounds, for which `possible` is called."""
TestedPath = tuple[tuple[Element, Range], ...]
"""The elements that a path tests, each with its range on the path."""


class UndecidedPaths(Exception):
    """The limits were reached before it was decided whether two diagrams are equivalent."""


class SharedAction(NamedTuple):
    """An action of either side: its code, what it names as its reason, and whom it concerns."""

    code: int
    reason: Reason | None
    target: int | None


@dataclass
class PathComparison:
    """Compares the tables of one model with its rules; `possible`: whether some state and arguments satisfy a path.

    Every method may raise `UndecidedPaths`.
    """

    compiled: DecodedTables
    possible: Callable[[TestedPath], bool]
    _decisions: dict[str, bool | UndecidedPaths] = field(default_factory=dict)
    _predicates: dict[tuple[str, Cond | None, int], bool] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.model, self.tables = self.compiled.model, self.compiled.tables

    @cached_property
    def questions(self) -> DecisionContext:
        """The context in which the rules' decisions are built."""
        return DecisionContext(Vocabulary(self.model))

    @cached_property
    def records(self) -> Records:
        """The records of the tables, to be compared with the model."""
        return Records(self.model, self.tables, self.compiled.entries, self.same_predicate)

    @cached_property
    def knowledge(self) -> BoundPropagation:
        """The bound propagation over the model's elements."""
        return BoundPropagation(self.questions.numbers)

    @cached_property
    def entry_of(self) -> dict[int, int]:
        """Maps the number of an element to its entry."""
        return {element: entry for entry, element in enumerate(self.elements)}

    @cached_property
    def elements(self) -> list[int]:
        """The number of each entry's element."""
        numbers, found = self.questions.numbers, []
        for element in self.compiled.entries:
            number, factor = numbers.element({numbers.quantity(quantity): count for count, quantity in element})
            if factor != 1:
                raise UndecidedPaths("an entry is no element")
            found.append(number)
        return found

    # ---- what is compared ----

    def different(self, kind: str, name: str) -> Iterator[str]:
        """Yield in what the tables do otherwise than the rules say, for a kind of event and in every step."""
        if self._miscounted:
            yield from self._miscounted
            return
        self._counted()
        yield from different_records(self.records, kind, name)
        if kind == "ask" and not self.decides(name):
            yield f"the decision on `{name}`"
        yield from self.different_steps

    @cached_property
    def different_steps(self) -> tuple[str, ...]:
        """What every step needs and the tables have otherwise than the rules: rules, launches, latches."""
        diagrams = different_diagrams(self.questions, self.tables, self.records.reasons, self._same)
        return (*different_for_all(self.records), *diagrams)

    @cached_property
    def _counting(self) -> Counting:
        return Counting(self.compiled, self.same_predicate)

    @cached_property
    def _miscounted(self) -> tuple[str, ...]:
        """The entries that, by the records, count something else than their elements."""
        try:
            return tuple(self._counting.wrong())
        except (IndexError, ValueError):
            return ("records that do not fit together",)

    @cached_property
    def _open(self) -> tuple[str, ...]:
        """The entries of which the records do not plainly say what they count."""
        return tuple(self._miscounted or self._counting.open())

    def _counted(self) -> None:
        if self._open:
            raise UndecidedPaths(f"{self._open[0]} is not plain")

    def decides(self, name: str) -> bool:
        """Return whether in every state, for all arguments, the tables decide on a newcomer as the rules do."""
        self._counted()
        if name not in self._decisions:
            try:
                self._decisions[name] = self._decides(name)
            except UndecidedPaths as reason:
                self._decisions[name] = reason
        found = self._decisions[name]
        if isinstance(found, UndecidedPaths):
            raise found
        return found

    def _decides(self, name: str) -> bool:
        its = self.tables.requests[self.records.index.request[name]].decide
        with deep():
            manager = Manager()
            decision = Decider(self.questions, manager).decide(self.model.request[name])
            if listed(manager, decision, self.tables.nodes, its, self.entry_of.get, self._same_action):
                return True
            manager, diagram = composed(manager, decision)
        return self._same(manager, diagram, its)

    def same_predicate(self, number: int, predicate: int, where: Cond | None, _: bool) -> bool:
        """Return whether a predicate of the tables is true of the arguments of which a condition is."""
        name = self.model.requests[number].name
        key = (name, where, predicate)
        if key not in self._predicates:
            build = partial(Decider.predicate, request=name, where=TRUE if where is None else where)
            self._predicates[key] = self._same(*built(self.questions, build), predicate)
        return self._predicates[key]

    def _same(self, manager: Manager, diagram: int, root: int) -> bool:
        """Return whether a diagram of the rules and one of the tables do the same in every state."""
        if root != ALWAYS and alike(manager, diagram, self.tables.nodes, root, self.entry_of.get, self._same_action):
            return True
        if asked_anew(manager, diagram):
            raise UndecidedPaths("no diagram that asks each entry once has few enough nodes")
        with deep():
            return Pair(self, manager, diagram, root).same()

    def _same_action(self, mine: Act, its: Node) -> bool:
        return same_action(mine, its, self.tables, self.records.index.request, self.records.reasons)

    # ---- actions ----

    def its_action(self, node: Node) -> SharedAction:
        """Return what an action node of the tables does."""
        code = -node.code
        reason = None if code in (t.LAUNCH, t.AGREE) else self.records.reasons[node.bound]
        return SharedAction(code, reason, node.high if code in (t.KILL, t.DISMISS) else None)

    def my_action(self, action: object) -> SharedAction:
        """Return what an action of the rules does."""
        target = concerned(action, self.tables, self.records.index.request)
        return SharedAction(CODES[type(action)], getattr(action, "reason", None), target)


class Pair:
    """One diagram of the rules and one of the tables, both in a manager under the order of the tables."""

    def __init__(self, beside: PathComparison, source: Manager, diagram: int, root: int) -> None:
        self.beside, self.knowledge = beside, beside.knowledge
        below = beside.tables.below(root) if root >= 0 else []
        self.manager = Manager(merged_order(self._order(below), source.entries))
        self.mine = source.copies([diagram], self.manager, beside.my_action)[diagram]
        self.its = self._read(below, root)
        self._about: dict[int, frozenset[int]] = {NO: frozenset(), YES: frozenset()}
        self._seen: set[tuple[int, int, KnownRanges]] = set()
        self._refuted = 0

    def same(self) -> bool:
        """Return whether the two do the same in every state."""
        return self._agree(self.mine, self.its, (), ())

    # ---- both in one manager ----

    def _order(self, below: list[int]) -> list[int]:
        """Return the elements that nodes of the tables test, each before those that are tested under it."""
        nodes, elements = self.beside.tables.nodes, self.beside.elements
        under: dict[int, dict[int, None]] = {}
        for number in below:
            if nodes[number].code >= 0:
                after = under.setdefault(elements[nodes[number].code], {})
                lower = [nodes[child] for child in (nodes[number].low, nodes[number].high) if child >= 0]
                after.update(dict.fromkeys(elements[node.code] for node in lower if node.code >= 0))
        found: dict[int, None] = {}
        entered: set[int] = set()
        for first in reversed(under):
            stack = [first]
            while stack:
                element = stack.pop()
                if element < 0:
                    found[~element] = None
                elif element not in entered:
                    entered.add(element)
                    stack += [~element, *(each for each in under[element] if each not in entered)]
        return list(reversed(found))

    def _read(self, below: list[int], root: int) -> int:
        """Return the diagram of the tables; children have larger numbers there than their parents."""
        target, nodes, elements = self.manager, self.beside.tables.nodes, self.beside.elements
        found = {NONE: NO, ALWAYS: target.act(SharedAction(t.AGREE, None, None), NO)}
        for number in reversed(below):
            node = nodes[number]
            if node.code < 0:
                found[number] = target.act(self.beside.its_action(node), found[node.low])
            else:
                level = target.level(elements[node.code])
                found[number] = target.choose(level, (node.bound,), (found[node.low], found[node.high]))
        return found[root]

    # ---- paths ----

    def _agree(self, mine: int, its: int, known: KnownRanges, path: KnownRanges) -> bool:
        """Return whether the two do the same on all feasible paths from this pair of nodes on."""
        if mine == its:
            return True
        about = self._tests(mine) | self._tests(its)
        known = tuple(item for item in known if not about.isdisjoint(self.knowledge.about(item[0])))
        key = (mine, its, known)
        if key in self._seen:
            return True
        refuted = self._refuted
        nodes = self.manager.node(mine), self.manager.node(its)
        tests = [node for node in nodes if isinstance(node, Test)]
        if tests:
            same = self._split(mine, its, min(node.level for node in tests), known, path)
        elif isinstance(nodes[0], Act) and isinstance(nodes[1], Act) and nodes[0].action == nodes[1].action:
            same = self._agree(nodes[0].child, nodes[1].child, known, path)
        else:
            same = not self._ends(path)
        if same and refuted == self._refuted:
            self._seen.add(key)  # a path that only its whole contradicts says nothing of others that come here
        if len(self._seen) > MOST_PAIRS:
            raise UndecidedPaths("too many paths")
        return same

    def _split(self, mine: int, its: int, level: int, known: KnownRanges, path: KnownRanges) -> bool:
        """Return whether the two agree in each interval of an entry that one of them asks for."""
        element = self.manager.entries[level]
        low, high = self.knowledge.range(element, known)
        pair = [self._at(number, level) for number in (mine, its)]
        cuts = union(node.cuts for node in pair if isinstance(node, Test))
        ways = zip(*(self._below(number, level, cuts) for number in (mine, its)), strict=True)
        edges = [low - 1, *(min(max(cut, low - 1), high) for cut in cuts), high]
        for (before, last), (one, other) in zip(pairwise(edges), ways, strict=True):
            if before < last and one != other:
                found = (before + 1, last)
                now = learned(known, element, found)
                if self.knowledge.range(element, now) == EMPTY:
                    continue
                if not self._agree(one, other, now, (*path, (element, found))):
                    return False
        return True

    def _at(self, number: int, level: int) -> Test | None:
        node = self.manager.node(number)
        return node if isinstance(node, Test) and node.level == level else None

    def _below(self, number: int, level: int, cuts: tuple[int, ...]) -> tuple[int, ...]:
        node = self._at(number, level)
        return cofactors(node, cuts) if node else (number,) * (len(cuts) + 1)

    def _tests(self, number: int) -> frozenset[int]:
        """Return the quantities that what a diagram tests is about."""
        if number not in self._about:
            for each in self.manager.below([number], set(self._about)):
                node = self.manager.node(each)
                own = self.knowledge.about(self.manager.entries[node.level]) if isinstance(node, Test) else frozenset()
                self._about[each] = own.union(*(self._about[child] for child in children(node)))
        return self._about[number]

    def _ends(self, path: KnownRanges) -> bool:
        """Return whether a path that leads to two different ends is feasible."""
        self._refuted += 1
        if self._refuted > MOST_PATHS:
            raise UndecidedPaths("too many paths")
        whole: KnownRanges = ()
        for element, found in path:
            whole = learned(whole, element, found)
        elements = self.knowledge.numbers.elements
        return self.beside.possible(tuple((elements[element], found) for element, found in whole))


def merged_order(order: Iterable[int], others: list[int]) -> list[int]:
    """Return an order, with what is missing in it before what it stands before in another."""
    found = list(order)
    place = set(found)
    after: int | None = None
    for element in reversed(others):
        if element not in place:
            found.insert(len(found) if after is None else found.index(after), element)
            place.add(element)
        after = element
    return found
