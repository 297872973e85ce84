"""Known runs of a circuit, followed side by side, a lane for each."""

from collections.abc import Iterator, Sequence

from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import Circuit, Literal
from exover.engines.aig.simulation.evaluation import ConeValues, Evaluator, evaluator
from exover.engines.aig.simulation.lanes import LaneState, LaneWord, initial, side_by_side


def replay(
    cone: Evaluator, state: LaneState, runs: Sequence[Inputs]
) -> Iterator[tuple[LaneWord, ConeValues, LaneState]]:
    """Yield by step which of the runs have it, the values of the cone in it, and the states after it.

    `state`: that in which they begin. Where a run has ended it stays.
    """
    for number in range(max(map(len, runs), default=0)):
        going, inputs = side_by_side(runs, number)
        values = cone.values(state, inputs)
        state = cone.after(values, going)
        yield going, values, state


def replayed(circuit: Circuit, goals: Sequence[tuple[Literal, Inputs]]) -> list[bool]:
    """Return for each literal with its run from the start whether the run makes it true in its last step."""
    everywhere = (1 << len(goals)) - 1
    cone = evaluator(circuit, [literal for literal, _ in goals], circuit.latches)
    found = [False] * len(goals)
    steps = replay(cone, initial(circuit.latches, everywhere), [run for _, run in goals])
    for number, (_, values, _) in enumerate(steps, 1):
        for place, (literal, run) in enumerate(goals):
            if number == len(run):
                found[place] = bool(cone.read(values, literal, everywhere) >> place & 1)
    return found
