"""Verdicts of the search, compared with enumeration."""

import pytest

from exover.engines.aig.circuit.answer import Answer, Open, Reachable, Unreachable
from exover.engines.aig.circuit.graph import Circuit, Graph
from exover.engines.aig.induction.pdr import decide
from exover.engines.aig.simulation.runs import simulate
from tests.support.circuits import counter, is_number, random_circuit, reachable, verdicts
from tests.support.confirming import confirms


def decided(circuit: Circuit, **options: object) -> dict[int, Answer]:
    answers: dict[int, Answer] = {}

    def say(index: int, answer: Answer) -> None:
        assert index not in answers
        answers[index] = answer

    decide(circuit, say, **{"runs": simulate(circuit, lanes=2, steps=2), **options})  # type: ignore[arg-type]
    return answers


@pytest.mark.parametrize("seed", range(100))
def test_verdicts_are_those_of_enumeration(seed: int) -> None:
    circuit = random_circuit(seed, latches=2 + seed % 7)
    answers = decided(circuit)
    yes = reachable(circuit)
    assert verdicts(answers) == (yes, set(range(len(circuit.bad))) - yes)
    assert all(confirms(circuit, circuit.bad[index], answer) for index, answer in answers.items())
    assert seed % 10 or decided(circuit) == answers


@pytest.mark.parametrize("width", [10, 13, 16])
def test_a_counter_never_passes_its_limit(width: int) -> None:
    circuit = counter(width, 255, 300)
    answer = decided(circuit, runs=simulate(circuit, lanes=8, steps=600))[0]
    assert isinstance(answer, Unreachable) and confirms(circuit, circuit.bad[0], answer)


def test_a_counter_comes_to_its_limit() -> None:
    circuit = counter(10, 40, 40)
    answer = decided(circuit)[0]
    assert isinstance(answer, Reachable) and len(answer.inputs) == 41
    assert confirms(circuit, circuit.bad[0], answer)


def test_one_hard_question_holds_up_no_other() -> None:
    graph = Graph()
    go = graph.input()
    bits = [graph.latch(False) for _ in range(14)]
    flag = graph.latch(False)
    carry, following = go, []
    for bit in bits:
        following.append(graph.differ(bit, carry))
        carry = graph.conjunction(bit, carry)
    far = is_number(graph, bits, 9000)
    circuit = graph.circuit([*following, graph.conjunction(flag, go)], [far, flag, bits[2]])
    answers = decided(circuit, budget=3_000_000)
    assert isinstance(answers[0], Open) and "3000000 propagations" in answers[0].reason
    assert isinstance(answers[1], Unreachable)
    assert isinstance(answers[2], Reachable)
    assert decided(circuit, budget=3_000_000) == answers


def test_what_is_stopped_is_open() -> None:
    circuit = counter(12, 600, 1000)
    assert decided(circuit, stop=lambda: True) == {0: Open("stopped")}


def test_only_what_is_asked_is_answered() -> None:
    circuit = random_circuit(3)
    assert set(decided(circuit, asked=[4, 1])) == {1, 4}


def test_known_clauses_are_used() -> None:
    circuit = counter(6, 20, 50)
    first = decided(circuit)[0]
    assert isinstance(first, Unreachable)
    assert decided(circuit, known=first.invariant)[0] == first
