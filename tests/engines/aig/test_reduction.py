"""Smaller circuits that answer the same."""

import pytest

from exover.engines.aig.graph import Circuit, Graph
from exover.engines.aig.reached import Cube, reached
from exover.engines.aig.reduction import reduced
from exover.engines.aig.simulation import simulate
from exover.engines.aig.unreachable_cubes import unreachable_cubes
from tests.support.circuits import random_circuit, reachable


def smaller(circuit: Circuit, granted: int = 10**9) -> tuple[Circuit, list[Cube]]:
    runs = simulate(circuit, lanes=8, steps=4)
    latches = circuit.support(circuit.bad)
    states = reached(latches, runs)
    known = unreachable_cubes(circuit, latches, states)
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


def test_facts_about_latches_that_are_not_asked_about_forbid_no_state(monkeypatch: pytest.MonkeyPatch) -> None:
    """A latch that is always true stands in no cone: what is simulated has no value for it."""
    monkeypatch.setattr("exover.engines.aig.reduction.REFINE", 1)
    for seed in range(8):
        graph = Graph()
        latches = [graph.latch(False) for _ in range(4)]
        go = [graph.input() for _ in range(4)]
        on = graph.latch(True)
        nodes = [*latches, *go]
        for k in range(30):
            one, other = nodes[(7 * k + seed) % len(nodes)], nodes[(5 * k + 3) % len(nodes)]
            nodes.append(graph.conjunction(one ^ k & 1, other ^ k >> 1 & 1))
        following = [nodes[-1] ^ 1, nodes[-2], nodes[-3] ^ 1, nodes[-4] ^ 1, on]
        circuit = graph.circuit(following, [graph.any(nodes[-2:]), graph.differ(nodes[-5], nodes[-9])])
        runs = simulate(circuit, lanes=2, steps=1)
        states = reached(circuit.support(circuit.bad), runs)
        found = reduced(circuit, (0, 1), [(on ^ 1,)], states)
        assert reachable(found) == reachable(circuit)
