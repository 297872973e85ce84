"""Pairs are covered alike by the loop in C and by that in Python, and each valuation of a mode once."""

from array import array
from itertools import chain, combinations
from random import Random

import pytest

from exover.engines.aig.circuit.kernel import kernel
from exover.engines.aig.encoding.coverage_goals import coverage_goals
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.simulation import coverage
from exover.engines.aig.simulation.coverage import ModeCoverage, PairCoverage, value_pairs
from exover.model.property import NO_PROPERTIES
from tests.support.engines import model_of
from tests.support.small import compiled


def covering(pairs: list[tuple[int, int]]) -> PairCoverage:
    """Return the coverage of these pairs."""
    return PairCoverage(array("I", chain.from_iterable(pairs)))


def rounds(seed: int, lanes: int, most: int) -> list[tuple[list[int], int]]:
    """Return which lanes are kept in each of some rounds, and how many pairs are left."""
    source = Random(seed)
    pairs = covering(source.sample(list(combinations(range(12), 2)), 60))
    found = []
    for _ in range(6):
        signals = [source.getrandbits(lanes) & source.getrandbits(lanes) & source.getrandbits(lanes) for _ in range(12)]
        found.append((pairs.cover(signals, lanes, most), len(pairs)))
    return found


@pytest.mark.parametrize("lanes", [1, 63, 64, 65, 300])
@pytest.mark.parametrize("most", [1, 4, 64])
def test_the_loop_in_c_is_that_in_python(lanes: int, most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    if kernel() is None:
        pytest.skip("there is no C compiler")
    ours = [rounds(seed, lanes, most) for seed in range(20)]
    monkeypatch.setattr(coverage, "kernel", lambda: None)
    assert [rounds(seed, lanes, most) for seed in range(20)] == ours


@pytest.mark.parametrize("native", [True, False])
def test_each_lane_has_a_pair_that_none_before_it_has(native: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if not native:
        monkeypatch.setattr(coverage, "kernel", lambda: None)
    pairs = covering([(0, 1), (0, 2), (1, 2), (0, 3)])
    assert pairs.cover([0b1110, 0b0110, 0b0100, 0b1000], 4, 2) == [1, 2]
    assert len(pairs) == 1  # (0, 3) has no place
    assert pairs.cover([0b1110, 0b0110, 0b0100, 0b1000], 4, 2) == [3]
    assert (len(pairs), pairs.cover([1, 1, 1, 1], 4, 2)) == (0, [])


@pytest.mark.parametrize("signals", range(8))
def test_all_pairs_of_values_are_there_but_those_of_one_signal(signals: int) -> None:
    found = list(value_pairs(signals))
    pairs = list(zip(found[::2], found[1::2], strict=True))
    assert sorted(pairs) == [(a, b) for a, b in combinations(range(2 * signals), 2) if a >> 1 != b >> 1]
    assert [b - a for a, b in pairs] == sorted(b - a for a, b in pairs)


def test_each_lane_has_a_mode_that_none_before_it_has() -> None:
    modes = ModeCoverage()
    assert modes.cover([0b0101, 0b0011], 4, 3) == [0, 1, 2]
    assert len(modes) == 3  # that of lane 3 has no place
    assert modes.cover([0b0101, 0b0011], 4, 3) == [3]
    assert (len(modes), modes.cover([0b0110, 0b1001], 4, 3)) == (4, [])


def test_a_mode_is_of_states_and_latches() -> None:
    spec = """spec s; poster p: int in 0 .. 100 = 0 else 0; latch l: when p > 5 until m.b;
    module m { state s: int in 0 .. 100 = 0; state t: bool = false; request a(n: int in 0 .. 3); request b(); }"""
    encoding = Encoding(compiled(model_of(spec)), NO_PROPERTIES)
    literals = encoding.latches.literals
    goals = coverage_goals(encoding.latches)
    assert goals.mode == tuple(bit >> 1 for bit in (*literals["m.s"][:4], *literals["m.t"], *literals["l"]))
    assert not {bit >> 1 for bit in literals["m.a[0].n"]} & set(goals.pairs)
    assert {*goals.mode, *(bit >> 1 for bit in literals["p"][:4])} < set(goals.pairs)
