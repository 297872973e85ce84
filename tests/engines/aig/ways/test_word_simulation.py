"""Words are run from all states at once, and as few are chosen as lead on from where any does."""

from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import Graph
from exover.engines.aig.simulation.evaluation import evaluator
from exover.engines.aig.simulation.exploration import Seed
from exover.engines.aig.ways.word_simulation import WordSimulation

GRAPH = Graph()
UP, DOWN = (GRAPH.input() for _ in range(2))
A, B = (GRAPH.latch(False) for _ in range(2))
NEXT = [
    GRAPH.conjunction(GRAPH.any((A, GRAPH.conjunction(UP, B))), DOWN ^ 1),
    GRAPH.conjunction(GRAPH.any((B, UP)), DOWN ^ 1),
]
"""`UP` sets b, and then a; `DOWN` clears both."""
CIRCUIT = GRAPH.circuit(NEXT, [GRAPH.conjunction(A, UP), GRAPH.all((A ^ 1, B ^ 1, UP))])
GO, BACK = frozenset({UP >> 1}), frozenset({DOWN >> 1})
EMPTY, LOW, HIGH = Seed(frozenset(), ()), Seed(frozenset({B >> 1}), ()), Seed(frozenset({A >> 1, B >> 1}), ())


def rehearsal() -> WordSimulation:
    made = WordSimulation(CIRCUIT, evaluator(CIRCUIT, CIRCUIT.bad, CIRCUIT.latches))
    made.add([EMPTY, LOW, HIGH], {0: 0b111, 1: 0b110})
    return made


def test_what_no_word_helps_is_known() -> None:
    made = rehearsal()
    assert made.unhelped() == {0: 0b111, 1: 0b110}
    made.learn([(GO,), (GO, GO)])
    assert made.unhelped() == {0: 0b001, 1: 0b110}
    made.learn([(GO, GO, GO), (BACK, GO)])
    assert made.unhelped() == {0: 0, 1: 0}


def test_few_words_are_chosen() -> None:
    made = rehearsal()
    words: list[Inputs] = [(GO,), (GO, GO), (GO, GO, GO), (BACK, GO)]
    made.learn(words)
    assert made.chosen(0) == [(GO, GO, GO)]
    assert made.chosen(1) == [(BACK, GO)]


def test_states_that_come_later_are_tried_with_all_words() -> None:
    made = rehearsal()
    made.learn([(GO, GO)])
    made.add([HIGH, EMPTY], {0: 0b11})
    assert made.unhelped()[0] == 0b10001
    made.drop(0)
    assert made.unhelped() == {1: 0b110}


def test_one_word_after_another_is_a_word() -> None:
    made = rehearsal()
    made.learn([(GO,), (GO, GO)])
    assert made.composed(EMPTY, [1, 0]) == {0: (GO, GO), 1: (GO, GO, GO)}
    assert made.composed(HIGH, [1]) == {}


def test_many_states_are_run_in_parts() -> None:
    made = WordSimulation(CIRCUIT, evaluator(CIRCUIT, CIRCUIT.bad, CIRCUIT.latches))
    samples = [EMPTY, HIGH] * 40_000
    made.add(samples, {0: (1 << len(samples)) - 1})
    made.learn([(GO,)])
    assert made.unhelped()[0] == sum(1 << number for number in range(0, len(samples), 2))
