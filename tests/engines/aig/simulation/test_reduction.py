"""Smaller circuits that answer the same."""

import pytest

from exover.engines.aig.circuit.graph import Circuit, Graph
from exover.engines.aig.simulation.reached import reached
from exover.engines.aig.simulation.reduction import reduced
from exover.engines.aig.simulation.runs import simulate
from tests.support.circuits import random_circuit, reachable


def smaller(circuit: Circuit, granted: int = 10**9) -> Circuit:
    states = reached(circuit.support(circuit.bad), simulate(circuit, lanes=8, steps=4))
    return reduced(circuit, states, granted)


def size(circuit: Circuit) -> int:
    cone = circuit.cone([*circuit.bad, *(latch.next for latch in circuit.support(circuit.bad))])
    return sum(node > 0 for node in cone)


@pytest.mark.parametrize("seed", range(80))
def test_the_same_is_reachable(seed: int) -> None:
    circuit = random_circuit(seed, latches=2 + seed % 6, gates=60)
    found = smaller(circuit)
    assert size(found) <= size(circuit)
    assert reachable(found) == reachable(circuit)


@pytest.mark.parametrize("seed", range(20))
def test_the_loop_in_c_leads_to_the_same_circuit(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    circuit = random_circuit(seed, latches=4, gates=60)
    plain = smaller(circuit)
    monkeypatch.setattr("exover.engines.aig.circuit.kernel.WORTH", 0)
    assert smaller(circuit) == plain


def test_what_two_formulas_say_alike_is_one_node() -> None:
    graph = Graph()
    a, b, c = (graph.latch(False) for _ in range(3))
    go = [graph.input() for _ in range(3)]
    one = graph.conjunction(graph.conjunction(a, b), c)
    other = graph.conjunction(a, graph.conjunction(b, c))
    circuit = graph.circuit(go, [graph.differ(one, other), one])
    found = smaller(circuit)
    assert found.bad[0] == 0
    assert size(found) == size(graph.circuit(go, [one]))
    assert smaller(circuit, granted=0).bad[0] != 0


def test_what_no_random_state_tells_apart_is_told_apart_by_the_solver(monkeypatch: pytest.MonkeyPatch) -> None:
    """A conjunction of forty latches is false in every state that is simulated, and yet is not the constant."""
    monkeypatch.setattr("exover.engines.aig.simulation.reduction.REFINE", 1)
    graph = Graph()
    latches = [graph.latch(False) for _ in range(40)]
    whole = graph.all(latches)
    circuit = graph.circuit(latches, [whole, graph.all((whole, graph.input()))])
    assert smaller(circuit).bad == circuit.bad
