"""Runs that go on from reached states, and short ones from the start."""

from collections.abc import Callable
from contextlib import closing
from dataclasses import replace

import pytest

from exover.engines.aig.abc import prover
from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import Circuit
from exover.engines.aig.induction.reached_bmc import Depth, RunSearch, runs_from, runs_from_start
from exover.engines.aig.simulation.exploration import Seed
from exover.engines.aig.simulation.replay import replayed
from exover.engines.aig.simulation.runs import random_words, simulate
from tests.support.circuits import counter, random_circuit, reachable
from tests.support.needed import needs_abc

DEEP = Depth(steps=70, each=10**9, patience=10**9)
"""More steps than a circuit of six latches has states."""


def start_of(circuit: Circuit) -> Seed:
    """Return the start."""
    return Seed(frozenset(latch.node for latch in circuit.latches if latch.initial), ())


def counted(circuit: Circuit, number: int) -> Seed:
    """Return where a counter is after as many steps."""
    (go,) = circuit.inputs
    true = frozenset(latch.node for place, latch in enumerate(circuit.latches) if number >> place & 1)
    return Seed(true, (frozenset({go}),) * number)


def shows(circuit: Circuit, runs: dict[int, Inputs]) -> bool:
    """Return whether each run makes its bad literal true in its last step."""
    return all(replayed(circuit, [(circuit.bad[index], run) for index, run in runs.items()]))


@pytest.mark.parametrize("seed", range(40))
def test_unrolled_far_enough_everything_is_found_that_is_reachable(seed: int) -> None:
    circuit = random_circuit(seed)
    found = runs_from(circuit, range(len(circuit.bad)), [start_of(circuit)], DEEP)
    assert found.keys() == reachable(circuit)
    assert shows(circuit, found)


@pytest.mark.parametrize("seed", range(20))
def test_only_what_is_asked_is_answered_by_its_index(seed: int) -> None:
    circuit = random_circuit(seed)
    asked = [4, 1]
    found = runs_from(circuit, asked, [start_of(circuit)], DEEP)
    assert found.keys() == reachable(circuit) & set(asked)
    assert shows(circuit, found)


def test_a_run_goes_on_from_the_state_that_is_near() -> None:
    """From 0, 20 or 40 a counter comes to 44 in five steps from 40 alone, and in 45 from the start."""
    circuit = counter(6, 63, 44)
    seeds = [counted(circuit, number) for number in (0, 20, 40)]
    assert runs_from(circuit, [0], seeds, Depth(steps=4)) == {}
    found = runs_from(circuit, [0], seeds, Depth(steps=5))
    assert found[0][:40] == seeds[2].run and len(found[0]) == 45
    assert shows(circuit, found)
    assert runs_from(circuit, [0], seeds[:1], Depth(steps=44)) == {}


def test_seeds_that_are_added_count_and_what_was_false_without_them_may_be_true() -> None:
    circuit = counter(6, 63, 44)
    with closing(RunSearch(circuit, [0])) as search:
        for near, steps in ((0, 8), (30, 9), (40, 3), (40, 8)):
            search.add([counted(circuit, near)])
            found = search.runs([0], Depth(steps))
            assert bool(found) == (near + steps > 44)
        assert len(found[0]) == 45 and shows(circuit, found)
        search.add([counted(circuit, 42)])  # nearer now: no step is left over from the longer search
        found = search.runs([0], Depth(3))
        assert len(found[0]) == 45 and shows(circuit, found)


@pytest.mark.parametrize("seed", range(20))
def test_what_is_found_in_turns_is_what_is_found_at_once(seed: int) -> None:
    circuit = random_circuit(seed)
    walk = simulate(circuit, stimulus=random_words(circuit, 1, seed), steps=12, lanes=1)
    states = [
        Seed(frozenset(n for n, bit in now.items() if bit), walk.run(at - 1, 0)) for at, now in enumerate(walk.states)
    ][1:]
    asked = range(len(circuit.bad))
    with closing(RunSearch(circuit, asked)) as search:
        for turn in range(3):
            search.add(states[turn * 4 : turn * 4 + 4])
            found = search.runs(asked, Depth(steps=2))
            assert shows(circuit, found)
            assert found.keys() == runs_from(circuit, asked, states[: turn * 4 + 4], Depth(steps=2)).keys()


def test_of_runs_to_one_state_the_first_is_gone_on_with() -> None:
    circuit = counter(6, 63, 44)
    seed = counted(circuit, 40)
    longer = replace(seed, run=(frozenset[int](), *seed.run))
    found = runs_from(circuit, [0], [counted(circuit, 1), seed, longer])
    assert len(found[0]) == 45


def test_work_is_bounded() -> None:
    """Nothing is looked for once so much was done in vain; what was found before that counts."""
    circuit = counter(6, 63, 44)
    assert runs_from(circuit, [0], [counted(circuit, 40)], Depth(patience=-1)) == {}
    assert runs_from(circuit, [0], [counted(circuit, number) for number in range(40)], Depth(each=1, patience=1)) == {}


def test_equal_questions_have_equal_answers() -> None:
    circuit = random_circuit(3, gates=60)
    seeds = [start_of(circuit)]
    assert runs_from(circuit, range(6), seeds, DEEP) == runs_from(circuit, range(6), seeds, DEEP)


def by_abc(circuit: Circuit) -> dict[int, Inputs]:
    """Return what ABC finds."""
    return prover.unrolled(circuit, prover.find())


@pytest.mark.parametrize("find", [runs_from_start, pytest.param(by_abc, marks=needs_abc)])
def test_short_runs_from_any_start(find: Callable[[Circuit], dict[int, Inputs]]) -> None:
    """From 40 a counter is at 44 after five steps; from 20 it is too far."""
    circuit = counter(6, 63, 44)
    for number, steps in ((40, {5}), (20, set[int]())):
        true = counted(circuit, number).true
        latches = tuple(replace(latch, initial=latch.node in true) for latch in circuit.latches)
        begun = replace(circuit, latches=latches)
        found = find(begun)
        assert set(map(len, found.values())) == steps
        assert shows(begun, found)


def test_a_program_that_is_no_abc_finds_nothing() -> None:
    assert prover.unrolled(counter(3, 7, 2), "/bin/true") == {}
