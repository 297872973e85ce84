"""All diagrams of a spec in one shared forest of binary tests, without the tests that no consistent state needs.

What is known on a path about one entry bounds others: no slot is running if none is active, none satisfies a condition
if there is none at all. A test whose answer follows is left out. The bounds are those of linear forms over their
quantities (bound propagation, Harvey and Schimpf 2002) and the plain inequalities between counters.
"""

from dataclasses import dataclass, field, replace

from exover.ocrd.demand import Do
from exover.ocrd.diagram import NO, YES, Act, Manager, Test, children
from exover.ocrd.order import support
from exover.ocrd.vector import Element, HasPast, InPlace, Quantity, Slots, Vocabulary

END = -1
"""The end of a path."""
NEVER = -2
"""Where no state leads; whoever has a choice takes the other way."""


@dataclass(frozen=True, slots=True)
class Branch:
    """Go to `low` if the entry is at most `bound`, else to `high`."""

    element: Element
    bound: int
    low: int
    high: int


@dataclass(frozen=True, slots=True)
class Perform:
    """Do `action`, then go on."""

    action: Do
    child: int


Range = tuple[int, int]
Known = tuple[tuple[int, Range], ...]
"""What is known of entries, by their index in the support of the diagram at hand."""


@dataclass
class Forest:
    """Grows by diagrams; a node is found again by what it says, so equal parts are there once."""

    vocabulary: Vocabulary
    nodes: list[Branch | Perform] = field(default_factory=list)
    _unique: dict[Branch | Perform, int] = field(default_factory=dict)

    def plant(self, manager: Manager, root: int) -> int:
        """Return the node that the diagram `root` of `manager` becomes."""
        return _Planting(self, manager, support(manager, [root])).plant(root)

    def branch(self, element: Element, bound: int, low: int, high: int) -> int:
        """Return the reduced test node."""
        if low == high or high == NEVER:
            return low
        return high if low == NEVER else self._add(Branch(element, bound, low, high))

    def perform(self, action: Do, child: int) -> int:
        """Return the action node."""
        return NEVER if child == NEVER else self._add(Perform(action, child))

    def _add(self, node: Branch | Perform) -> int:
        number = self._unique.get(node)
        if number is None:
            number = self._unique[node] = len(self.nodes)
            self.nodes.append(node)
        return number


class _Planting:
    """Carries one diagram over, with what is known on the way."""

    def __init__(self, forest: Forest, manager: Manager, tested: list[Element]) -> None:
        self.forest = forest
        self.manager = manager
        self.tested = tested
        self.index = {manager.level(element): i for i, element in enumerate(tested)}
        self.spans = [forest.vocabulary.span(element) for element in tested]
        self.linked = _links(tested)
        self.masks = self._masks()
        self.memo: dict[tuple[int, Known], int] = {}

    def _masks(self) -> dict[int, int]:
        """Return by node the entries that what it needs to know is about, as a bit set."""
        needed = {NO: 0, YES: 0}
        for number in range(2, len(self.manager)):
            node = self.manager.node(number)
            mask = 0
            for child in children(node):
                mask |= needed.get(child, 0)
            if isinstance(node, Test) and node.level in self.index:
                for other in self.linked[self.index[node.level]]:
                    mask |= 1 << other
            needed[number] = mask
        return needed

    def plant(self, number: int, known: Known = ()) -> int:
        """Return the node for diagram `number` where `known` holds."""
        node = self.manager.node(number)
        if node is None:
            return END
        known = tuple(item for item in known if self.masks[number] >> item[0] & 1)
        key = (number, known)
        if key not in self.memo:
            if isinstance(node, Act):
                self.memo[key] = self.forest.perform(node.action, self.plant(node.child, known))  # type: ignore[arg-type]
            else:
                self.memo[key] = self._test(node, known)
        return self.memo[key]

    def _test(self, node: Test, known: Known) -> int:
        index = self.index[node.level]
        low, high = self._range(index, known)
        parts: list[tuple[int, int]] = []
        start = low
        for cut, child in zip((*node.cuts, high), node.children, strict=True):
            end = min(cut, high)
            if start <= end:
                parts.append((end, self.plant(child, _learn(known, index, (start, end)))))
                start = end + 1
        return self._search(self.tested[index], parts) if parts else NEVER

    def _search(self, element: Element, parts: list[tuple[int, int]]) -> int:
        """Return the tests that find the part in which the entry lies, by halving."""
        if len(parts) == 1:
            return parts[0][1]
        middle = (len(parts) + 1) // 2
        low, high = self._search(element, parts[:middle]), self._search(element, parts[middle:])
        return self.forest.branch(element, parts[middle - 1][0], low, high)

    def _range(self, index: int, known: Known) -> Range:
        """Return the values that the entry can still have."""
        low, high = self.spans[index]
        about = [item for item in known if item[0] in self.linked[index]]
        if not about:
            return low, high
        bounds: dict[Quantity, Range] = {}
        for other, (least, most) in about:
            if other == index:
                low, high = max(low, least), min(high, most)
        for other, span in about:
            self._propagate(self.tested[other], span, bounds)
        for quantity in list(bounds):
            for above in _above(quantity):
                least, most = self._bound(above, bounds)
                bounds[above] = (max(least, self._bound(quantity, bounds)[0]), most)
        least = most = 0
        for factor, quantity in self.tested[index]:
            lower, upper = self._bound(quantity, bounds)
            for above in _above(quantity):
                upper = min(upper, self._bound(above, bounds)[1])
            least += factor * (lower if factor > 0 else upper)
            most += factor * (upper if factor > 0 else lower)
        return max(low, least), min(high, most)

    def _bound(self, quantity: Quantity, bounds: dict[Quantity, Range]) -> Range:
        return bounds.get(quantity) or self.forest.vocabulary.range(quantity)

    def _propagate(self, element: Element, span: Range, bounds: dict[Quantity, Range]) -> None:
        """Tighten the bounds of every quantity of an entry that lies in `span`."""
        edges = [(factor, *self._bound(quantity, bounds)) for factor, quantity in element]
        least = sum(factor * (low if factor > 0 else high) for factor, low, high in edges)
        most = sum(factor * (high if factor > 0 else low) for factor, low, high in edges)
        for (factor, quantity), (_, low, high) in zip(element, edges, strict=True):
            own_least, own_most = (factor * low, factor * high) if factor > 0 else (factor * high, factor * low)
            upper, lower = span[1] - (least - own_least), span[0] - (most - own_most)
            if factor < 0:
                upper, lower = lower, upper
            ceiling, floor = upper // factor, -((-lower) // factor)
            bounds[quantity] = (max(low, floor), min(high, ceiling))


def _above(quantity: Quantity) -> list[Quantity]:
    """Return the counters that are never less than this one."""
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


def _links(tested: list[Element]) -> list[frozenset[int]]:
    """Return for each entry the entries, itself too, whose values bound its own."""
    by_quantity: dict[Quantity, set[int]] = {}
    for index, element in enumerate(tested):
        for _, quantity in element:
            for each in (quantity, *_above(quantity)):
                by_quantity.setdefault(each, set()).add(index)
    linked = []
    for index, element in enumerate(tested):
        about = {index}
        for _, quantity in element:
            for each in (quantity, *_above(quantity)):
                about |= by_quantity[each]
        linked.append(frozenset(about))
    return linked


def _learn(known: Known, index: int, span: Range) -> Known:
    """Return what is known once the entry is found to lie in `span`."""
    return tuple(sorted([item for item in known if item[0] != index] + [(index, span)]))
