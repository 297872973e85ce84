"""What takes the place of a circuit equals it, whatever was offered."""

from dataclasses import replace
from itertools import product

import pytest

from exover.engines.aig import abc, miter
from exover.engines.aig.evaluation import evaluator
from exover.engines.aig.graph import FALSE, Circuit
from tests.support.abc import needs_abc
from tests.support.circuits import random_circuit


def outputs(circuit: Circuit) -> list[tuple[bool, ...]]:
    """Return what latches become and which bad literals are true, for every state and input."""
    roots = [*(latch.next for latch in circuit.latches), *circuit.bad]
    cone = evaluator(circuit, roots)
    leaves = [*circuit.inputs, *(latch.node for latch in circuit.latches)]
    found = []
    for chosen in product((0, 1), repeat=len(leaves)):
        values = cone.values(dict(zip(leaves, chosen, strict=True)))
        found.append(tuple(bool(cone.read(values, root, 1)) for root in roots))
    return found


@pytest.mark.parametrize("seed", range(30))
def test_what_is_equal_is_taken_and_what_is_not_stays(seed: int) -> None:
    circuit = random_circuit(seed, latches=5, gates=40)
    same = replace(circuit, bad=tuple(circuit.bad[:3]) + (FALSE,) * 3)
    wrong = tuple(replace(latch, next=latch.next ^ (number == 2)) for number, latch in enumerate(same.latches))
    found = miter.confirmed(circuit, replace(same, latches=wrong))
    assert outputs(found) == outputs(circuit)
    assert found.inputs == circuit.inputs and [each.initial for each in found.latches] == [
        each.initial for each in circuit.latches
    ]


def test_nothing_is_taken_without_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(miter, "GRANTED", 0)
    circuit = random_circuit(4, gates=40)
    found = miter.confirmed(circuit, replace(circuit, bad=(FALSE,) * len(circuit.bad)))
    assert outputs(found) == outputs(circuit)


@needs_abc
@pytest.mark.parametrize("seed", range(12))
def test_what_abc_makes_smaller_is_equal(seed: int) -> None:
    circuit = random_circuit(seed, latches=5, gates=80)
    smaller = abc.smaller(circuit, 60, abc.find())
    assert outputs(smaller) == outputs(circuit)
    assert len(smaller.fanins) < len(circuit.fanins)


@needs_abc
def test_where_abc_says_nothing_the_circuit_stays() -> None:
    circuit = random_circuit(1)
    assert abc.smaller(circuit, 0.0001, abc.find()) is circuit
    assert abc.smaller(circuit, 60, "/nowhere/abc") is circuit
