"""Random events as inputs of a circuit, drawn independently for each lane of a simulation."""

from collections.abc import Sequence
from functools import cached_property
from random import Random

from exover.dataclass import dataclass
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.simulation.lanes import LaneWord


@dataclass(frozen=True)
class RandomEvents:
    """Draws events of an encoding from a source of random numbers; equal sources draw equal events."""

    encoding: Encoding
    source: Random

    @cached_property
    def _numbers(self) -> dict[str, list[int]]:
        """By verb the numbers of the kinds of events."""
        found: dict[str, list[int]] = {}
        for number, event in enumerate(self.encoding.events):
            found.setdefault(event.kind.verb, []).append(number)
        return found

    @cached_property
    def _given(self) -> tuple[int, ...]:
        """The nodes of all inputs but the number of the event and the shifts of reals."""
        others = {*self.encoding.code, *self.encoding.shifts}
        return tuple(node for node in self.encoding.graph.inputs if node not in others)

    def move(self) -> int:
        """Return the number of a random kind of event: of an ask half of the time, else of a verb drawn evenly."""
        verbs = self._numbers
        kinds = verbs.get("ask") if self.source.random() < 0.5 else None
        return self.source.choice(kinds or verbs[self.source.choice(list(verbs))])

    def word(self, moves: int) -> list[int]:
        """Return a random word, as numbers of kinds: `moves` events of few kinds, and a report of every slot."""
        source = self.source
        choices = [self.move() for _ in range(source.randint(1, moves))]
        found = [source.choice(choices) for _ in range(moves)]
        for reports in self.encoding.reports.values():
            found.insert(source.randint(0, len(found)), source.choice(reports))
        return found

    def inputs(self, kinds: Sequence[int]) -> dict[int, LaneWord]:
        """Return the inputs of a step with random values; `kinds`: by lane the number of its kind of event."""
        lanes = len(kinds)
        words = {node: self.source.getrandbits(lanes) for node in self._given}
        digits = [f"{kind:0{len(self.encoding.code)}b}" for kind in reversed(kinds)]
        for node, column in zip(reversed(self.encoding.code), zip(*digits, strict=True), strict=True):
            words[node] = int("".join(column), 2)
        return words
