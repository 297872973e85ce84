"""Sifting: whatever is swapped, every diagram keeps its meaning, and what can be small becomes small."""

from collections.abc import Iterator
from itertools import product
from random import Random

import pytest

from exover.ocrd import order
from exover.ocrd.diagram import NO, YES, Act, Manager
from exover.ocrd.order import Sifting, sift

VALUES = range(4)
Node = int


def answer(manager: Manager, root: Node, values: dict[int, int]) -> list[object]:
    """Return the actions on the path of an assignment, and at its end whether it is YES."""
    found: list[object] = []
    node = manager.node(root)
    while node is not None:
        if isinstance(node, Act):
            found.append(node.action)
            root = node.child
        else:
            value = values[manager.entries[node.level]]
            root = node.children[sum(cut < value for cut in node.cuts)]
        node = manager.node(root)
    return [*found, root == YES]


def meaning(manager: Manager, root: Node, entries: int) -> list[list[object]]:
    return [answer(manager, root, dict(enumerate(values, start=1))) for values in product(VALUES, repeat=entries)]


def at_most(manager: Manager, entry: int, bound: int) -> Node:
    return manager.at_most(entry, bound, 0, max(VALUES))


def condition(manager: Manager, random: Random, entries: int, depth: int) -> Node:
    if depth == 0:
        return at_most(manager, random.randint(1, entries), random.randrange(3))
    parts = [condition(manager, random, entries, depth - 1) for _ in range(3)]
    return manager.ite(*parts)


def decision(manager: Manager, random: Random, entries: int) -> Node:
    """Return a random diagram with actions above and below tests."""
    root = manager.act("launch", NO)
    for number in range(4):
        root = manager.ite(condition(manager, random, entries, 1), manager.act(number, root), root)
    return root


def size(manager: Manager, root: Node) -> int:
    nodes = [manager.node(number) for number in manager.below([root])]
    return sum(1 if isinstance(node, Act) else len(node.cuts) for node in nodes if node)


def samples() -> Iterator[tuple[Manager, Node]]:
    for seed in range(12):
        manager = Manager(range(1, 5))
        yield manager, decision(manager, Random(seed), 4)


def pairs(order_of_entries: list[int]) -> tuple[Manager, Node]:
    """Return `(1 and 4) or (2 and 5) or (3 and 6)`, the classic whose order matters (Bryant 1986)."""
    manager = Manager(order_of_entries)
    root = NO
    for first in (3, 2, 1):
        both = manager.both(at_most(manager, first, 0), at_most(manager, first + 3, 0))
        root = manager.either(both, root)
    return manager, root


def test_every_swap_keeps_the_meaning_and_counts_the_nodes() -> None:
    for manager, root in samples():
        before = meaning(manager, root, 4)
        sifting = Sifting(manager, root)
        for place in (0, 1, 2, 1, 0, 2, 1):
            if place + 1 < len(sifting.order):
                sifting.swap(place)
                swapped, new = sifting.result()
                assert meaning(swapped, new, 4) == before
                assert sifting.size == size(swapped, new)


def test_a_swap_and_its_inverse_give_back_the_diagram() -> None:
    for manager, root in samples():
        sifting = Sifting(manager, root)
        sifting.swap(1)
        sifting.swap(1)
        swapped, new = sifting.result()
        assert sifting.size == size(manager, root) == size(swapped, new)


def test_swapped_diagrams_are_those_that_the_order_gives() -> None:
    """The swapped diagram is canonical: copying the original under the new order gives as many nodes."""
    for manager, root in samples():
        sifting = Sifting(manager, root)
        for place in (2, 0, 1):
            if place + 1 < len(sifting.order):
                sifting.swap(place)
        swapped, new = sifting.result()
        copied = Manager(swapped.entries)
        assert size(swapped, new) == size(copied, manager.copy(root, copied))


def test_sifting_keeps_the_meaning_and_never_grows() -> None:
    for manager, root in samples():
        sifted, new = sift(manager, root)
        assert meaning(sifted, new, 4) == meaning(manager, root, 4)
        assert size(sifted, new) <= size(manager, root)


def test_sifting_finds_the_order_of_the_classic() -> None:
    manager, root = pairs([1, 2, 3, 4, 5, 6])
    assert size(manager, root) == 14
    assert size(*sift(manager, root)) == 6


def test_sifting_is_the_same_every_time() -> None:
    for manager, root in samples():
        first, second = sift(manager, root), sift(manager, root)
        assert first[0].entries == second[0].entries
        assert first[1] == second[1]


def test_a_diagram_that_no_order_betters_keeps_its_order() -> None:
    manager, root = pairs([1, 4, 2, 5, 3, 6])
    assert sift(manager, root)[0].entries == [1, 4, 2, 5, 3, 6]


@pytest.mark.parametrize("work", range(0, 60, 7))
def test_sifting_that_runs_out_of_work_keeps_the_meaning(monkeypatch: pytest.MonkeyPatch, work: int) -> None:
    monkeypatch.setattr(order, "WORK", work)
    for manager, root in samples():
        sifted, new = sift(manager, root)
        assert meaning(sifted, new, 4) == meaning(manager, root, 4)
        assert size(sifted, new) <= size(manager, root)


@pytest.mark.parametrize("root", [NO, YES])
def test_the_ends_are_diagrams_too(root: Node) -> None:
    assert sift(Manager(), root)[1] == root
