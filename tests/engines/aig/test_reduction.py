"""Smaller circuits that answer the same."""

import pytest

from exover.engines.aig.facts import facts
from exover.engines.aig.graph import Circuit, Graph
from exover.engines.aig.reached import Cube, reached
from exover.engines.aig.reduction import reduced
from exover.engines.aig.simulation import simulate
from tests.support.circuits import random_circuit, reachable


def smaller(circuit: Circuit, granted: int = 10**9) -> tuple[Circuit, list[Cube]]:
    runs = simulate(circuit, lanes=8, steps=4)
    latches = circuit.support(circuit.bad)
    states = reached(latches, runs)
    known = facts(circuit, latches, states)
    return reduced(circuit, range(len(circuit.bad)), known, states, granted), known


def size(circuit: Circuit) -> int:
    return len(circuit.cone([*circuit.bad, *(latch.next for latch in circuit.support(circuit.bad))]) - {0})


@pytest.mark.parametrize("seed", range(120))
def test_the_same_is_reachable(seed: int) -> None:
    circuit = random_circuit(seed, latches=2 + seed % 6, gates=60)
    found, _ = smaller(circuit)
    assert size(found) <= size(circuit)
    assert reachable(found) == reachable(circuit)


def test_what_two_formulas_say_alike_is_one_node() -> None:
    graph = Graph()
    a, b, c = (graph.latch(False) for _ in range(3))
    go = [graph.input() for _ in range(3)]
    one = graph.conjunction(graph.conjunction(a, b), c)
    other = graph.conjunction(a, graph.conjunction(b, c))
    circuit = graph.circuit(go, [graph.differ(one, other), one])
    found, known = smaller(circuit)
    assert not known
    assert found.bad[0] == 0
    assert size(found) == size(graph.circuit(go, [one]))
    assert smaller(circuit, granted=0)[0].bad[0] != 0


def test_latches_that_are_equal_become_one() -> None:
    graph = Graph()
    go = graph.input()
    a, b, never = (graph.latch(False) for _ in range(3))
    circuit = graph.circuit([go, go, graph.conjunction(never, go)], [graph.differ(a, b), graph.any((b, never))])
    found, _ = smaller(circuit)
    assert found.bad == (0, a)
