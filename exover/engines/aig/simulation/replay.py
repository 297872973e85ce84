"""Runs of a circuit from the start, replayed side by side, a lane for each."""

from collections.abc import Sequence

from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import Circuit, Literal
from exover.engines.aig.simulation.evaluation import evaluator
from exover.engines.aig.simulation.lanes import initial, side_by_side


def replayed(circuit: Circuit, goals: Sequence[tuple[Literal, Inputs]]) -> list[bool]:
    """Return for each literal with its run whether the run makes the literal true in its last step."""
    everywhere = (1 << len(goals)) - 1
    state = initial(circuit.latches, everywhere)
    cone = evaluator(circuit, [literal for literal, _ in goals], circuit.latches)
    found = [False] * len(goals)
    for step in range(max((len(run) for _, run in goals), default=0)):
        _, given = side_by_side([run for _, run in goals], step)
        values = cone.values(state, given)
        for place, (literal, run) in enumerate(goals):
            if step == len(run) - 1:
                found[place] = bool(cone.read(values, literal, everywhere) >> place & 1)
        state = cone.after(values, everywhere)
    return found
