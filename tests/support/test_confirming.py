"""What the checker of answers refuses."""

import pytest

from exover.engines.aig.circuit.answer import Answer, Open, Reachable, Unreachable
from exover.engines.aig.circuit.graph import FALSE, Graph
from exover.engines.aig.induction.pdr import decide
from tests.support.circuits import counter, random_circuit
from tests.support.confirming import confirms, is_invariant


def two_bits() -> tuple[Graph, int, int, int]:
    graph = Graph()
    return graph, graph.input(), graph.latch(False), graph.latch(False)


def test_a_clause_that_the_start_breaks_is_refused() -> None:
    graph, _, a, b = two_bits()
    circuit = graph.circuit([a, b], [a])
    assert confirms(circuit, a, Unreachable(((a ^ 1,),)))
    assert not is_invariant(circuit, [(b,)])


def test_a_clause_that_a_step_breaks_is_refused() -> None:
    graph, go, a, b = two_bits()
    circuit = graph.circuit([b, graph.any((b, go))], [a])
    assert not is_invariant(circuit, [(a ^ 1,)])
    assert is_invariant(circuit, [(a ^ 1, b)])


def test_an_invariant_that_does_not_exclude_is_refused() -> None:
    graph, _, a, b = two_bits()
    circuit = graph.circuit([a, b], [b])
    assert not confirms(circuit, b, Unreachable(((a ^ 1,),)))
    assert not confirms(circuit, b, Unreachable(()))
    assert confirms(circuit, FALSE, Unreachable(()))


def test_a_clause_about_something_else_than_latches_is_refused() -> None:
    graph, go, a, b = two_bits()
    both = graph.conjunction(a, b)
    circuit = graph.circuit([a, b], [both])
    assert not is_invariant(circuit, [(both ^ 1,)])
    assert not is_invariant(circuit, [(go ^ 1,)])


def test_runs_are_replayed() -> None:
    circuit = counter(3, 7, 2)
    bad, go = circuit.bad[0], frozenset(circuit.inputs)
    assert confirms(circuit, bad, Reachable((go, go, go)))
    assert confirms(circuit, bad, Reachable((go, go, frozenset())))
    assert not confirms(circuit, bad, Reachable((go, go)))
    assert not confirms(circuit, bad, Reachable(()))
    assert not confirms(circuit, bad, Reachable((frozenset({circuit.latches[0].node}),) * 3))
    assert not confirms(circuit, bad, Open("no time"))


@pytest.mark.parametrize("seed", range(60))
def test_mutated_invariants_are_refused_unless_they_are_invariants(seed: int) -> None:
    """A literal that is flipped, a clause that is dropped: the start or a step breaks them, or they still hold."""
    circuit = random_circuit(seed, latches=5)
    answers: dict[int, Answer] = {}
    decide(circuit, answers.__setitem__)
    latches = {latch.node: latch for latch in circuit.latches}
    for answer in answers.values():
        if isinstance(answer, Unreachable) and answer.invariant:
            clause = answer.invariant[0]
            for at, literal in enumerate(clause):
                mutant = (*clause[:at], literal ^ 1, *clause[at + 1 :])
                if not any(latches[each >> 1].initial != (each & 1) for each in mutant):
                    assert not is_invariant(circuit, [mutant])


def test_an_invariant_without_one_of_its_clauses_is_refused() -> None:
    circuit = counter(6, 20, 50)
    answers: dict[int, Answer] = {}
    decide(circuit, answers.__setitem__)
    answer = answers[0]
    assert isinstance(answer, Unreachable) and confirms(circuit, circuit.bad[0], answer)
    refused = 0
    for at in range(len(answer.invariant)):
        rest = answer.invariant[:at] + answer.invariant[at + 1 :]
        refused += not confirms(circuit, circuit.bad[0], Unreachable(rest))
    assert refused
