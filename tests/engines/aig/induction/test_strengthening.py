"""Circuits constrained by an invariant, and which clauses are one."""

from dataclasses import replace
from functools import cache

import pytest

from exover.engines.aig.circuit.answer import Answer, Clause, Unreachable
from exover.engines.aig.circuit.graph import FALSE, Circuit, Graph
from exover.engines.aig.induction import strengthening
from exover.engines.aig.induction.pdr import decide
from exover.engines.aig.induction.strengthening import Lemmas, strengthened
from tests.support.circuits import random_circuit, reachable, verdicts
from tests.support.confirming import confirms, is_invariant


def answered(circuit: Circuit) -> dict[int, Answer]:
    answers: dict[int, Answer] = {}
    decide(circuit, answers.__setitem__)
    return answers


@cache
def learnt(seed: int) -> tuple[Circuit, list[tuple[Clause, ...]]]:
    """Return a circuit, and the invariants by which bad literals were excluded."""
    circuit = random_circuit(seed, latches=8)
    return circuit, [answer.invariant for answer in answered(circuit).values() if isinstance(answer, Unreachable)]


@pytest.mark.parametrize("seed", range(40))
def test_a_strengthened_circuit_has_the_same_answers_and_gives_invariants(seed: int) -> None:
    circuit, invariants = learnt(seed)
    lemmas = Lemmas()
    for invariant in invariants[:1]:
        lemmas.add(invariant)
    strong = strengthened(circuit, lemmas.of(circuit))
    answers = {index: strong.answer(answer) for index, answer in answered(strong.circuit).items()}
    everywhere = reachable(circuit)
    assert verdicts(answers) == (everywhere, set(range(len(circuit.bad))) - everywhere)
    assert all(confirms(circuit, circuit.bad[index], answer) for index, answer in answers.items())


@pytest.mark.parametrize("seed", range(40))
def test_lemmas_are_an_invariant_of_whatever_part_and_start(seed: int) -> None:
    circuit, invariants = learnt(seed)
    lemmas = Lemmas()
    for invariant in invariants:
        lemmas.add(invariant)
    assert is_invariant(circuit, lemmas.of(circuit))
    fewer = replace(circuit, latches=circuit.support(circuit.bad[:1]))
    flipped = replace(circuit, latches=tuple(replace(each, initial=not each.initial) for each in circuit.latches))
    assert is_invariant(fewer, lemmas.of(fewer)) and is_invariant(flipped, lemmas.of(flipped))


def test_what_rests_on_known_clauses_is_said_with_them() -> None:
    graph = Graph()
    one, other = graph.latch(False), graph.latch(False)
    circuit = graph.circuit([one, one], [other])
    strong = strengthened(circuit, [(one ^ 1,)])
    left = 2 * strong.left
    proof = Unreachable(((left, other ^ 1), (left ^ 1, one)))
    assert strong.answer(proof) == Unreachable(((one ^ 1,), (other ^ 1,)))
    assert confirms(circuit, other, strong.answer(proof)) and not is_invariant(circuit, [(other ^ 1,)])


def test_clauses_that_are_known_are_learnt_once() -> None:
    lemmas = Lemmas()
    circuit, invariants = next(found for found in map(learnt, range(99)) if any(found[1]))
    (first, *_) = filter(None, invariants)
    lemmas.add(first)
    apart = lemmas.copy()
    lemmas.add(first[:1])
    assert set(lemmas.of(circuit)) == set(first) == set(apart.of(circuit))
    assert Lemmas().of(circuit) == () and strengthened(circuit, ()).circuit == circuit


def test_the_part_that_fewer_latches_keep_is_proved_once(monkeypatch: pytest.MonkeyPatch) -> None:
    graph = Graph()
    one, other = graph.latch(False), graph.latch(False)
    fewer = graph.circuit([one, one], [FALSE])
    lemmas = Lemmas()
    lemmas.add([(one ^ 1,), (other ^ 1, one ^ 1)])
    fewer = replace(fewer, latches=fewer.latches[:1])
    proved = lemmas.of(fewer)
    monkeypatch.delattr(strengthening, "Induction")
    assert proved == lemmas.of(fewer) == ((one ^ 1,),)
