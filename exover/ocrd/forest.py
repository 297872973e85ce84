"""All diagrams of a spec in one shared forest of binary tests, without tests that are redundant on their paths.

The tests on a path bound other entries too: if no slot is active, none is running and none satisfies a condition. A
test whose result follows from the bounds is left out. Bounds are propagated through linear forms over quantities (bound
propagation, Harvey and Schimpf 2002) and by inequalities between counters.
"""

from dataclasses import field, replace
from typing import NamedTuple

from exover.dataclass import dataclass
from exover.ocrd.decision import Do, DoNothing, asked_anew
from exover.ocrd.diagram import BOTTOM, NO, YES, Act, Manager, Test, TooManyNodes, children
from exover.ocrd.forms import Numbers, Range, span
from exover.ocrd.vector import HasPast, InPlace, Quantity, Slots

END = -1
"""The end of a path."""
NEVER = -2
"""An unreachable child: no consistent state leads there, so a test with such a child is replaced by the other one."""

LARGE = 8
"""Quantities of a sum from which on it is compared with other sums as a whole."""
CONTEXTS = 20_000
"""Pairs of a node and the bounds known there that are told apart in one diagram; from then on bounds are ignored."""
CONTEXTS_IN_ALL = 200_000
"""Those of all diagrams together that are more than one for each node."""

REMEMBERED = 1_000
"""Paths of which the bounds of all quantities are remembered."""


class Branch(NamedTuple):
    """A test node: go to `low` if the element of this number is at most `bound`, else to `high`."""

    element: int
    bound: int
    low: int
    high: int


class Perform(NamedTuple):
    """An action node: do `action`, then go to `child`."""

    action: Do
    child: int


Known = tuple[tuple[int, Range], ...]
"""The known ranges of entries, by their level in the diagram at hand."""


class BoundedSum(NamedTuple):
    """A sum: its range if nothing is known, the quantities that bound it, and by each of these the terms it bounds."""

    span: Range
    about: frozenset[int]
    bounding: dict[int, list[tuple[int, int]]]


@dataclass
class Forest:
    """The shared nodes of all planted diagrams; structural hashing keeps equal nodes once.

    Raises `TooManyNodes` if there would be more than `most`.
    """

    numbers: Numbers
    most: int = BOTTOM
    contexts: int = CONTEXTS_IN_ALL
    nodes: list[Branch | Perform] = field(default_factory=list)
    _unique: dict[Branch | Perform, int] = field(default_factory=dict)
    _above: dict[int, tuple[int, ...]] = field(default_factory=dict)
    _sums: dict[int, BoundedSum] = field(default_factory=dict)

    def plant(self, manager: Manager, root: int) -> int:
        """Add the diagram `root` of `manager` to the forest and return its node.

        One that asks anew keeps all its tests: with what paths know it would be what it would have been otherwise.
        """
        planting = _Planting(self, manager, root)
        planted = planting.plant(root)
        self.contexts -= max(0, len(planting.memo) - len(planting.masks))
        return planted

    def above(self, quantity: int) -> tuple[int, ...]:
        """Return the numbers of the counters that are always >= this quantity."""
        if quantity not in self._above:
            greater = _above(self.numbers.quantities[quantity])
            self._above[quantity] = tuple(self.numbers.quantity(each) for each in greater)
        return self._above[quantity]

    def bounded_sum(self, element: int) -> BoundedSum:
        """Return what an element is a sum of; it is asked for in each diagram that tests the element."""
        if element not in self._sums:
            bounding: dict[int, list[tuple[int, int]]] = {}
            for term in self.numbers.terms[element]:
                for quantity in (term[1], *self.above(term[1])):
                    bounding.setdefault(quantity, []).append(term)
            terms = self.numbers.terms[element]
            found = span(terms, {quantity: self.range(quantity, {}) for _, quantity in terms})
            self._sums[element] = BoundedSum(found, frozenset(bounding), bounding)
        return self._sums[element]

    def range(self, quantity: int, bounds: dict[int, Range]) -> Range:
        """Return the range of a quantity under some bounds, which may be of counters that are always >= it."""
        least, most = self.bound(quantity, bounds)
        return least, min([most, *(self.bound(each, bounds)[1] for each in self.above(quantity))])

    def bound(self, quantity: int, bounds: dict[int, Range]) -> Range:
        """Return the bounds of a quantity alone."""
        return bounds.get(quantity) or self.numbers.ranges[quantity]

    def branch(self, element: int, bound: int, low: int, high: int) -> int:
        """Return the test node, or one of its children if the test is redundant."""
        if low == high or high == NEVER:
            return low
        return high if low == NEVER else self._add(Branch(element, bound, low, high))

    def perform(self, action: Do, child: int) -> int:
        """Return the action node, or `NEVER` if its child is."""
        return NEVER if child == NEVER else self._add(Perform(action, child))

    def _add(self, node: Branch | Perform) -> int:
        number = self._unique.get(node)
        if number is None:
            number = self._unique[node] = len(self.nodes)
            if number >= self.most:
                raise TooManyNodes("with those of what stands before it")
            self.nodes.append(node)
        return number


class _Planting:
    """Copies one diagram into the forest, with the ranges of entries that are known on each path."""

    def __init__(self, forest: Forest, manager: Manager, root: int) -> None:
        self.forest = forest
        self.manager = manager
        self.tested = manager.entries
        self.linked = self._links()
        self.masks = self._masks(root)
        most = 0 if asked_anew(manager, root) else min(CONTEXTS, len(self.masks) + max(0, forest.contexts))
        self.most = most
        self.memo: dict[tuple[int, Known], int] = {}
        self._ranges: dict[tuple[int, Known], Range] = {}
        self._bounds: dict[Known, dict[int, Range]] = {(): {}}

    def _links(self) -> list[int]:
        """Return for each entry a bit set of the entries, itself included, whose ranges may bound its own."""
        about = [self.forest.bounded_sum(element).about for element in self.tested]
        sharing: dict[int, int] = {}
        linked = [0] * len(about)
        large = [index for index, quantities in enumerate(about) if len(quantities) > LARGE]
        for index, quantities in enumerate(about):
            for quantity in quantities if len(quantities) <= LARGE else ():
                sharing[quantity] = sharing.get(quantity, 0) | 1 << index
        for index, quantities in enumerate(about):
            for quantity in quantities if len(quantities) <= LARGE else ():
                linked[index] |= sharing[quantity]
            for other in large:
                if not quantities.isdisjoint(about[other]):
                    linked[index] |= 1 << other
                    linked[other] |= 1 << index
        return linked

    def _masks(self, root: int) -> dict[int, int]:
        """Return for each node a bit set of the entries whose ranges matter at it or below."""
        needed = {NO: 0, YES: 0}
        for number in self.manager.below([root]):
            node = self.manager.node(number)
            mask = self.linked[node.level] if isinstance(node, Test) else 0
            for child in children(node):
                mask |= needed[child]
            needed[number] = mask
        return needed

    def plant(self, number: int, known: Known = ()) -> int:
        """Return the forest node for diagram `number`, reduced under the ranges `known`."""
        node = self.manager.node(number)
        if node is None:
            return END
        mask = self.masks[number]
        known = tuple([item for item in known if mask >> item[0] & 1]) if len(self.memo) < self.most else ()
        key = (number, known)
        if key not in self.memo:
            if isinstance(node, Act) and node.action == DoNothing():
                self.memo[key] = self.plant(node.child)
            elif isinstance(node, Act):
                self.memo[key] = self.forest.perform(node.action, self.plant(node.child, known))  # type: ignore[arg-type]
            else:
                self.memo[key] = self._test(node, known)
        return self.memo[key]

    def _test(self, node: Test, known: Known) -> int:
        index = node.level
        low, high = self._range(index, known)
        parts: list[tuple[int, int]] = []
        start = low
        for cut, child in zip((*node.cuts, high), node.children, strict=True):
            end = min(cut, high)
            if start <= end:
                parts.append((end, self.plant(child, _learn(known, index, (start, end)))))
                start = end + 1
        return self._search(self.tested[index], parts) if parts else NEVER

    def _search(self, element: int, parts: list[tuple[int, int]]) -> int:
        """Return binary tests that find the child for the value of an element by bisection.

        `parts`: the greatest value of each interval and its child, increasing.
        """
        if len(parts) == 1:
            return parts[0][1]
        middle = (len(parts) + 1) // 2
        low, high = self._search(element, parts[:middle]), self._search(element, parts[middle:])
        return self.forest.branch(element, parts[middle - 1][0], low, high)

    def _range(self, index: int, known: Known) -> Range:
        """Return the range of values that the entry can still have under `known`."""
        linked = self.linked[index]
        about = tuple([item for item in known if linked >> item[0] & 1])
        key = (index, about)
        if key not in self._ranges:
            self._ranges[key] = self._under(index, about)
        return self._ranges[key]

    def _under(self, index: int, about: Known) -> Range:
        """Return the range of an entry under known ranges of entries that may bound it."""
        low, high = self.forest.numbers.spans[self.tested[index]]
        if not about:
            return low, high
        for other, found in about:
            if other == index:
                low, high = max(low, found[0]), min(high, found[1])
        bounds = dict(self._propagated(about))
        for quantity in list(bounds):
            for above in self.forest.above(quantity):
                least, most = self.forest.bound(above, bounds)
                bounds[above] = (max(least, self.forest.bound(quantity, bounds)[0]), most)
        least, most = self._bounded(self.tested[index], bounds)
        return max(low, least), min(high, most)

    def _propagated(self, known: Known) -> dict[int, Range]:
        """Return the bounds of the quantities of entries with known ranges, not to be changed; on a path mostly one
        range is new.
        """
        found = self._bounds.get(known)
        if found is None:
            found = dict(self._propagated(known[:-1]))
            index, span = known[-1]
            self._propagate(self.forest.numbers.terms[self.tested[index]], span, found)
            if len(self._bounds) >= REMEMBERED:
                self._bounds.clear()
                self._bounds[()] = {}
            self._bounds[known] = found
        return found

    def _bounded(self, element: int, bounds: dict[int, Range]) -> Range:
        """Return the range of an element under bounds of quantities: that under none, but for the terms these bound."""
        forest = self.forest
        (least, most), _, bounding = forest.bounded_sum(element)
        terms = tuple({term for each in bounds for term in bounding.get(each, ())})
        before = span(terms, {quantity: forest.range(quantity, {}) for _, quantity in terms})
        after = span(terms, {quantity: forest.range(quantity, bounds) for _, quantity in terms})
        return least - before[0] + after[0], most - before[1] + after[1]

    def _propagate(self, terms: tuple[tuple[int, int], ...], found: Range, bounds: dict[int, Range]) -> None:
        """Tighten the bounds of every quantity of an entry that lies in the range `found`."""
        edges = [(factor, *self.forest.bound(quantity, bounds)) for factor, quantity in terms]
        least = sum(factor * (low if factor > 0 else high) for factor, low, high in edges)
        most = sum(factor * (high if factor > 0 else low) for factor, low, high in edges)
        for (factor, quantity), (_, low, high) in zip(terms, edges, strict=True):
            own_least, own_most = (factor * low, factor * high) if factor > 0 else (factor * high, factor * low)
            upper, lower = found[1] - (least - own_least), found[0] - (most - own_most)
            if factor < 0:
                upper, lower = lower, upper
            ceiling, floor = upper // factor, -((-lower) // factor)
            bounds[quantity] = (max(low, floor), min(high, ceiling))


def _above(quantity: Quantity) -> list[Quantity]:
    """Return the counters that are always >= this quantity, because they count the same with fewer conditions."""
    match quantity:
        case Slots(_, slot, where, _):
            found: list[Quantity] = []
            if where is not None:
                found.append(replace(quantity, where=None))
            if slot is not None:
                found.append(replace(quantity, slot=None))
                if where is not None:
                    found.append(replace(quantity, slot=None, where=None))
            return found
        case HasPast(_, where) | InPlace(_, where, _):
            return [] if where is None else [replace(quantity, where=None)]
        case _:
            return []


def _learn(known: Known, index: int, span: Range) -> Known:
    """Return `known` with the range of the entry replaced by `span`."""
    return tuple(sorted([item for item in known if item[0] != index] + [(index, span)]))
