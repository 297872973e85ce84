"""Kinds of states are excluded cube by cube exactly where enumeration reaches none of them."""

from collections.abc import Callable
from random import Random

import pytest

from exover.engines.aig import pdr
from exover.engines.aig.answer import Answer, Open
from exover.engines.aig.check import excludes, is_invariant, makes_true
from exover.engines.aig.graph import TRUE, Circuit, Graph
from exover.engines.aig.implicants import Implicants, StatesOfKind
from tests.support.circuits import random_circuit, reachable


def decide(circuit: Circuit, say: Callable[[int, Answer], None], stop: Callable[[], bool]) -> None:
    pdr.decide(circuit, say, stop=stop, budget=10_000_000)


def undecided(circuit: Circuit, say: Callable[[int, Answer], None], stop: Callable[[], bool]) -> None:
    for index in range(len(circuit.bad)):
        say(index, Open("no time"))


def graph_of(circuit: Circuit) -> Graph:
    known = {pair: 2 * node for node, pair in enumerate(circuit.fanins) if pair is not None}
    latches = [(latch.node, latch.initial) for latch in circuit.latches]
    return Graph(list(circuit.fanins), list(circuit.inputs), latches, known)


def random_kinds(seed: int, graph: Graph) -> list[StatesOfKind]:
    """Return kinds over the latches alone."""
    source, known = Random(seed), [2 * node for node, _ in graph.latches]
    for _ in range(30):
        one, other = source.choice(known), source.choice(known)
        known.append(graph.conjunction(one ^ source.getrandbits(1), other ^ source.getrandbits(1)))
    return [(source.choice(known) ^ source.getrandbits(1), source.choice(known)) for _ in range(8)]


@pytest.mark.parametrize("seed", range(40))
def test_what_is_excluded_is_what_enumeration_does_not_reach(seed: int) -> None:
    circuit = random_circuit(seed)
    graph, following = graph_of(circuit), [latch.next for latch in circuit.latches]
    kinds = random_kinds(seed, graph)
    wanted = reachable(graph.circuit(following, [graph.all(kind) for kind in kinds]))
    implicants = Implicants(graph, following, TRUE, decide, lambda: False)
    left = list(range(len(kinds)))
    while left:
        places, runs = implicants.exclude([kinds[index] for index in left])
        assert places or runs
        whole = graph.circuit(following, [graph.all(kinds[index]) for index in left])
        for place, bad in enumerate(whole.bad):
            if place in places:
                assert left[place] not in wanted
                assert excludes(whole, tuple(implicants.clauses), bad)
        assert is_invariant(whole, tuple(implicants.clauses))
        shown = {n for run in runs for n, bad in enumerate(whole.bad) if makes_true(whole, bad, run)}
        assert bool(shown) == bool(runs)
        left = [index for place, index in enumerate(left) if place not in shown | set(places)]


def test_nothing_is_excluded_that_is_not_proved() -> None:
    graph = Graph()
    low, high = graph.latch(False), graph.latch(False)
    implicants = Implicants(graph, [low, high], TRUE, undecided, lambda: False)
    assert implicants.exclude([(low, high), (low, low ^ 1)]) == ([1], [])
    assert not implicants.clauses
