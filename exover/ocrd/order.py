"""The order of the entries in one diagram: first the order of the demands, then sifting (Rudell 1993).

Each event has its own order. Asked in the order of the text, demands that name each other request once make a chain,
which no order beats; sifting is for the rest. An action never moves above the tests that decide it, since it is a leaf
of the tests above it.
"""

from collections.abc import Callable

from exover.ocrd.diagram import Manager, Test
from exover.ocrd.vector import Element

BUILDS = 400
"""How many trial orders one diagram is worth."""


def support(manager: Manager, roots: list[int]) -> list[Element]:
    """Return the entries that diagrams test, roots in turn, each in the order of its manager, without repetition."""
    level = {element: index for index, element in enumerate(manager.order())}
    found: dict[Element, None] = {}
    for root in roots:
        nodes = [manager.node(number) for number in manager.below([root])]
        tested = {node.element for node in nodes if isinstance(node, Test)}
        found.update(dict.fromkeys(sorted(tested, key=level.__getitem__)))
    return list(found)


def best(build: Callable[[Manager], int], start: list[Element]) -> tuple[Manager, int]:
    """Return the smallest diagram that sifting finds, starting from the order `start`, and its manager."""
    manager, root, size = _trial(build, start)
    order, left = start, BUILDS
    if size > _least(manager, root):
        for element in _by_weight(manager, root):
            for position in range(len(order)):
                trial = [other for other in order if other != element]
                trial.insert(position, element)
                if trial == order or not left:
                    continue
                left -= 1
                candidate = _trial(build, trial)
                if candidate[2] < size:
                    manager, root, size = candidate
                    order = trial
    return manager, root


def _trial(build: Callable[[Manager], int], order: list[Element]) -> tuple[Manager, int, int]:
    manager = Manager(tuple(order))
    root = build(manager)
    return manager, root, _size(manager, root)


def _size(manager: Manager, root: int) -> int:
    """Return the number of binary tests and actions."""
    nodes = [manager.node(number) for number in manager.below([root])]
    return sum(len(node.cuts) if isinstance(node, Test) else 1 for node in nodes)


def _least(manager: Manager, root: int) -> int:
    """Return a lower bound of the size under any order: each cut of an entry once, and the actions."""
    nodes = [manager.node(number) for number in manager.below([root])]
    cuts = {(node.element, cut) for node in nodes if isinstance(node, Test) for cut in node.cuts}
    return len(cuts) + sum(not isinstance(node, Test) for node in nodes)


def _by_weight(manager: Manager, root: int) -> list[Element]:
    """Return the entries that are tested, the one with most nodes first."""
    weight: dict[Element, int] = {}
    for number in manager.below([root]):
        node = manager.node(number)
        if isinstance(node, Test):
            weight[node.element] = weight.get(node.element, 0) + 1
    return sorted(weight, key=lambda element: -weight[element])
