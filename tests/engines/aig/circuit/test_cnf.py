"""Clauses of nodes: what they allow is what the conjunctions say, in fewer variables."""

from itertools import product
from random import Random

import pytest

from exover.engines.aig.circuit.cnf import LEAVES, Cnf, signed
from exover.engines.aig.circuit.graph import Circuit, Graph
from exover.engines.aig.circuit.solver import Solver
from tests.support.circuits import random_circuit


def value(circuit: Circuit, node: int, leaves: dict[int, bool]) -> bool:
    """Return what a node is where leaves are known."""
    if node in leaves:
        return leaves[node]
    pair = circuit.fanins[node]
    return pair is not None and all(value(circuit, each >> 1, leaves) != bool(each & 1) for each in pair)


@pytest.mark.parametrize("seed", range(60))
def test_clauses_leave_a_node_just_its_value(seed: int) -> None:
    circuit = random_circuit(seed, latches=2 + seed % 6, gates=60)
    cnf = Cnf(circuit)
    for node in circuit.cone([*circuit.bad, *(latch.next for latch in circuit.latches)]):
        gate = cnf.gate(node)
        assert (gate is None) == (circuit.fanins[node] is None)
        if gate is None:
            continue
        leaves, clauses = gate
        assert len(leaves) <= LEAVES
        for values in product((False, True), repeat=len(leaves)):
            wanted = value(circuit, node, dict(zip(leaves, values, strict=True)))
            allowed = []
            for given in (False, True):
                literals = signed([1 if each else -1 for each in (*values, given)])
                if all(max(pick(literals)) == 1 for pick in clauses):
                    allowed.append(given)
            assert allowed == [wanted]


@pytest.mark.parametrize("seed", range(30))
def test_a_node_that_others_hide_is_known_once_it_is_asked_for(seed: int) -> None:
    """Nodes are asked for in any order, of a graph that grows meanwhile."""
    random = Random(seed)
    graph = Graph()
    inputs = [graph.input() for _ in range(4)]
    nodes = list(inputs)
    solver = Solver(graph.circuit((), ()))
    for _ in range(3):
        for _ in range(12):
            one, other = random.sample(nodes, 2)
            nodes.append(graph.conjunction(one ^ random.randrange(2), other ^ random.randrange(2)))
        circuit = graph.circuit((), ())
        solver.grow(circuit)
        for literal in random.sample(nodes, 8):
            chosen = {each >> 1: bool(random.randrange(2)) for each in inputs}
            assumed = [solver.literal(2 * node + (not true)) for node, true in chosen.items()]
            wanted = value(circuit, literal >> 1, chosen) != bool(literal & 1)
            assert solver.satisfiable([*assumed, solver.literal(literal)]) == wanted
    solver.close()


def test_a_choice_is_one_gate() -> None:
    """Nine clauses and three variables of two conjunctions each become four clauses and one variable."""
    graph = Graph()
    test, high, low = (graph.input() for _ in range(3))
    chosen = graph.choose(test, high, low)
    gate = Cnf(graph.circuit((), (chosen,))).gate(chosen >> 1)
    assert gate is not None
    leaves, clauses = gate
    assert (sorted(leaves), len(clauses)) == (sorted((test >> 1, high >> 1, low >> 1)), 4)
