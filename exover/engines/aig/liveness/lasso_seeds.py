"""Seeds of random lassos: states in which a run stays, on known runs or on random events after their ends."""

from collections.abc import Sequence
from random import Random

from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.encoding.random_events import RandomEvents
from exover.engines.aig.liveness.random_lassos import LaneWords, SimulatedCircuit
from exover.engines.aig.simulation.exploration import Seed
from exover.engines.aig.simulation.lanes import PackedState, at_lane, initial, numbers, packed, side_by_side

ONWARD = 32
"""How many random steps follow the longest of the runs."""
SEEDS = 8
"""How many states are kept for a question."""
LATER = 0.05
"""The probability that a later state replaces a kept one; the first half of the seeds is never replaced."""


class LassoSeeds:
    """Simulates known runs side by side, and keeps states in which they stay; guesses of monitors are random inputs."""

    def __init__(self, machine: SimulatedCircuit, runs: Sequence[Inputs], seed: int) -> None:
        self.machine, self.runs = machine, [*runs, ()]
        self.everywhere = (1 << len(self.runs)) - 1
        self.source = Random(seed)
        self.chance = RandomEvents(machine.encoding, self.source)
        self.state = initial(machine.latches, self.everywhere)
        self.taken: list[PackedState] = []
        self.found: dict[int, list[Seed]] = {}

    def seeds(self) -> dict[int, list[Seed]]:
        """Return, by index of a question, states in which its `begun` is true, each with the run to it."""
        for number in range(max(map(len, self.runs)) + ONWARD):
            self._step(number)
        return self.found

    def _step(self, number: int) -> None:
        machine, everywhere = self.machine, self.everywhere
        inputs = self._inputs(number)
        self.taken.append(packed(inputs, len(self.runs)))
        values = machine.cone.values(self.state, inputs)
        self.state = machine.cone.after(values, everywhere)
        for index, each in enumerate(machine.staying):
            here = self.state.get(each.begun >> 1, 0)
            found = self.found.setdefault(index, []) if here else []
            if here and (len(found) < SEEDS or self.source.random() < LATER):
                lane = self.source.choice(list(numbers(here)))
                if len(found) == SEEDS:
                    del found[self.source.randint(SEEDS // 2, SEEDS - 1)]
                found.append(Seed(at_lane(self.state, lane), self._path(lane)))

    def _inputs(self, number: int) -> LaneWords:
        """Return the inputs of a step: those of the runs, and random ones after their ends."""
        words = self.chance.inputs([self.chance.move() for _ in self.runs])
        there, known = side_by_side(self.runs, number)
        for node in self.machine.encoding.given:
            words[node] = words.get(node, 0) & ~there | known.get(node, 0)
        return words

    def _path(self, lane: int) -> Inputs:
        """Return the run of a lane so far."""
        return tuple(at_lane(words, lane) for words in self.taken)
