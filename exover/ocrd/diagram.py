"""Interval decision diagrams whose paths carry actions.

A test node branches on the interval in which an entry of the state vector lies (Strehl and Thiele 1998); an action node
holds an action and one child. Diagrams are reduced and shared by structural hashing: two diagrams of one manager are
equal iff they have the same number. Below an action the variable order starts anew, so actions keep their order.
"""

import sys
from bisect import bisect_left
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import NamedTuple

NO = 0
"""The terminal node: the end of a path; as a condition, false."""
YES = 1
"""The terminal node of conditions that are true."""
BOTTOM = 1 << 62
"""The level of terminal nodes and action nodes, below that of all tests."""
ElementNumber = int
"""The number of an element, `v[i]` in `v[i] <= k`."""


RECURSION = 100_000
"""Python frames that a recursion over a diagram may need: a few for each entry that one condition reads."""


@contextmanager
def deep() -> Iterator[None]:
    """Raise the recursion limit to RECURSION in a `with` block, for recursion over large diagrams.

    It is restored after the block, because it also guards the C stack, as in the scanner of JSON.
    """
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(max(limit, RECURSION))
    try:
        yield
    finally:
        sys.setrecursionlimit(limit)


class TooManyNodes(Exception):
    """A diagram has more nodes than it may have."""


class Test(NamedTuple):
    """A test node: go to `children[i]` for the least i with entry <= `cuts[i]`, else to the last child."""

    level: int
    cuts: tuple[int, ...]
    children: tuple[int, ...]


class Act(NamedTuple):
    """An action node: do `action`, then go to `child`."""

    action: Hashable
    child: int


class Manager:
    """Shared nodes under one variable order; entries that are not in `order` follow in the order of their first use.

    What makes nodes raises `TooManyNodes` if there would be more than `most`, counted as binary tests and actions, or
    if more results than that are remembered.
    """

    def __init__(self, order: Iterable[ElementNumber] = (), most: int = BOTTOM) -> None:
        self.most = self.most_results = most
        self.size = 0
        """The number of binary tests and actions."""
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
        """Return the level of an entry; a new entry gets the lowest level in the order so far."""
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
        """Return the action node that does `action`, then `child`."""
        return self._make(Act(action, child), BOTTOM)

    def _make(self, node: Test | Act, level: int) -> int:
        number = self._unique.get(node)
        if number is None:
            size = self.size + (len(node.cuts) if isinstance(node, Test) else 1)
            if size > self.most or len(self._ite) > self.most_results:
                raise TooManyNodes
            self.size = size
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
        """Return `g` where the condition `f` holds, else `h`; action nodes of `g` and `h` are taken as terminal."""
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

    @contextmanager
    def within(self, more: int) -> Iterator[None]:
        """Raise `TooManyNodes` in a `with` block if it makes more than so many nodes, or remembers as many results."""
        limits = self.most, self.most_results
        self.most = min(self.most, self.size + more)
        self.most_results = min(self.most_results, len(self._ite) + more)
        try:
            yield
        finally:
            self.most, self.most_results = limits

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
        """Return `ite(f, g, h)` if only `f` tests the uppermost entry."""
        level, cuts, children = self._nodes[f]  # type: ignore[misc]
        below = []
        for child in children:
            below.append(self.ite(child, g, h))
        return self.test(level, cuts, tuple(below))

    def cofactor(self, f: int, values: Mapping[ElementNumber, int]) -> int:
        """Return what a condition is where some entries have these values; it tests them no more."""
        found = {NO: NO, YES: YES}
        for number in self.below([f]):
            level, cuts, children = self._nodes[number]  # type: ignore[misc]
            value = values.get(self.entries[level])
            if value is None:
                found[number] = self.test(level, cuts, tuple([found[child] for child in children]))
            else:
                found[number] = found[children[bisect_left(cuts, value)]]
        return found[f]

    def copy(self, number: int, target: "Manager") -> int:
        """Return the same diagram in another manager, under its order."""
        return self.copies([number], target)[number]

    def copies(
        self, numbers: Iterable[int], target: "Manager", action: Callable[[Hashable], Hashable] = lambda same: same
    ) -> dict[int, int]:
        """Return a map from these diagrams, and all nodes below them, to their copies in `target`, under its order.

        `action` is applied to each action.
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
        """Return the diagram that tests the entry of this level, then `children`, which may test entries above it."""
        if all(self._top[child] > level for child in children):
            return self.test(level, cuts, children)
        result = children[-1]
        for cut, child in zip(reversed(cuts), reversed(children[:-1]), strict=True):
            result = self.ite(self.test(level, (cut,), (YES, NO)), child, result)
        return result

    def below(self, roots: Iterable[int], seen: set[int] | None = None) -> list[int]:
        """Return the nodes that the roots reach, children before parents, without terminal nodes and those in `seen`.

        The nodes are added to `seen`.
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
    """Return the numbers of the children of a node."""
    match node:
        case Test(_, _, below):
            return below
        case Act(_, child):
            return (child,)
        case None:
            return ()


def union(cuts: Iterable[tuple[int, ...]]) -> tuple[int, ...]:
    """Return the union of tuples of cuts, increasing, without duplicates."""
    distinct = set(cuts)
    if len(distinct) == 1:
        return distinct.pop()
    return tuple(sorted({cut for each in distinct for cut in each}))


def cofactors(node: Test, cuts: tuple[int, ...]) -> tuple[int, ...]:
    """Return the cofactors of a test: its child in each of the intervals that `cuts`, a superset of its own, make."""
    if node.cuts == cuts:
        return node.children
    found, index, own = [], 0, node.cuts
    for cut in cuts:
        while index < len(own) and own[index] < cut:
            index += 1
        found.append(node.children[index])
    return (*found, node.children[-1])


def merged(cuts: tuple[int, ...], children: tuple[int, ...]) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the cuts and children with neighbouring equal children made one."""
    if len(cuts) == 1:
        return (cuts, children) if children[0] != children[1] else ((), children[:1])
    kept_cuts: list[int] = []
    kept = [children[0]]
    for cut, child in zip(cuts, children[1:], strict=True):
        if child != kept[-1]:
            kept_cuts.append(cut)
            kept.append(child)
    return tuple(kept_cuts), tuple(kept)
