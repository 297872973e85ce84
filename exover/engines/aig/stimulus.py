"""Random events for runs that are simulated side by side: such as can happen, reports more often than aborts."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from itertools import accumulate, pairwise
from random import Random
from typing import Protocol, TypeVar

from exover.dataclass import dataclass
from exover.engines.aig.graph import Graph, Literal
from exover.engines.aig.lanes import LaneWord
from exover.engines.aig.simulation import LANES, Stimulus
from exover.loop.exact.events import Kind

TRIES = 2
"""How often a lane whose event cannot happen draws another."""
FINE = 2
"""So many parts as there are events, or more, chances are divided into."""
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


@dataclass(frozen=True)
class RandomStimulus:
    """Draws events of a transition system for lanes; equal seeds draw equal events."""

    encoding: Stimulated[Eventful]
    lanes: int = LANES
    seed: int = 0

    @cached_property
    def _parts(self) -> list[int]:
        """The numbers of the events, each as often as it is drawn, a power of two of them."""
        weights = [max(1, WEIGHTS[e.kind.verb] // (1 + 2 * (e.kind.outcome != "ok"))) for e in self.encoding.events]
        total, count = sum(weights), 1 << (FINE * len(weights) - 1).bit_length()
        ends = [end * count // total for end in accumulate(weights)]
        return [number for number, (low, high) in enumerate(pairwise([0, *ends])) for _ in range(low, high)]

    @cached_property
    def _codes(self) -> list[list[int]]:
        """By event the nodes of its number that are true."""
        nodes = self.encoding.code
        return [[node for k, node in enumerate(nodes) if n >> k & 1] for n in range(len(self.encoding.events))]

    @cached_property
    def _latches(self) -> list[int | None]:
        """By event the node of the latch that is true where it can happen: where there is a slot to report or abort, or
        a request to give up. None if it always can."""
        literals = map(self.encoding.enabling, range(len(self.encoding.events)))
        return [None if literal is None else literal >> 1 for literal in literals]

    def stimulus(self) -> Stimulus:
        """Return the words of the inputs by step and state."""

        def words(step: int, state: Mapping[int, LaneWord]) -> dict[int, LaneWord]:
            source = Random(f"{self.seed} {step}")
            found = {node: source.getrandbits(self.lanes) for node in self.encoding.graph.inputs}
            found |= dict.fromkeys(self.encoding.shifts, 0)
            left = (1 << self.lanes) - 1
            code = dict.fromkeys(self.encoding.code, 0)
            for _ in range(TRIES):
                here = left
                for number, part in enumerate(self._dealt(source, left)):
                    latch = self._latches[number]
                    able = part if latch is None else part and part & state.get(latch, 0)
                    if able:
                        here ^= able
                        for bit in self._codes[number]:
                            code[bit] |= able
                left = here
            return found | code

        return words

    def _dealt(self, source: Random, lanes: LaneWord) -> list[LaneWord]:
        """Return the lanes dealt out among the events, by their weights."""
        found = [lanes]
        while len(found) < len(self._parts):
            chance = source.getrandbits(self.lanes)
            found = [half for word in found for half in (word & chance, word & ~chance)]
        dealt = [0] * len(self.encoding.events)
        for number, word in zip(self._parts, found, strict=True):
            dealt[number] |= word
        return dealt
