"""Facts about one or two latches."""

import pytest

from exover.engines.aig.circuit.graph import FALSE, Circuit, Graph
from exover.engines.aig.induction.unreachable_cubes import unreachable_cubes
from exover.engines.aig.simulation.reached import Cube, reached
from exover.engines.aig.simulation.runs import simulate
from tests.support.circuits import random_circuit
from tests.support.confirming import is_invariant


def found(circuit: Circuit, lanes: int = 4, steps: int = 3, granted: int = 10**9) -> set[Cube]:
    runs = simulate(circuit, lanes=lanes, steps=steps)
    latches = circuit.support(circuit.bad)
    return set(unreachable_cubes(circuit, latches, reached(latches, runs), granted=granted))


@pytest.mark.parametrize("seed", range(80))
def test_facts_are_an_invariant(seed: int) -> None:
    circuit = random_circuit(seed, latches=8)
    cubes = found(circuit)
    assert is_invariant(circuit, [tuple(literal ^ 1 for literal in cube) for cube in cubes])
    assert cubes == found(circuit)


def excluding() -> tuple[Circuit, list[int]]:
    """Two flags that exclude each other, a copy of the first, and a constant."""
    graph = Graph()
    one, two = graph.input(), graph.input()
    a, b, copy, never = (graph.latch(False) for _ in range(4))
    first = graph.conjunction(one, b ^ 1)
    second = graph.all((two, a ^ 1, first ^ 1))
    following = [first, second, first, graph.conjunction(never, one)]
    return graph.circuit(following, [graph.all((a, b, copy, never))]), [a, b, copy, never]


def test_exclusion_equality_and_constants_are_found() -> None:
    circuit, (a, b, copy, never) = excluding()
    assert found(circuit, 64, 9) == {(never,), (a, b), (b, copy), (a, copy ^ 1), (a ^ 1, copy)}


def test_facts_that_cost_too_much_are_none() -> None:
    circuit, _ = excluding()
    assert found(circuit, granted=0) == set()


def test_no_guesses_no_facts() -> None:
    graph = Graph()
    assert found(graph.circuit([], [FALSE])) == set()
