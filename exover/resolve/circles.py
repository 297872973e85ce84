"""Topological order of declarations that refer to each other by name, and the cycles among them."""

from collections.abc import Mapping, Sequence

from exover.diagnostics import quote
from exover.resolve.mistakes import Mistakes
from exover.syntax import tree

MAX_SHOWN = 4
"""The most names of a cycle that a message lists."""


def in_order(needs: Mapping[str, Sequence[str]]) -> tuple[list[str], list[list[str]]]:
    """Return the names, each after those that it needs, and the cycles, one for each back edge.

    A cycle `[a, b]` says that a needs b and b needs a. Depth-first search (Tarjan 1972) with a stack of its own, for
    chains may be long. Needs that are no key are ignored.
    """
    done: dict[str, bool] = {}
    order: list[str] = []
    circles: list[list[str]] = []
    for root in needs:
        if root in done:
            continue
        path, stack = [root], [iter(needs[root])]
        done[root] = False
        while path:
            name = next(stack[-1], None)
            if name is None:
                stack.pop()
                order.append(path.pop())
                done[order[-1]] = True
            elif name not in needs or done.get(name):
                continue
            elif name in done:
                circles.append(path[path.index(name) :])
            else:
                done[name] = False
                path.append(name)
                stack.append(iter(needs[name]))
    return order, circles


def note_circle(what: str, circle: list[tree.Name], mistakes: Mistakes) -> None:
    """Note that declarations are defined by each other, at the one that is first in the text."""
    first = min(range(len(circle)), key=lambda index: circle[index].span.start)
    turned = [*circle[first:], *circle[:first]]
    shown = [name.text for name in turned[:MAX_SHOWN]] + ["…"] * (len(turned) > MAX_SHOWN) + [turned[0].text]
    message = f"{what} {quote(turned[0].text)} is defined by itself"
    mistakes.add("E214", message, turned[0].span, label=" -> ".join(shown))
