"""States of several simulations."""

from collections.abc import Mapping
from dataclasses import replace

import pytest

from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import FALSE, Circuit
from exover.engines.aig.simulation.reached import reached
from exover.engines.aig.simulation.runs import random_words, simulate
from tests.support.circuits import random_circuit


def state_after(circuit: Circuit, inputs: Inputs) -> Mapping[int, int]:
    """Return the latches after a run."""
    steps = [*inputs, frozenset[int]()]
    runs = simulate(circuit, stimulus=lambda step, _: dict.fromkeys(steps[step], 1), steps=len(steps), lanes=1)
    return runs.states[-1]


@pytest.mark.parametrize("seed", range(30))
def test_the_path_to_a_state_leads_to_it(seed: int) -> None:
    """Whichever of three simulations reached it."""
    circuit = random_circuit(seed, bad=1, gates=40)
    circuit = replace(circuit, bad=(*circuit.bad, FALSE))
    latches = circuit.support(circuit.bad)
    batches = [
        simulate(circuit, stimulus=random_words(circuit, lanes, lanes), steps=6, lanes=lanes) for lanes in (3, 5, 1)
    ]
    known = reached(latches, batches[0])
    for runs in batches[1:]:
        known.add(runs)
    assert known.size == 6 * 9 and known.where(()) == (1 << known.size) - 1
    for at in range(known.size):
        state = state_after(circuit, known.path(1 << at))
        assert all(state[latch.node] == known.words[2 * latch.node] >> at & 1 for latch in latches)
