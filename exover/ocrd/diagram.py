"""Interval decision diagrams whose paths carry actions.

A test node asks in which interval an entry of the state vector lies (Strehl and Thiele 1998); an action node says what
is done before the path goes on. Reduced and shared: two diagrams of one manager are equal iff they are the same number.
Below an action the order of the entries starts anew, so actions keep the order in which they are to be done.
"""

from collections.abc import Callable, Hashable
from dataclasses import dataclass

from exover.ocrd.vector import Element

NO = 0
"""The end of a path; as a condition, false."""
YES = 1
"""True."""


@dataclass(frozen=True, slots=True)
class Test:
    """Go to `children[i]` for the first `cuts[i]` that the entry does not exceed, else to the last child."""

    element: Element
    cuts: tuple[int, ...]
    children: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Act:
    """Do `action`, then go on."""

    action: Hashable
    child: int


class Manager:
    """Shared nodes under one order of the entries; entries not in `order` follow in the order of their first use."""

    def __init__(self, order: tuple[Element, ...] = ()) -> None:
        self._nodes: list[Test | Act | None] = [None, None]
        self._unique: dict[Test | Act, int] = {}
        self._level: dict[Element, int] = {element: level for level, element in enumerate(order)}
        self._ite: dict[tuple[int, int, int], int] = {}

    def __len__(self) -> int:
        return len(self._nodes)

    def node(self, number: int) -> Test | Act | None:
        """Return the node of this number; None for `NO` and `YES`."""
        return self._nodes[number]

    def order(self) -> tuple[Element, ...]:
        """Return the entries in their order, those that were asked for so far."""
        return tuple(sorted(self._level, key=self._level.__getitem__))

    def at_most(self, element: Element, bound: int, low: int, high: int) -> int:
        """Return the condition `element <= bound`, where the entry is known to lie in `low .. high`."""
        if bound >= high:
            return YES
        if bound < low:
            return NO
        self._level.setdefault(element, len(self._level))
        return self._make(Test(element, (bound,), (YES, NO)))

    def act(self, action: Hashable, child: int) -> int:
        """Return the diagram that does `action` and goes on with `child`."""
        return self._make(Act(action, child))

    def _make(self, node: Test | Act) -> int:
        number = self._unique.get(node)
        if number is None:
            number = self._unique[node] = len(self._nodes)
            self._nodes.append(node)
        return number

    def test(self, element: Element, cuts: tuple[int, ...], children: tuple[int, ...]) -> int:
        """Return the reduced test node: neighbouring intervals with one child are one interval."""
        kept_cuts: list[int] = []
        kept = [children[0]]
        for cut, child in zip(cuts, children[1:], strict=True):
            if child != kept[-1]:
                kept_cuts.append(cut)
                kept.append(child)
        if len(kept) == 1:
            return kept[0]
        self._level.setdefault(element, len(self._level))
        return self._make(Test(element, tuple(kept_cuts), tuple(kept)))

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
        tests = [node for node in map(self.node, (f, g, h)) if isinstance(node, Test)]
        top = min((node.element for node in tests), key=self._level.__getitem__)
        cuts = sorted({cut for node in tests if node.element == top for cut in node.cuts})
        parts = [self._cofactors(number, top, cuts) for number in (f, g, h)]
        below = []
        for part in zip(*parts, strict=True):  # a plain loop: recursion through a generator costs C stack
            below.append(self.ite(*part))
        return self.test(top, tuple(cuts), tuple(below))

    def _cofactors(self, number: int, element: Element, cuts: list[int]) -> list[int]:
        """Return what is left of a diagram in each of the intervals that `cuts` make."""
        node = self.node(number)
        if not isinstance(node, Test) or node.element != element:
            return [number] * (len(cuts) + 1)
        found, index = [], 0
        for cut in (*cuts, None):
            while index < len(node.cuts) and (cut is None or node.cuts[index] < cut):
                index += 1
            found.append(node.children[index])
        return found

    def copy(self, number: int, target: "Manager", rename: Callable[[Hashable], Hashable] = lambda a: a) -> int:
        """Return the same diagram in another manager, under its order."""
        memo = {NO: NO, YES: YES}
        for each in self.below([number]):
            node = self._nodes[each]
            if isinstance(node, Act):
                memo[each] = target.act(rename(node.action), memo[node.child])
            elif isinstance(node, Test):
                result = memo[node.children[-1]]
                for cut, child in zip(reversed(node.cuts), reversed(node.children[:-1]), strict=True):
                    at_most = target.test(node.element, (cut,), (YES, NO))
                    result = target.ite(at_most, memo[child], result)
                memo[each] = result
        return memo[number]

    def below(self, roots: list[int]) -> list[int]:
        """Return the nodes that the roots reach, children before parents, the ends left out."""
        found: list[int] = []
        seen = {NO, YES}
        stack = [(root, False) for root in reversed(roots)]
        while stack:
            number, done = stack.pop()
            if done:
                found.append(number)
            elif number not in seen:
                seen.add(number)
                stack.append((number, True))
                stack += [(child, False) for child in reversed(children(self._nodes[number]))]
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
