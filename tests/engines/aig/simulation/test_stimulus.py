"""Random events: each comes as often as its kind is to, none where it cannot, and lanes do not all have the same."""

from collections import Counter
from functools import cached_property
from itertools import pairwise

import pytest

from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import Graph, Literal
from exover.engines.aig.simulation.stimulus import TRIES, WEIGHTS, RandomStimulus
from exover.loop.exact.events import Kind

EVENTS = ("ask", "report", "abort", "observe", "observe level")
GUARDED = {1: 2, 2: 2, 3: 4}
"""By number of an event, a literal: 1 and 2 are enabled by node 1, 3 by node 2."""
STEPS = 200


@dataclass(frozen=True, slots=True)
class Drawn:
    """An event of some kind."""

    kind: Kind


@dataclass(frozen=True)
class Machine:
    """Five events, two latches that enable some of them, and an input beside the number of the event."""

    @cached_property
    def graph(self) -> Graph:
        """Return a graph of the latches and inputs alone."""
        graph = Graph()
        for _ in range(2):
            graph.latch(False)
        for _ in range(5):
            graph.input()
        return graph

    events = tuple(Drawn(Kind(verb, "")) for verb in EVENTS)

    @property
    def code(self) -> tuple[int, ...]:
        """Return the nodes of the number of the event."""
        return tuple(self.graph.inputs[:3])

    @property
    def shifts(self) -> tuple[int, ...]:
        """Return the nodes of what moves reals."""
        return (self.graph.inputs[3],)

    def enabling(self, number: int) -> Literal | None:
        """Return the latch that enables an event."""
        return GUARDED.get(number)


def drawn(lanes: int, first: int, second: int, seed: int = 0) -> list[list[int]]:
    """Return by step the events that lanes have where the latches are true in these lanes."""
    machine = Machine()
    words = RandomStimulus(machine, lanes, seed).stimulus()
    steps = [words(step, {1: first, 2: second}) for step in range(STEPS)]
    assert all(step[node] == 0 for step in steps for node in machine.shifts)
    return [
        [sum((step[node] >> lane & 1) << bit for bit, node in enumerate(machine.code)) for lane in range(lanes)]
        for step in steps
    ]


@pytest.mark.parametrize("lanes", [3, 64, 500])
def test_events_come_as_often_as_they_weigh(lanes: int) -> None:
    everywhere = (1 << lanes) - 1
    counts = Counter(number for step in drawn(lanes, everywhere, everywhere) for number in step)
    total = sum(WEIGHTS[verb] for verb in EVENTS)
    for number, verb in enumerate(EVENTS):
        assert counts[number] == pytest.approx(STEPS * lanes * WEIGHTS[verb] / total, rel=0.35)


def test_no_event_comes_where_it_is_not_enabled() -> None:
    lanes, first, second = 64, 0x00FF_00FF_00FF_00FF, 0x0F0F_0F0F_0F0F_0F0F
    seen = Counter[tuple[int, int, int]]()
    for step in drawn(lanes, first, second):
        seen.update((number, first >> lane & 1, second >> lane & 1) for lane, number in enumerate(step))
    assert not any(seen[number, 0, other] for number in (1, 2) for other in (0, 1))
    assert not any(seen[3, other, 0] for other in (0, 1))
    assert all(seen[number, 1, 1] for number in range(len(EVENTS)))


def test_a_lane_whose_event_is_not_enabled_draws_others() -> None:
    """Where only the first and the last event can come, few lanes are left with none, which is taken for the first."""
    numbers = Counter(number for step in drawn(64, 0, 0) for number in step)
    able = (WEIGHTS["ask"] + WEIGHTS["observe level"]) / sum(map(WEIGHTS.__getitem__, EVENTS))
    last = WEIGHTS["observe level"] / (WEIGHTS["ask"] + WEIGHTS["observe level"]) * (1 - (1 - able) ** TRIES)
    assert set(numbers) == {0, 4}
    assert numbers[4] == pytest.approx(64 * STEPS * last, rel=0.1)


def test_equal_seeds_draw_equal_events_and_lanes_have_events_of_their_own() -> None:
    one, again, other = (drawn(64, 2**64 - 1, 2**64 - 1, seed) for seed in (1, 1, 2))
    assert one == again != other
    assert len(set(zip(*one, strict=True))) == 64
    assert all(sum(a != b for a, b in pairwise(step)) > 16 for step in one), "what stands side by side is the same"
