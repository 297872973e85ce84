"""Strongly connected components of directed graphs."""

from collections.abc import Sequence


def strong_components(following: Sequence[Sequence[int]]) -> list[int]:
    """Return by node the number of its strongly connected component, smaller than those of components that lead to it.

    Depth-first search (Tarjan 1972) with a stack of its own.
    """
    index: dict[int, int] = {}
    low, component = [0] * len(following), [-1] * len(following)
    open_nodes: list[int] = []
    count = 0
    for root in range(len(following)):
        path = [(root, iter(following[root]))] if root not in index else []
        while path:
            node, rest = path[-1]
            if node not in index:
                index[node] = low[node] = len(index)
                open_nodes.append(node)
            child = next(rest, None)
            if child is None:
                path.pop()
                if path:
                    low[path[-1][0]] = min(low[path[-1][0]], low[node])
                if low[node] == index[node]:
                    while component[node] < 0:
                        component[open_nodes.pop()] = count
                    count += 1
            elif child not in index:
                path.append((child, iter(following[child])))
            elif component[child] < 0:
                low[node] = min(low[node], index[child])
    return component
