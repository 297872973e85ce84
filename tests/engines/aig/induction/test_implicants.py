"""Kinds of states are excluded cube by cube exactly where enumeration reaches none of them."""

from collections.abc import Callable
from random import Random

import pytest

from exover.engines.aig.circuit.answer import Answer, Open
from exover.engines.aig.circuit.graph import TRUE, Circuit, Graph
from exover.engines.aig.induction import implicants, pdr
from exover.engines.aig.induction.implicants import Implicants, StatesOfKind
from tests.support.circuits import random_circuit, reachable
from tests.support.confirming import excludes, is_invariant, makes_true


def decide(circuit: Circuit, say: Callable[[int, Answer], None], stop: Callable[[], bool]) -> None:
    pdr.decide(circuit, say, stop=stop, budget=10_000_000)


def undecided(circuit: Circuit, say: Callable[[int, Answer], None], stop: Callable[[], bool]) -> None:
    for index in range(len(circuit.bad)):
        say(index, Open("no time"))


def graph_of(circuit: Circuit) -> Graph:
    known = {pair: 2 * node for node, pair in enumerate(circuit.fanins) if pair is not None}
    latches = [(latch.node, latch.initial) for latch in circuit.latches]
    return Graph(circuit.fanins.copy(), list(circuit.inputs), latches, known)


def random_kinds(seed: int, graph: Graph) -> list[StatesOfKind]:
    """Return kinds over the latches alone."""
    source, known = Random(seed), [2 * node for node, _ in graph.latches]
    for _ in range(30):
        one, other = source.choice(known), source.choice(known)
        known.append(graph.conjunction(one ^ source.getrandbits(1), other ^ source.getrandbits(1)))
    return [(source.choice(known) ^ source.getrandbits(1), source.choice(known)) for _ in range(8)]


@pytest.mark.parametrize("seed", range(25))
@pytest.mark.parametrize("kept", [0, implicants.KEPT], ids=["none kept", "kept"])
def test_what_is_excluded_is_what_enumeration_does_not_reach(
    seed: int, kept: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whether solvers are kept or made again."""
    monkeypatch.setattr(implicants, "KEPT", kept)
    circuit = random_circuit(seed)
    graph, following = graph_of(circuit), [latch.next for latch in circuit.latches]
    kinds = random_kinds(seed, graph)
    wanted = reachable(graph.circuit(following, [graph.all(kind) for kind in kinds]))
    found = Implicants(graph, following, TRUE, decide, lambda: False)
    left = list(range(len(kinds)))
    while left:
        excluded, runs = found.exclude({index: kinds[index] for index in left})
        assert excluded or runs
        whole = graph.circuit(following, [graph.all(kinds[index]) for index in left])
        for place, bad in enumerate(whole.bad):
            if left[place] in excluded:
                assert left[place] not in wanted
                assert excludes(whole, tuple(found.clauses), bad)
        assert is_invariant(whole, tuple(found.clauses))
        shown = {n for run in runs for n, bad in enumerate(whole.bad) if makes_true(whole, bad, run)}
        assert bool(shown) == bool(runs)
        left = [index for place, index in enumerate(left) if index not in excluded and place not in shown]


def test_the_solver_of_a_kind_is_kept_until_it_is_excluded() -> None:
    """It goes on with the circuit that tells the kind now, and with what was proved meanwhile."""
    graph = Graph()
    low, high, other = graph.latch(False), graph.latch(False), graph.latch(True)
    found = Implicants(graph, [low, high, other], TRUE, decide, lambda: False)
    _, runs = found.exclude({5: (other, low ^ 1)})
    assert runs
    solver = found._searches[5].solver
    assert found.exclude({7: (low, high)})[0] == [7]
    grown = graph.conjunction(low, graph.conjunction(high, other))
    assert found.exclude({5: (TRUE, grown)}) == ([5], [])
    assert found.excluded.keys() == {(low, (high,))}, "what was proved of another kind is known"
    assert solver.knows(grown >> 1), "it was made anew"
    assert not found._searches


def test_nothing_is_excluded_that_is_not_proved() -> None:
    graph = Graph()
    low, high = graph.latch(False), graph.latch(False)
    found = Implicants(graph, [low, high], TRUE, undecided, lambda: False)
    assert found.exclude({5: (low, high), 7: (low, low ^ 1)}) == ([7], [])
    assert not found.clauses
