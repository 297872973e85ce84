"""States in which ways begin are reachable, each is there once, and random runs come to further ones."""

from itertools import pairwise

import pytest

from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.simulation.evaluation import whole_evaluator
from exover.engines.aig.simulation.exploration import Seed
from exover.engines.aig.simulation.replay import replayed
from exover.engines.aig.ways.beginnings import LANES, STEPS, Beginnings
from exover.engines.aig.ways.home_states import HomeSpace
from exover.model.property import NO_PROPERTIES
from tests.engines.aig.runs import known_runs
from tests.support.engines import model_of
from tests.support.small import compiled, small_spec_of


def beginnings(seed: int, home: bool) -> Beginnings:
    return made_of(small_spec_of(seed), home)


def made_of(spec: str, home: bool) -> Beginnings:
    encoding = Encoding(compiled(model_of(spec)), NO_PROPERTIES)
    marker = encoding.graph.latch(True)
    encoding.following[marker] = marker
    circuit = encoding.circuit([])
    run: Inputs = HomeSpace(encoding).run if home else ()
    return Beginnings(encoding, circuit, whole_evaluator(circuit), frozenset({marker >> 1}), run)


def are_reached(made: Beginnings, seeds: list[Seed]) -> bool:
    """Return whether the run of each leads there, but for the latches that are true where a way begins."""
    circuit, graph = made.circuit, made.encoding.graph
    nodes = [latch.node for latch in circuit.latches if latch.node not in made.fresh]
    goals = []
    for seed in seeds:
        here = graph.all(2 * node + (node not in seed.true) for node in nodes)
        goals.append((here, (*seed.run, frozenset())))
    return all(replayed(made.encoding.circuit([]), goals))


@pytest.mark.parametrize("home", [True, False])
@pytest.mark.parametrize("seed", [4, 14, 23])
def test_they_are_reachable_and_there_once(seed: int, home: bool) -> None:
    made = beginnings(seed, home)
    passed = made.passed(known_runs(made.encoding), 200)
    known = made.of(passed)
    further = made.near(known)
    assert len({each.true for each in passed}) >= len(known) > 1
    for found in (known, further, made.reached([each.run for each in further])):
        assert len({each.true for each in found}) == len(found) <= max(LANES, 200)
        assert all(made.fresh <= each.true for each in found)
        assert are_reached(made, found)
    wrong = [Seed(known[0].true, further[-1].run), Seed(known[0].true, known[-1].run)]
    assert not are_reached(made, wrong)


def test_random_runs_are_others_every_time() -> None:
    made = beginnings(14, False)
    one, other = ({each.run for each in made.near([made.start])} for _ in range(2))
    assert one.isdisjoint(other)
    assert {len(run) for run in one | other} == {STEPS}
    again = beginnings(14, False)
    assert {each.run for each in again.near([again.start])} == one


TURNS = " ".join(
    f"request to_{there}() {{ check c: at == {here}; on ok set at = {there}; }}" for here, there in pairwise("abcdefgh")
)
LOCK = f"spec lock; module m {{ state at: {{a, b, c, d, e, f, g, h}} = a; {TURNS} }}"


def test_random_runs_come_to_all_modes() -> None:
    """Where each is led to by the one before it alone."""
    made = made_of(LOCK, False)
    bits = made.encoding.latches.literals["m.at"]
    found = made.of_new_modes([()], 100)
    assert are_reached(made, found)
    assert {sum((bit >> 1 in each.true) << place for place, bit in enumerate(bits)) for each in found} == set(range(8))
    assert len(made.of_new_modes([()], 3)) <= 3
    assert not made_of("spec modeless; module m { request a(); }", False).of_new_modes([()], 100)
