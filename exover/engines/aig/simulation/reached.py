"""States that simulated runs reached, a bit each of machine words, so that all are compared with a cube at once."""

from collections.abc import Iterable
from dataclasses import field

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import LatchNode, Literal
from exover.engines.aig.simulation.lanes import LaneWord, lowest
from exover.engines.aig.simulation.runs import Runs

Cube = tuple[Literal, ...]
"""A conjunction of literals of latches, in ascending order: the set of states in which all are true."""


@dataclass
class Reached:
    """The states of simulated runs of a circuit, the start among them.

    `words`: by literal of a latch the states where it is true, a bit each. `runs`: runs with the place of their first
    state; their states stand from there on, step by step, in each step lane by lane.
    """

    words: dict[Literal, LaneWord]
    size: int = 0
    runs: list[tuple[int, Runs]] = field(default_factory=list)

    def add(self, runs: Runs) -> None:
        """Add the states of runs of the same circuit."""
        lanes = runs.lanes
        size = lanes * len(runs.states)
        for literal in self.words:
            if not literal & 1:
                word = 0
                for state in reversed(runs.states):
                    word = word << lanes | state[literal >> 1]
                self.words[literal] |= word << self.size
                self.words[literal + 1] |= (word ^ ((1 << size) - 1)) << self.size
        self.runs.append((self.size, runs))
        self.size += size

    def where(self, cube: Iterable[Literal]) -> LaneWord:
        """Return which of the states lie in a cube."""
        left: LaneWord | None = None
        for literal in cube:
            left = self.words[literal] if left is None else left & self.words[literal]
            if not left:
                return 0
        return (1 << self.size) - 1 if left is None else left

    def path(self, states: LaneWord) -> Inputs:
        """Return a run to one of these states; there must be at least one."""
        first = lowest(states)
        place, runs = next((place, runs) for place, runs in reversed(self.runs) if place <= first)
        step, lane = divmod(first - place, runs.lanes)
        return runs.run(step - 1, lane) if step else ()


def reached(latches: Iterable[LatchNode], runs: Runs) -> Reached:
    """Return the states of runs as values of these latches, all of which must have been simulated."""
    found = Reached({2 * latch.node + sign: 0 for latch in latches for sign in (0, 1)})
    found.add(runs)
    return found
