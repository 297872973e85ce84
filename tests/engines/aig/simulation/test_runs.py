"""Runs side by side, and shorter ones."""

from random import Random
from threading import Event
from threading import active_count as threads

import pytest

from exover.engines.aig.circuit import kernel as compiled
from exover.engines.aig.circuit.answer import Reachable
from exover.engines.aig.circuit.graph import FALSE, TRUE, Graph
from exover.engines.aig.simulation.evaluation import LevelEvaluator, NativeEvaluator, evaluator
from exover.engines.aig.simulation.lanes import PackedState, at_lane, initial, packed
from exover.engines.aig.simulation.runs import random_words, simulate
from exover.engines.aig.simulation.shorten import shorten
from exover.engines.compiler import NativeUnavailable
from exover.model.lasso import moves
from tests.support.circuits import counter, random_circuit, reachable
from tests.support.confirming import confirms


@pytest.mark.parametrize("seed", range(40))
def test_every_run_replays_and_none_is_missed_by_many(seed: int) -> None:
    circuit = random_circuit(seed, latches=4)
    found = simulate(circuit, steps=40, lanes=512).answers()
    assert set(found) == reachable(circuit)
    assert all(confirms(circuit, circuit.bad[index], answer) for index, answer in found.items())


@pytest.mark.parametrize("seed", range(40))
def test_no_step_of_a_shortened_run_can_be_dropped_nor_take_the_place_of_another(seed: int) -> None:
    circuit = random_circuit(seed)
    found = simulate(circuit, steps=60, lanes=3).answers()
    shorter = shorten(circuit, {index: answer.inputs for index, answer in found.items()})
    assert shorter == shorten(circuit, {index: answer.inputs for index, answer in found.items()})
    for index, run in shorter.items():
        bad = circuit.bad[index]
        assert len(run) <= len(found[index].inputs)
        assert confirms(circuit, bad, Reachable(run))
        for at in range(len(run)):
            rest = run[:at] + run[at + 1 :]
            assert not any(confirms(circuit, bad, Reachable(rest[:end])) for end in range(len(rest) + 1))
        for _, _, moved in moves(run):
            assert not any(confirms(circuit, bad, Reachable(moved[:end])) for end in range(len(moved) + 1))


def test_a_run_that_reaches_nothing_is_not_shortened() -> None:
    with pytest.raises(ValueError, match="does not make its literal true"):
        shorten(counter(3, 7, 5), {0: (frozenset(),) * 9})


def test_the_earliest_step_and_the_lowest_lane_are_told() -> None:
    circuit = counter(3, 7, 2)
    go = circuit.inputs[0]
    runs = simulate(circuit, stimulus=lambda step, _: {go: 0b1100 if step < 2 else 0b1111}, lanes=4)
    assert runs.hits == {0: (2, 2)}
    assert runs.run(2, 2) == (frozenset({go}),) * 3


def test_a_stimulus_may_leave_inputs_out() -> None:
    assert simulate(counter(3, 7, 1), stimulus=lambda step, _: {}, lanes=8).hits == {}


def test_constants_are_questions_too() -> None:
    graph = Graph()
    graph.latch(True)
    circuit = graph.circuit([TRUE], [FALSE, TRUE])
    assert simulate(circuit, lanes=2, steps=1).hits == {1: (0, 0)}


def test_equal_seeds_give_equal_words() -> None:
    circuit = random_circuit(1)
    first, again, other = (random_words(circuit, 64, seed)(3, {}) for seed in (5, 5, 6))
    assert first == again != other


@pytest.mark.parametrize("lanes", [1, 63, 64, 65, 1000])
@pytest.mark.parametrize("seed", range(8))
def test_the_loop_in_c_computes_the_same(seed: int, lanes: int, monkeypatch: pytest.MonkeyPatch) -> None:
    circuit = random_circuit(seed, gates=60)
    roots = [*circuit.bad, *(bad ^ 1 for bad in circuit.bad), FALSE, TRUE]
    plain = evaluator(circuit, roots, circuit.latches)
    monkeypatch.setattr(compiled, "WORTH", 0)
    fast = evaluator(circuit, roots, circuit.latches)
    if compiled.kernel() is None:
        pytest.skip("no C compiler")
    assert isinstance(plain, LevelEvaluator) and isinstance(fast, NativeEvaluator)
    source, everywhere = Random(seed), (1 << lanes) - 1
    nodes = [*circuit.inputs, *(latch.node for latch in circuit.latches)]
    for given in (nodes, nodes[1:], []):  # what is not given is false
        leaves = {node: source.getrandbits(lanes) for node in given}
        one, other = plain.values(leaves), fast.values(leaves)
        for root in roots:
            assert plain.read(one, root, everywhere) == fast.read(other, root, everywhere)
        for some in (source.getrandbits(lanes), 1 << lanes - 1, 1 << lanes + 200):
            seen = [plain.read(one, root, some) for root in roots]
            assert seen == [fast.read(other, root, some) for root in roots]
            shown = [place for place, where in enumerate(seen) if where]
            assert shown == [*plain.somewhere(one, roots, some)] == [*fast.somewhere(other, roots, some)]
        ours, theirs = plain.signatures(one, roots), fast.signatures(other, roots)
        assert [ours.index(each) for each in ours] == [theirs.index(each) for each in theirs]
        assert plain.after(one, everywhere) == fast.after(other, everywhere)


@pytest.mark.parametrize("lanes", [1, 64, 200])
@pytest.mark.parametrize("seed", range(8))
def test_the_loop_in_c_comes_to_the_same_states(seed: int, lanes: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of many steps, which some lanes do not take; lanes that no input has named before come in late."""
    circuit = random_circuit(seed, gates=60)
    plain = evaluator(circuit, circuit.bad, circuit.latches)
    monkeypatch.setattr(compiled, "WORTH", 0)
    fast = evaluator(circuit, circuit.bad, circuit.latches)
    if compiled.kernel() is None:
        pytest.skip("no C compiler")
    source = Random(seed)
    states = [initial(circuit.latches, 0), initial(circuit.latches, 0)]
    packed = 0
    for step in range(20):
        named = min(lanes, 1 << step)
        inputs = {node: source.getrandbits(named) for node in circuit.inputs}
        going = source.getrandbits(lanes)
        states = [one.after(one.values(state, inputs), going) for one, state in zip((plain, fast), states, strict=True)]
        assert dict(states[0]) == dict(states[1])
        for lane in range(lanes):
            assert at_lane(states[0], lane) == at_lane(states[1], lane)
        packed += isinstance(states[1], PackedState)
    assert packed > 10


@pytest.mark.parametrize("lanes", [1, 7, 8, 9, 1000])
def test_a_lane_of_packed_words_is_that_of_the_words(lanes: int) -> None:
    source = Random(lanes)
    words = {node: source.getrandbits(lanes) for node in source.sample(range(100), 30)}
    side = packed(words, lanes)
    assert dict(side) == words
    assert [at_lane(side, lane) for lane in range(lanes)] == [at_lane(words, lane) for lane in range(lanes)]


def test_without_a_compiler_it_goes_on_in_python(monkeypatch: pytest.MonkeyPatch) -> None:
    def find() -> list[str]:
        raise NativeUnavailable("none")

    monkeypatch.setattr(compiled, "WORTH", 0)
    monkeypatch.setattr(compiled, "find_compiler", find)
    compiled.kernel.cache_clear()
    try:
        circuit = counter(3, 7, 5)
        assert isinstance(evaluator(circuit, circuit.bad), LevelEvaluator)
    finally:
        compiled.kernel.cache_clear()


def test_loops_are_compiled_beside_and_not_waited_for_if_work_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    going, done = Event(), list[str]()

    def slow() -> None:
        going.wait(60)
        done.append("compiled")

    monkeypatch.setattr(compiled, "kernel", slow)
    with pytest.raises(KeyboardInterrupt), compiled.compiled_beside():
        raise KeyboardInterrupt
    assert done == []
    before = threads()
    with compiled.compiled_beside():
        going.set()
    assert "compiled" in done
    assert threads() <= before
