"""Induction of several questions together: what it proves is true by enumeration, and needs no clause to be found."""

import pytest

from exover.engines.aig.circuit.graph import Circuit, Graph
from exover.engines.aig.induction import mutual_induction
from exover.engines.aig.induction.mutual_induction import mutually_inductive
from tests.support.circuits import counter, random_circuit, reachable


def test_what_it_proves_no_run_reaches() -> None:
    proved = 0
    for seed in range(300):
        circuit = random_circuit(seed)
        found = mutually_inductive(circuit)
        assert not reachable(circuit) & set(found), seed
        proved += len(found)
    assert proved > 100


def sums(bits: int, most: int) -> Circuit:
    """Return what takes, one a step and only if inputs ask for it, as many of so many bits as may be set at once; bad
    is where more are, and where a step takes nothing and more are."""
    graph = Graph()
    take, give = ([graph.input() for _ in range(bits)] for _ in range(2))
    taken = [graph.latch(False) for _ in range(bits)]
    counts = [graph.all(())]
    for each in taken:
        more = [graph.conjunction(count, each) for count in counts]
        same = [graph.conjunction(count, each ^ 1) for count in counts]
        counts = [graph.any(pair) for pair in zip([*same, 0], [0, *more], strict=True)]
    free, only = graph.any(counts[:most]), graph.all(())
    following = []
    for flag, asked, given in zip(taken, take, give, strict=True):
        now = graph.all((asked, only, free))
        only = graph.conjunction(only, asked ^ 1)
        following.append(graph.any((now, graph.conjunction(flag, given ^ 1))))
    over = graph.any(counts[most + 1 :])
    return graph.circuit(following, [over, graph.all((over, only)), graph.all((over ^ 1, counts[most]))])


def test_a_sum_is_kept_of_which_no_clause_over_few_bits_is() -> None:
    assert mutually_inductive(sums(20, 10)) == [0, 1]


@pytest.mark.parametrize("wanted", [5, 6, 7])
def test_one_step_may_be_too_few(wanted: int) -> None:
    """The numbers beyond the limit lead to each other: only the first of them has nothing before it."""
    circuit = counter(3, 4, wanted)
    assert reachable(circuit) == set()
    assert mutually_inductive(circuit) == ([0] if wanted == 5 else [])


def test_clauses_that_are_known_count() -> None:
    """A bit that is never set would set the other."""
    graph = Graph()
    low, high = graph.latch(False), graph.latch(False)
    circuit = graph.circuit([low, graph.any((high, low))], [high])
    assert mutually_inductive(circuit) == []
    assert mutually_inductive(circuit, [(low ^ 1,)]) == [0]


def test_a_first_step_is_looked_at() -> None:
    graph = Graph()
    go = graph.input()
    assert mutually_inductive(graph.circuit([], [go, 0])) == [1]


def test_a_step_that_changes_nothing_is_left_out() -> None:
    graph = Graph()
    go, flag = graph.input(), graph.latch(False)
    assert mutually_inductive(graph.circuit([flag], [graph.conjunction(go, flag)])) == [0]


def test_hard_questions_are_asked_again_at_last(monkeypatch: pytest.MonkeyPatch) -> None:
    """With one propagation each at first, nothing is left open; what is granted in all is a limit."""
    circuits = [sums(8, 4), *map(random_circuit, range(40))]
    found = [mutually_inductive(circuit) for circuit in circuits]
    monkeypatch.setattr(mutual_induction, "SOON", 1)
    assert [mutually_inductive(circuit) for circuit in circuits] == found
    monkeypatch.setattr(mutual_induction, "EFFORT", 1)
    assert mutually_inductive(circuits[0]) == []
