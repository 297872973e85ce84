"""Mutual induction: k-induction with k = 1 for many bad literals together (Sheeran, Singh, Stålmarck 2000).

A shortest run to one of several bad literals passes no state twice, and makes none of them true before its last step.
So none is ever true if no first step makes one true, and no step does that follows one which changes the state and
makes none true. Bounds on sums, of which no clause over a few bits is an invariant, are proved in this way.
"""

from collections.abc import Iterable, Sequence
from contextlib import closing

from exover.engines.aig.circuit.answer import Clause
from exover.engines.aig.circuit.bounded import Unrolling
from exover.engines.aig.circuit.graph import FALSE, Circuit, Graph, Literal
from exover.engines.aig.circuit.solver import Exhausted, Solver

EFFORT = 200_000_000
"""Propagations that the induction step may cost."""


def mutually_inductive(circuit: Circuit, known: Iterable[Clause] = ()) -> list[int]:
    """Return the indices of bad literals that mutual induction proves to be true in no run; the others stay open.

    `known`: clauses that are an invariant.
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
    """Return for each bad literal whether some first step makes it true."""
    unrolling = Unrolling(circuit)
    bad = unrolling.step()
    with closing(Solver(unrolling.graph.within_step())) as solver:
        return [literal != FALSE and solver.possible([literal]) for literal in bad]


def _broken(solver: Solver, before: Sequence[Literal], after: Sequence[Literal]) -> set[int]:
    """Return the places of literals that one counterexample to the induction makes true; none iff there is none."""
    assumed = solver.fresh()
    for literal in before:
        solver.add([-assumed, -solver.literal(literal)])
    solver.add([-assumed, *map(solver.literal, after)])
    if not solver.satisfiable([assumed], EFFORT - solver.work):
        return set()
    true = solver.true({literal >> 1 for literal in after})
    solver.add([-assumed])
    return {place for place, literal in enumerate(after) if (literal >> 1 in true) != bool(literal & 1)}
