"""Clauses that every step keeps: of an invariant what is enough for a question."""

from contextlib import closing

import pytest

from exover.engines.aig.circuit.answer import Answer, Clause, Unreachable
from exover.engines.aig.circuit.graph import Circuit, Graph, Literal
from exover.engines.aig.induction.inductive import Induction
from exover.engines.aig.induction.pdr import decide
from tests.support.circuits import random_circuit
from tests.support.confirming import excludes, is_invariant


def invariants(circuit: Circuit) -> dict[int, tuple[Clause, ...]]:
    """Return by index of bad literals that are never true what shows it."""
    answers: dict[int, Answer] = {}
    decide(circuit, answers.__setitem__)
    return {index: answer.invariant for index, answer in answers.items() if isinstance(answer, Unreachable)}


@pytest.mark.parametrize("seed", range(40))
def test_what_is_enough_is_an_invariant_of_the_given_clauses_and_excludes_the_literal(seed: int) -> None:
    circuit = random_circuit(seed)
    known = invariants(circuit)
    whole = tuple(dict.fromkeys(clause for clauses in known.values() for clause in clauses))
    with closing(Induction(circuit)) as induction:
        for index in known:
            found = induction.enough(whole, circuit.bad[index])
            assert set(found) <= set(whole)
            assert is_invariant(circuit, found) and excludes(circuit, found, circuit.bad[index])


def shifts(graph: Graph, length: int) -> list[Literal]:
    """Return the latches of a register that only ever takes in what it holds, none of it true at the start."""
    return [graph.latch(False) for _ in range(length)]


def test_clauses_about_something_else_are_left_out() -> None:
    graph = Graph()
    one, other = shifts(graph, 3), shifts(graph, 3)
    circuit = graph.circuit([*one[-1:], *one[:-1], *other[-1:], *other[:-1]], [one[0], other[0]])
    clauses = tuple((latch ^ 1,) for latch in (*one, *other))
    with closing(Induction(circuit)) as induction:
        assert set(induction.enough(clauses, one[0])) == set(clauses[:3])
        assert set(induction.enough(clauses, other[0])) == set(clauses[3:])
        assert set(induction.enough(clauses[:2], one[0])) == set(clauses[:2])  # no step keeps these
        assert induction.enough((), one[0]) == ()
