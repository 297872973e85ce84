"""Diagrams of the decoded tables, followed on all paths at once, parents before their children."""

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
    """Return the conditions, one for each edge, under which a walk that starts under `start` leaves a test for the end.

    `joined` returns the disjunction of the conditions of a node, None if it is never true; `branched` splits it by the
    test of the node. `act` is called for each action, in the order in which they occur on every path.
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
    """Return the condition under which a diagram leads to an action; `chosen(node, low, high)`: if-then-else."""
    known = {NONE: none, ALWAYS: all_}
    for number in reversed(tables.below(root) if root >= 0 else ()):
        node = tables.nodes[number]
        known[number] = all_ if node.code < 0 else chosen(node, known[node.low], known[node.high])
    return known[root]
