"""Random events for runs that are simulated side by side: such as can happen, reports more often than aborts."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from random import Random

from exover.engines.aig.encoder import Encoding, Event
from exover.engines.aig.graph import Literal
from exover.engines.aig.simulation import LANES, Stimulus, Word

TRIES = 3
"""How often a lane whose event cannot happen draws another."""
FINE = 64
"""Into so many parts chances are divided."""
WEIGHTS = {"ask": 8, "report": 5, "abort": 1, "abort waiting": 1, "observe": 4, "observe level": 4}
"""How often events of a kind are drawn, in proportion."""


@dataclass(frozen=True)
class Drawing:
    """Draws events of an encoding for lanes; equal seeds draw equal events."""

    encoding: Encoding
    lanes: int = LANES
    seed: int = 0

    @cached_property
    def _weights(self) -> list[int]:
        return [max(1, WEIGHTS[e.kind.verb] // (1 + 2 * (e.kind.outcome != "ok"))) for e in self.encoding.events]

    def stimulus(self) -> Stimulus:
        """Return the words of the inputs by step and state."""

        def words(step: int, state: Mapping[int, Word]) -> dict[int, Word]:
            source = Random(f"{self.seed} {step}")
            found = {node: source.getrandbits(self.lanes) for node in self.encoding.graph.inputs}
            found |= dict.fromkeys(self.encoding.shifts, 0)
            left, everywhere = (1 << self.lanes) - 1, (1 << self.lanes) - 1
            code = dict.fromkeys(self.encoding.code, 0)
            for _ in range(TRIES):
                here = left
                for number, part in enumerate(self._dealt(source, left)):
                    able = self._able(self.encoding.events[number], state, everywhere)
                    here &= ~(part & able)
                    for k, bit in enumerate(self.encoding.code):
                        if number >> k & 1:
                            code[bit] |= part & able
                left = here
            return found | code

        return words

    def _dealt(self, source: Random, lanes: Word) -> list[Word]:
        """Return the lanes dealt out among the events, by their weights."""
        rest, total, found = lanes, sum(self._weights), []
        for weight in self._weights:
            mine = rest & self._chance(source, round(FINE * weight / total)) if weight < total else rest
            found.append(mine)
            rest &= ~mine
            total -= weight
        return found

    def _chance(self, source: Random, parts: int) -> Word:
        """Return lanes, each with a chance of so many parts of `FINE`."""
        word = 0
        for k in range(FINE.bit_length() - 1):
            bits = source.getrandbits(self.lanes)
            word = word | bits if parts >> k & 1 else word & bits
        return word if parts < FINE else (1 << self.lanes) - 1

    def _able(self, event: Event, state: Mapping[int, Word], everywhere: Word) -> Word:
        """Return where the event can happen: where there is a slot to report or abort, or a request to give up."""
        layout, kind = self.encoding.latches, event.kind
        if kind.verb in ("report", "abort"):
            flag = layout.slots[kind.name, kind.slot].active
        elif kind.verb == "abort waiting":
            flag = layout.places[kind.name].taken
        else:
            return everywhere
        literal: Literal = layout.literals[flag][0]
        return state.get(literal >> 1, 0)
