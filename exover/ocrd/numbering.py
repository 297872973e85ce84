"""Canonical numbers for the nodes of a forest: by level, the longest path from a root, so children follow parents."""

from collections.abc import Iterable

from exover.ocrd.forest import END, Branch, Forest, Perform


def below(node: Branch | Perform) -> tuple[int, ...]:
    """Return the children of a node, without `END`."""
    after = (node.low, node.high) if isinstance(node, Branch) else (node.child,)
    return tuple(child for child in after if child != END)


def number(forest: Forest, roots: Iterable[int]) -> list[int]:
    """Return the nodes that the roots reach, by level (longest path from a root), then in breadth-first order."""
    found: dict[int, int] = {}
    queue = [root for root in roots if root != END]
    for node in queue:
        if node not in found:
            found[node] = len(found)
            queue.extend(below(forest.nodes[node]))
    level = dict.fromkeys(found, 0)
    for node in sorted(found, reverse=True):  # a node is added to a forest after its children
        for child in below(forest.nodes[node]):
            level[child] = max(level[child], level[node] + 1)
    return sorted(found, key=lambda node: (level[node], found[node]))


def longest(forest: Forest, roots: Iterable[int], reached: Iterable[int]) -> tuple[int, int, int, int]:
    """Return the maxima over all paths from the roots of: nodes, tests, actions, tests before the first action.

    `reached` are the nodes that the roots reach.
    """
    most: dict[int, tuple[int, int, int, int]] = {END: (0, 0, 0, 0)}
    for index in sorted(reached):  # a node is added to a forest after its children
        node = forest.nodes[index]
        if isinstance(node, Branch):
            low, high = most[node.low], most[node.high]
            nodes, tests, actions, first = (max(pair) for pair in zip(low, high, strict=True))
            most[index] = (nodes + 1, tests + 1, actions, first + 1)
        else:
            nodes, tests, actions, _ = most[node.child]
            most[index] = (nodes + 1, tests, actions + 1, 0)
    figures = [most[root] for root in roots if root != END] or [(0, 0, 0, 0)]
    nodes, tests, actions, first = (max(column) for column in zip(*figures, strict=True))
    return nodes, tests, actions, first
