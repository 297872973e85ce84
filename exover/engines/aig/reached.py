"""States that some run reaches, side by side, so that a set of states is asked for one of them at once."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from exover.engines.aig.answer import Inputs
from exover.engines.aig.graph import Circuit, Literal
from exover.engines.aig.simulation import Runs, Word

Cube = tuple[Literal, ...]
"""A conjunction of literals of latches, in ascending order: the set of states in which all are true."""


@dataclass(frozen=True, slots=True)
class Reached:
    """The states of simulated runs, the start among them. `words`: by literal of a latch the states where it is true.

    State number `step * lanes + lane` is that of a lane before its step.
    """

    runs: Runs
    everywhere: Word
    words: Mapping[Literal, Word]

    def where(self, cube: Iterable[Literal]) -> Word:
        """Return which of the states lie in a cube."""
        left = self.everywhere
        for literal in cube:
            left &= self.words[literal]
            if not left:
                break
        return left

    def path(self, states: Word) -> Inputs:
        """Return a shortest of the runs that lead to one of these states, which are not none."""
        first = (states & -states).bit_length() - 1
        step, lane = divmod(first, self.runs.lanes)
        return self.runs.run(step - 1, lane) if step else ()


def reached(circuit: Circuit, runs: Runs) -> Reached:
    """Return the states of runs of this circuit, of the latches that were simulated."""
    everywhere = (1 << runs.lanes * len(runs.states)) - 1
    words: dict[Literal, Word] = {}
    for latch in circuit.latches:
        if latch.node in runs.states[0]:
            word = 0
            for state in reversed(runs.states):
                word = word << runs.lanes | state[latch.node]
            words[2 * latch.node], words[2 * latch.node + 1] = word, everywhere ^ word
    return Reached(runs, everywhere, words)
