"""Diagrams of the decoded tables, followed on all their paths at once: nodes stand before their children."""

from collections.abc import Callable
from typing import TypeVar

from exover.ocrd.tables import ALWAYS, NONE, Node, Tables

S = TypeVar("S")
"""A condition: a set of states, a term, or an expression."""


def follow(
    tables: Tables,
    root: int,
    start: S,
    joined: Callable[[int, list[S]], S | None],
    branched: Callable[[int, Node, S], tuple[S, S]],
    act: Callable[[int, Node, S], None],
) -> list[S]:
    """Return the conditions under which the walk that starts with `start` ends with a test, one for each such path.

    `joined` joins the conditions under which a node is met, None if none can be true; `branched` splits that by the
    test of the node. `act` is called for the actions, in the order in which they stand on every path.
    """
    at: dict[int, list[S]] = {root: [start]}
    for number in tables.below(root):
        here = joined(number, at.pop(number, []))
        if here is None:
            continue
        node = tables.nodes[number]
        if node.code >= 0:
            low, high = branched(number, node, here)
            at.setdefault(node.low, []).append(low)
            at.setdefault(node.high, []).append(high)
            continue
        act(number, node, here)
        if node.low != NONE:
            at.setdefault(node.low, []).append(here)
    return at.get(NONE, [])


def agreed(
    tables: Tables,
    root: int,
    none: S,
    all_: S,
    chosen: Callable[[Node, S, S], S],
) -> S:
    """Return where a diagram comes to an action; `chosen` is the first of two where the test of a node is true."""
    known = {NONE: none, ALWAYS: all_}
    for number in reversed(tables.below(root) if root >= 0 else ()):
        node = tables.nodes[number]
        known[number] = all_ if node.code < 0 else chosen(node, known[node.low], known[node.high])
    return known[root]
