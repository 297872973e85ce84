"""The order of the entries in one diagram: first the order of the demands, then sifting (Rudell 1993).

Each event has its own order. Asked in the order of the text, demands that name each other request once make a chain,
which no order beats; sifting is for the rest. An action never moves above the tests that decide it, since it is a leaf
of the tests above it.
"""

from exover.ocrd.diagram import NO, YES, Act, Manager, Test, children, cofactors, merged, union
from exover.ocrd.vector import Element

WORK = 50_000
"""How many nodes the swaps of one diagram may look at before sifting is content with what it has."""
GROWTH = 1.2
"""How much larger a diagram may become on the way of one entry."""


def support(manager: Manager, roots: list[int]) -> list[Element]:
    """Return the entries that diagrams test, roots in turn, each in the order of its manager, without repetition."""
    found: dict[int, None] = {}
    seen = {NO, YES}
    for root in roots:
        below = manager.below([root], seen)
        seen.update(below)
        found.update(dict.fromkeys(sorted({n.level for n in map(manager.node, below) if isinstance(n, Test)})))
    return [manager.entries[level] for level in found]


def sift(manager: Manager, root: int) -> tuple[Manager, int]:
    """Return the diagram under the best order that sifting finds, alone in a new manager."""
    sifting = Sifting(manager, root)
    sifting.run()
    return sifting.result()


class Sifting:
    """One diagram whose neighbouring levels can be swapped in place: a number keeps its meaning.

    Entries go by their level in the manager that the diagram is from. `size` is the number of binary tests and actions.
    """

    def __init__(self, manager: Manager, root: int) -> None:
        self.root = root
        self.entries = manager.entries
        self.order = [manager.level(element) for element in support(manager, [root])]
        self.nodes: dict[int, Test | Act] = {}
        self.size = 0
        self._unique: dict[Test | Act, int] = {}
        self._testing: dict[int, dict[int, None]] = {entry: {} for entry in self.order}  # sets that keep their order
        self._users = {NO: 1, YES: 1, root: 1}
        self._next = len(manager)
        self._work = WORK
        for number in manager.below([root]):
            node = manager.node(number)
            if node is not None:
                self._add(number, node)

    def run(self) -> None:
        """Move each entry, the one with most nodes first, to where the diagram is smallest."""
        least = self._least()
        for entry in sorted(self.order, key=lambda entry: -len(self._testing[entry])):
            if self.size > least and self._work > 0:
                self._place(entry)

    def result(self) -> tuple[Manager, int]:
        """Return the diagram in a manager of its own."""
        target = Manager(self.entries[entry] for entry in self.order)
        place = {entry: level for level, entry in enumerate(self.order)}
        found = {NO: NO, YES: YES}
        stack = [self.root]
        while stack:
            number = stack[-1]
            node = self.nodes.get(number)
            missing = [child for child in children(node) if child not in found]
            stack += missing
            if not missing:
                stack.pop()
                if isinstance(node, Test):
                    found[number] = target.test(place[node.level], node.cuts, tuple(found[c] for c in node.children))
                elif isinstance(node, Act):
                    found[number] = target.act(node.action, found[node.child])
        return target, found[self.root]

    def _least(self) -> int:
        """Return a lower bound of the size under any order: each cut of an entry once, and the actions."""
        cuts = {(node.level, cut) for node in self.nodes.values() if isinstance(node, Test) for cut in node.cuts}
        return len(cuts) + sum(isinstance(node, Act) for node in self.nodes.values())

    def _place(self, entry: int) -> None:
        """Move one entry both ways, as long as the diagram does not grow too much, then to the best place seen."""
        start = here = best = self.order.index(entry)
        smallest, most = self.size, GROWTH * self.size
        last = len(self.order) - 1
        for end in (0, last) if start < last - start else (last, 0):
            while here != end and self.size <= most and self._work > 0:
                here = self._step(here, end)
                if self.size < smallest:
                    best, smallest = here, self.size
            while here != start:
                here = self._step(here, start)
        while here != best:
            here = self._step(here, best)

    def _step(self, here: int, goal: int) -> int:
        """Move the entry at this place by one towards `goal` and return where it is now."""
        self.swap(here if here < goal else here - 1)
        return here + 1 if here < goal else here - 1

    def swap(self, place: int) -> None:
        """Exchange the entries at `place` and the next one."""
        upper, lower = self.order[place : place + 2]
        self.order[place : place + 2] = lower, upper
        below = self._testing[lower]
        self._work -= len(self._testing[upper]) + 1
        for number in list(self._testing[upper]):
            node = self.nodes[number]
            if isinstance(node, Test) and any(child in below for child in node.children):
                self._rewrite(number, node, lower)

    def _rewrite(self, number: int, node: Test, lower: int) -> None:
        """Make a node that tests the entry above a node that tests `lower` first."""
        parts = [(child, self.nodes.get(child)) for child in node.children]
        cuts = union(part.cuts for _, part in parts if isinstance(part, Test) and part.level == lower)
        columns = [
            cofactors(part, cuts) if isinstance(part, Test) and part.level == lower else (child,) * (len(cuts) + 1)
            for child, part in parts
        ]
        below = tuple(self._make(node.level, *merged(node.cuts, row)) for row in zip(*columns, strict=True))
        self._remove(number, node)
        self._add(number, Test(lower, cuts, below))
        for child in node.children:
            self._release(child)

    def _make(self, entry: int, cuts: tuple[int, ...], below: tuple[int, ...]) -> int:
        if not cuts:
            return below[0]
        node = Test(entry, cuts, below)
        if node not in self._unique:
            self._add(self._next, node)
            self._next += 1
        return self._unique[node]

    def _add(self, number: int, node: Test | Act) -> None:
        self.nodes[number] = node
        self._unique[node] = number
        self.size += weight(node)
        if isinstance(node, Test):
            self._testing[node.level][number] = None
        for child in children(node):
            self._users[child] = self._users.get(child, 0) + 1

    def _remove(self, number: int, node: Test | Act) -> None:
        del self.nodes[number], self._unique[node]
        self.size -= weight(node)
        if isinstance(node, Test):
            del self._testing[node.level][number]

    def _release(self, number: int) -> None:
        """Take one user from a node; without users it goes, and is no user of others."""
        stack = [number]
        while stack:
            number = stack.pop()
            self._users[number] -= 1
            if not self._users[number]:
                node = self.nodes[number]
                self._remove(number, node)
                stack += children(node)


def weight(node: Test | Act) -> int:
    """Return the number of binary nodes that a node becomes."""
    return len(node.cuts) if isinstance(node, Test) else 1
