"""The variable order of one diagram: first the order of the demands, then sifting (Rudell 1993).

Each event has its own order. Demands that each read different entries, tested in the order of the text, make a chain,
which no order improves; sifting is for the others. An action never moves above the tests that decide it, since for the
tests above it is a leaf.
"""

from exover.dataclass import dataclass
from exover.ocrd.decision import asked_anew
from exover.ocrd.diagram import NO, YES, Act, ElementNumber, Manager, Test, children, cofactors, merged, union

WORK = 50_000
"""Nodes that the swaps of one diagram may visit before sifting stops."""
WORK_IN_ALL = 500_000
"""Those that the swaps of all diagrams of a spec may visit."""
GROWTH = 1.2
"""The factor by which a diagram may grow while one entry is moved."""


def support(manager: Manager, roots: list[int]) -> list[ElementNumber]:
    """Return the entries that diagrams test, root by root, each in the variable order, without duplicates."""
    found: dict[int, None] = {}
    seen: set[int] = set()
    for root in roots:
        below = map(manager.node, manager.below([root], seen))
        found.update(dict.fromkeys(sorted({node.level for node in below if isinstance(node, Test)})))
    return [manager.entries[level] for level in found]


@dataclass
class SiftingWork:
    """What is left of the work for all diagrams of a spec."""

    left: int = WORK_IN_ALL


def sift(manager: Manager, root: int, work: SiftingWork | None = None) -> tuple[Manager, int]:
    """Return the manager and root of the diagram under the best order that sifting finds, perhaps the given ones.

    A diagram that asks anew keeps its order: it is large because each part of it wants another one. What is visited
    is taken from `work`.
    """
    work = work or SiftingWork()
    if work.left <= 0 or asked_anew(manager, root):
        return manager, root
    nodes = [manager.node(number) for number in manager.below([root])]
    cuts = [(node.level, cut) for node in nodes if isinstance(node, Test) for cut in node.cuts]
    if len(set(cuts)) == len(cuts):
        return manager, root  # no order needs less than each cut of an entry once
    sifting = Sifting(manager, root, granted := min(WORK, work.left))
    sifting.run()
    work.left -= granted - sifting.work
    return sifting.result()


class Sifting:
    """One diagram whose adjacent levels can be swapped in place: each node number keeps its function.

    Entries are called by their level in the given manager. `size` is the number of binary tests and actions.
    """

    def __init__(self, manager: Manager, root: int, work: int = WORK) -> None:
        self.root = root
        self.work = work
        self.entries = manager.entries
        self.order = [manager.level(entry) for entry in support(manager, [root])]
        self.tests: dict[int, Test] = {}
        self.acts: dict[int, Act] = {}
        self.size = 0
        self._unique: dict[Test, int] = {}
        self._testing: dict[int, dict[int, None]] = {entry: {} for entry in self.order}  # sets that keep their order
        self._users = {NO: 1, YES: 1, root: 1}
        self._next = len(manager)
        for number in manager.below([root]):
            match manager.node(number):
                case Test() as test:
                    self._add(number, test)
                case Act(_, child) as act:
                    self.acts[number] = act
                    self.size += 1
                    self._users[child] = self._users.get(child, 0) + 1
                case None:
                    pass

    def run(self) -> None:
        """Sift each entry, the one with most nodes first, to the level where the diagram is smallest."""
        least = self._least()
        for entry in sorted(self.order, key=lambda entry: -len(self._testing[entry])):
            if self.size > least and self.work > 0:
                self._place(entry)

    def result(self) -> tuple[Manager, int]:
        """Return a new manager with the diagram under the present order, and its root."""
        target = Manager(self.entries[entry] for entry in self.order)
        place = {entry: level for level, entry in enumerate(self.order)}
        found = {NO: NO, YES: YES}
        stack = [] if self.root in found else [self.root]
        while stack:
            number = stack[-1]
            node = self.tests.get(number) or self.acts[number]
            missing = [child for child in children(node) if child not in found]
            stack += missing
            if not missing:
                stack.pop()
                match node:
                    case Test(entry, cuts, below):
                        found[number] = target.test(place[entry], cuts, tuple(found[child] for child in below))
                    case Act(action, child):
                        found[number] = target.act(action, found[child])
        return target, found[self.root]

    def _least(self) -> int:
        """Return a lower bound on the size under any order: the number of distinct cuts and of actions."""
        return len({(test.level, cut) for test in self.tests.values() for cut in test.cuts}) + len(self.acts)

    def _place(self, entry: int) -> None:
        """Move one entry up and down until the diagram grows by more than GROWTH, then to the best level seen."""
        start = here = best = self.order.index(entry)
        smallest, most = self.size, GROWTH * self.size
        last = len(self.order) - 1
        for end in (0, last) if start < last - start else (last, 0):
            while here != end and self.size <= most and self.work > 0:
                here = self._step(here, end)
                if self.size < smallest:
                    best, smallest = here, self.size
            while here != start:
                here = self._step(here, start)
        while here != best:
            here = self._step(here, best)

    def _step(self, here: int, goal: int) -> int:
        """Move the entry at this place by one towards `goal` and return its new place."""
        self.swap(here if here < goal else here - 1)
        return here + 1 if here < goal else here - 1

    def swap(self, place: int) -> None:
        """Swap the entries at `place` and the next place."""
        upper, lower = self.order[place : place + 2]
        self.order[place : place + 2] = lower, upper
        below = self._testing[lower]
        self.work -= len(self._testing[upper]) + 1
        for number in list(self._testing[upper]):
            test = self.tests[number]
            if not below.keys().isdisjoint(test.children):
                self._rewrite(number, test, below)

    def _rewrite(self, number: int, test: Test, below: dict[int, None]) -> None:
        """Let a node that tests the upper entry test the lower one first, whose nodes are `below`; its number stays."""
        parts = [self.tests[child] if child in below else None for child in test.children]
        found = [part for part in parts if part]
        cuts = union(part.cuts for part in found)
        columns = [
            cofactors(part, cuts) if part else (child,) * (len(cuts) + 1)
            for child, part in zip(test.children, parts, strict=True)
        ]
        children = tuple([self._make(test.level, *merged(test.cuts, row)) for row in zip(*columns, strict=True)])
        self._remove(number, test)
        self._add(number, Test(found[0].level, cuts, children))
        for child in test.children:
            self._release(child)

    def _make(self, entry: int, cuts: tuple[int, ...], children: tuple[int, ...]) -> int:
        if not cuts:
            return children[0]
        test = Test(entry, cuts, children)
        if test not in self._unique:
            self._add(self._next, test)
            self._next += 1
        return self._unique[test]

    def _add(self, number: int, test: Test) -> None:
        self.tests[number] = test
        self._unique[test] = number
        self._testing[test.level][number] = None
        self.size += len(test.cuts)
        for child in test.children:
            self._users[child] = self._users.get(child, 0) + 1

    def _remove(self, number: int, test: Test) -> None:
        del self.tests[number], self._unique[test], self._testing[test.level][number]
        self.size -= len(test.cuts)

    def _release(self, number: int) -> None:
        """Decrement the reference count of a node; at 0, remove the test and release its children.

        Action nodes never reach 0.
        """
        self._users[number] -= 1
        if not self._users[number]:
            test = self.tests[number]
            self._remove(number, test)
            for child in test.children:
                self._release(child)
