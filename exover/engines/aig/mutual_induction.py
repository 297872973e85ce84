"""Questions whose answers keep each other: induction over runs without a loop (Sheeran, Singh, Stålmarck 2000).

A shortest run to one of several bad literals passes no state twice, and makes none of them true before its last step.
Where no step from such a step leads to such a step, there is no run but one of a single step. Sums of what is used, of
which no clause over a few bits is an invariant, are proved so.
"""

from collections.abc import Iterable, Sequence
from contextlib import closing

from exover.engines.aig.answer import Clause
from exover.engines.aig.bounded import Unrolling
from exover.engines.aig.graph import FALSE, Circuit, Graph, Literal
from exover.engines.aig.solver import Exhausted, Solver

EFFORT = 200_000_000
"""Propagations that the step of the induction may cost."""


def mutually_inductive(circuit: Circuit, known: Iterable[Clause] = ()) -> list[int]:
    """Return, by index, bad literals that no run makes true, as two steps of the circuit show.

    `known`: clauses that are an invariant. The rest are left open.
    """
    left = [index for index, found in enumerate(_at_start(circuit)) if not found]
    graph = Graph()
    state = {latch.node: graph.input() for latch in circuit.support(circuit.bad)}
    unrolling = Unrolling(circuit, graph, begun=state)
    before = unrolling.step()
    moves = graph.any(graph.differ(state[node], after) for node, after in unrolling.state.items())
    after = unrolling.step()
    with closing(Solver(graph.within_step())) as solver:
        solver.add([solver.literal(moves)])
        for clause in known:
            solver.add([solver.literal(state[each >> 1] ^ (each & 1)) for each in clause])
        try:
            while left and (broken := _broken(solver, [before[n] for n in left], [after[n] for n in left])):
                left = [index for place, index in enumerate(left) if place not in broken]
        except Exhausted:
            return []
    return left


def _at_start(circuit: Circuit) -> list[bool]:
    """Return of each bad literal whether a first step makes it true."""
    unrolling = Unrolling(circuit)
    bad = unrolling.step()
    with closing(Solver(unrolling.graph.within_step())) as solver:
        return [literal != FALSE and solver.satisfiable([solver.literal(literal)]) for literal in bad]


def _broken(solver: Solver, before: Sequence[Literal], after: Sequence[Literal]) -> set[int]:
    """Return, by place, what is true after a step in which none is: some of it, and nothing iff there is none."""
    assumed = solver.fresh()
    for literal in before:
        solver.add([-assumed, -solver.literal(literal)])
    solver.add([-assumed, *map(solver.literal, after)])
    if not solver.satisfiable([assumed], EFFORT - solver.work):
        return set()
    true = solver.true({literal >> 1 for literal in after})
    solver.add([-assumed])
    return {place for place, literal in enumerate(after) if (literal >> 1 in true) != bool(literal & 1)}
