"""Interval decision diagrams whose paths carry actions.

A test node asks in which interval an entry of the state vector lies (Strehl and Thiele 1998); an action node says what
is done before the path goes on. Reduced and shared: two diagrams of one manager are equal iff they are the same number.
Below an action the order of the entries starts anew, so actions keep the order in which they are to be done.
"""

import sys
from collections.abc import Callable, Hashable, Iterable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

NO = 0
"""The end of a path; as a condition, false."""
YES = 1
"""True."""
BOTTOM = 1 << 62
"""The level of what is no test."""
ElementNumber = int
"""The number of an element, `v[i]` in `v[i] <= k`."""


RECURSION = 100_000
"""Frames that a diagram may need: a few for each entry that one condition reads."""


@contextmanager
def deep() -> Iterator[None]:
    """Allow the frames that large diagrams need, and no longer than they do.

    Recursion in C, as in JSON's scanner, goes by the same limit, and there it guards the stack.
    """
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(max(limit, RECURSION))
    try:
        yield
    finally:
        sys.setrecursionlimit(limit)


class Test(NamedTuple):
    """Go to `children[i]` for the first `cuts[i]` that the entry of this level does not exceed, else to the last."""

    level: int
    cuts: tuple[int, ...]
    children: tuple[int, ...]


class Act(NamedTuple):
    """Do `action`, then go on."""

    action: Hashable
    child: int


class Manager:
    """Shared nodes under one order of the entries; entries not in `order` follow in the order of their first use."""

    def __init__(self, order: Iterable[ElementNumber] = ()) -> None:
        self.entries: list[ElementNumber] = list(order)
        """The entries by level."""
        self._level: dict[ElementNumber, int] = {entry: level for level, entry in enumerate(self.entries)}
        self._nodes: list[Test | Act | None] = [None, None]
        self._top = [BOTTOM, BOTTOM]
        self._unique: dict[Test | Act, int] = {}
        self._ite: dict[tuple[int, int, int], int] = {}

    def __len__(self) -> int:
        return len(self._nodes)

    def node(self, number: int) -> Test | Act | None:
        """Return the node of this number; None for `NO` and `YES`."""
        return self._nodes[number]

    def level(self, entry: ElementNumber) -> int:
        """Return the level of an entry, which becomes the last if the entry is new."""
        level = self._level.setdefault(entry, len(self.entries))
        if level == len(self.entries):
            self.entries.append(entry)
        return level

    def at_most(self, entry: ElementNumber, bound: int, low: int, high: int) -> int:
        """Return the condition `entry <= bound`, where the entry is known to lie in `low .. high`."""
        if bound >= high:
            return YES
        if bound < low:
            return NO
        level = self.level(entry)
        return self._make(Test(level, (bound,), (YES, NO)), level)

    def above(self, entry: ElementNumber, bound: int, low: int, high: int) -> int:
        """Return the condition `entry > bound`, where the entry is known to lie in `low .. high`."""
        if not low <= bound < high:
            return YES if bound < low else NO
        level = self.level(entry)
        return self._make(Test(level, (bound,), (NO, YES)), level)

    def act(self, action: Hashable, child: int) -> int:
        """Return the diagram that does `action` and goes on with `child`."""
        return self._make(Act(action, child), BOTTOM)

    def _make(self, node: Test | Act, level: int) -> int:
        number = self._unique.get(node)
        if number is None:
            number = self._unique[node] = len(self._nodes)
            self._nodes.append(node)
            self._top.append(level)
        return number

    def test(self, level: int, cuts: tuple[int, ...], children: tuple[int, ...]) -> int:
        """Return the reduced test node: neighbouring intervals with one child are one interval."""
        kept_cuts, kept = merged(cuts, children)
        return kept[0] if len(kept) == 1 else self._make(Test(level, kept_cuts, kept), level)

    def negate(self, f: int) -> int:
        """Return the negation of a condition."""
        return self.ite(f, NO, YES)

    def both(self, f: int, g: int) -> int:
        """Return the conjunction of two conditions."""
        return self.ite(f, g, NO)

    def either(self, f: int, g: int) -> int:
        """Return the disjunction of two conditions."""
        return self.ite(f, YES, g)

    def ite(self, f: int, g: int, h: int) -> int:
        """Return `g` where the condition `f` holds and `h` elsewhere; action nodes of `g` and `h` are opaque."""
        if f == YES or g == h:
            return g
        if f == NO:
            return h
        if g == YES and h == NO:
            return f
        key = (f, g, h)
        found = self._ite.get(key)
        if found is None:
            found = self._ite[key] = self._split(f, g, h)
        return found

    def _split(self, f: int, g: int, h: int) -> int:
        top = [self._top[number] for number in (f, g, h)]
        level = min(top)
        if level < top[1] and level < top[2]:
            return self._below_condition(f, g, h)
        nodes = [self._nodes[number] if at == level else None for number, at in zip((f, g, h), top, strict=True)]
        cuts = union(node.cuts for node in nodes if isinstance(node, Test))
        fs, gs, hs = [
            cofactors(node, cuts) if isinstance(node, Test) else (number,) * (len(cuts) + 1)
            for number, node in zip((f, g, h), nodes, strict=True)
        ]
        below = []
        for i in range(len(cuts) + 1):  # a plain loop: recursion through a generator costs C stack
            below.append(self.ite(fs[i], gs[i], hs[i]))
        return self.test(level, cuts, tuple(below))

    def _below_condition(self, f: int, g: int, h: int) -> int:
        """Return `ite` where only `f` tests the uppermost entry."""
        level, cuts, children = self._nodes[f]  # type: ignore[misc]
        below = []
        for child in children:
            below.append(self.ite(child, g, h))
        return self.test(level, cuts, tuple(below))

    def copy(self, number: int, target: "Manager") -> int:
        """Return the same diagram in another manager, under its order."""
        return self.copies([number], target)[number]

    def copies(
        self, numbers: Iterable[int], target: "Manager", action: Callable[[Hashable], Hashable] = lambda same: same
    ) -> dict[int, int]:
        """Return by number what diagrams, and all below them, are in another manager, under its order.

        `action`: what their actions become.
        """
        found = {NO: NO, YES: YES}
        for number in self.below(numbers):
            node = self._nodes[number]
            if isinstance(node, Act):
                found[number] = target.act(action(node.action), found[node.child])
            elif isinstance(node, Test):
                level = target.level(self.entries[node.level])
                found[number] = target.choose(level, node.cuts, tuple([found[child] for child in node.children]))
        return found

    def choose(self, level: int, cuts: tuple[int, ...], children: tuple[int, ...]) -> int:
        """Return the diagram that asks the entry of this level, wherever in the order, and goes on with `children`."""
        if all(self._top[child] > level for child in children):
            return self.test(level, cuts, children)
        result = children[-1]
        for cut, child in zip(reversed(cuts), reversed(children[:-1]), strict=True):
            result = self.ite(self.test(level, (cut,), (YES, NO)), child, result)
        return result

    def below(self, roots: Iterable[int], seen: set[int] | None = None) -> list[int]:
        """Return the nodes that the roots reach, children before parents, without the ends and what was `seen`.

        They are added to `seen`.
        """
        found: list[int] = []
        seen = set() if seen is None else seen
        nodes = self._nodes
        stack = [*roots]
        stack.reverse()
        while stack:
            number = stack.pop()
            if number < 0:
                found.append(~number)
            elif number > YES and number not in seen:
                seen.add(number)
                following = children(nodes[number])
                if max(following) <= YES:
                    found.append(number)
                else:
                    stack.append(~number)
                    stack += reversed(following)
        return found


def children(node: Test | Act | None) -> tuple[int, ...]:
    """Return the numbers of the nodes that follow a node."""
    match node:
        case Test(_, _, below):
            return below
        case Act(_, child):
            return (child,)
        case None:
            return ()


def union(cuts: Iterable[tuple[int, ...]]) -> tuple[int, ...]:
    """Return all the cuts, increasing, each once."""
    distinct = set(cuts)
    if len(distinct) == 1:
        return distinct.pop()
    return tuple(sorted({cut for each in distinct for cut in each}))


def cofactors(node: Test, cuts: tuple[int, ...]) -> tuple[int, ...]:
    """Return what is left of a test in each of the intervals that `cuts` make, which have all its own among them."""
    if node.cuts == cuts:
        return node.children
    found, index, own = [], 0, node.cuts
    for cut in cuts:
        while index < len(own) and own[index] < cut:
            index += 1
        found.append(node.children[index])
    return (*found, node.children[-1])


def merged(cuts: tuple[int, ...], children: tuple[int, ...]) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the cuts and children without the cuts between equal children."""
    if len(cuts) == 1:
        return (cuts, children) if children[0] != children[1] else ((), children[:1])
    kept_cuts: list[int] = []
    kept = [children[0]]
    for cut, child in zip(cuts, children[1:], strict=True):
        if child != kept[-1]:
            kept_cuts.append(cut)
            kept.append(child)
    return tuple(kept_cuts), tuple(kept)
