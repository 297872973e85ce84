"""Random events for runs that are simulated side by side: such as can happen, reports more often than aborts."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from itertools import accumulate, pairwise
from random import Random
from typing import Protocol, TypeVar

from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import Graph, Literal
from exover.engines.aig.simulation.lanes import LaneWord
from exover.engines.aig.simulation.runs import LANES, Stimulus
from exover.loop.exact.events import Kind

TRIES = 2
"""How many times a lane draws an event, until it has one that can happen."""
WEIGHTS = {"ask": 8, "report": 5, "abort": 1, "abort waiting": 1, "observe": 4, "observe level": 4}
"""How often events of a kind are drawn, in proportion."""


E = TypeVar("E", bound="Eventful", covariant=True)


class Eventful(Protocol):
    """An event that may come."""

    @property
    def kind(self) -> Kind:
        """Its kind."""
        ...


class Stimulated(Protocol[E]):
    """A transition system, one event in each step.

    `code`: the nodes of the inputs that are the number of the event; `shifts`: those that give reals other positions.
    """

    @property
    def graph(self) -> Graph:
        """The graph with its inputs."""
        ...

    @property
    def events(self) -> Sequence[E]:
        """The events by number."""
        ...

    @property
    def code(self) -> tuple[int, ...]:
        """The nodes of the inputs that are the number of the event, the least significant first."""
        ...

    @property
    def shifts(self) -> tuple[int, ...]:
        """The nodes of the inputs that give reals other positions; where all are false they keep theirs."""
        ...

    def enabling(self, number: int) -> Literal | None:
        """Return the latch that is true where the event of a number can come, None if it always can."""
        ...


@dataclass(frozen=True, slots=True)
class _Wheel:
    """A circle of events in random order; its words hold a whole turn, and as many places more as there are lanes.

    `code`: by bit of the number of an event the places where it is true; `enabled`: by latch the places of the events
    that it enables, by None of those that can always come.
    """

    places: int
    code: tuple[LaneWord, ...]
    enabled: Mapping[int | None, LaneWord]


@dataclass(frozen=True)
class RandomStimulus:
    """Draws events of a transition system for lanes; equal seeds draw equal events.

    The events stand around a wheel, each as often as its weight. For each step it is turned by a random number of
    places, and a lane has the event before which it comes to stand: for one lane these are independent draws.
    """

    system: Stimulated[Eventful]
    lanes: int = LANES
    seed: int = 0

    @cached_property
    def _wheel(self) -> _Wheel:
        weights = [max(1, WEIGHTS[e.kind.verb] // (1 + 2 * (e.kind.outcome != "ok"))) for e in self.system.events]
        places = max(sum(weights), self.lanes)
        ends = [end * places // sum(weights) for end in accumulate(weights)]
        order = [number for number, (low, high) in enumerate(pairwise([0, *ends])) for _ in range(low, high)]
        Random(self.seed).shuffle(order)
        code = [0] * len(self.system.code)
        enabled: dict[int | None, LaneWord] = {}
        for number, word in _words([*order, *order[: self.lanes]]).items():
            code = [bits | word * (number >> bit & 1) for bit, bits in enumerate(code)]
            literal = self.system.enabling(number)
            latch = None if literal is None else literal >> 1
            enabled[latch] = enabled.get(latch, 0) | word
        return _Wheel(places, tuple(code), enabled)

    def stimulus(self) -> Stimulus:
        """Return the words of the inputs by step and state."""

        def words(step: int, state: Mapping[int, LaneWord]) -> dict[int, LaneWord]:
            source = Random(f"{self.seed} {step}")
            found = {node: source.getrandbits(self.lanes) for node in self.system.graph.inputs}
            found |= dict.fromkeys(self.system.shifts, 0)
            left = (1 << self.lanes) - 1
            code = [0] * len(self._wheel.code)
            for _ in range(TRIES):
                turn = source.randrange(self._wheel.places)
                able = 0
                for latch, word in self._wheel.enabled.items():
                    able |= word >> turn & (left if latch is None else state.get(latch, 0))
                able &= left
                code = [bits | word >> turn & able for bits, word in zip(code, self._wheel.code, strict=True)]
                left ^= able
            return found | dict(zip(self.system.code, code, strict=True))

        return words


def _words(order: Sequence[int]) -> dict[int, LaneWord]:
    """Return by number the places at which it stands in a sequence."""
    found: dict[int, LaneWord] = {}
    for place, number in enumerate(order):
        found[number] = found.get(number, 0) | 1 << place
    return found
