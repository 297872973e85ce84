"""Runs of a circuit, all at once: a bit of a number for each."""

from collections.abc import Sequence

from exover.engines.aig.answer import Inputs
from exover.engines.aig.graph import Circuit, Literal, ordered


def replayed(circuit: Circuit, goals: Sequence[tuple[Literal, Inputs]]) -> list[bool]:
    """Return of each literal and run whether the run makes it true in its last step."""
    every = (1 << len(goals)) - 1
    state = {latch.node: every if latch.initial else 0 for latch in circuit.latches}
    roots = [latch.next for latch in circuit.latches] + [literal for literal, _ in goals]
    ands = list(ordered(circuit, circuit.cone(roots)))
    values = [0] * len(circuit.fanins)
    found = [False] * len(goals)

    def value(literal: Literal) -> int:
        return values[literal >> 1] ^ (every if literal & 1 else 0)

    for step in range(max((len(run) for _, run in goals), default=0)):
        given = dict.fromkeys(circuit.inputs, 0)
        for place, (_, run) in enumerate(goals):
            for node in run[step] if step < len(run) else ():
                given[node] |= 1 << place
        for node, bits in (*state.items(), *given.items()):
            values[node] = bits
        for node, left, right in ands:
            values[node] = value(left) & value(right)
        for place, (literal, run) in enumerate(goals):
            if step == len(run) - 1:
                found[place] = bool(value(literal) >> place & 1)
        state = {latch.node: value(latch.next) for latch in circuit.latches}
    return found
