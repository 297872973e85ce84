"""Mutual induction: k-induction with k = 1 for many bad literals together (Sheeran, Singh, Stålmarck 2000).

A shortest run to one of several bad literals passes no state twice, and makes none of them true before its last step.
So none is ever true if no first step makes one true, and no step does that follows one which changes the state and
makes none true. Bounds on sums, of which no clause over a few bits is an invariant, are proved in this way.
"""

from collections import deque
from collections.abc import Iterable, Mapping
from contextlib import closing

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Clause
from exover.engines.aig.circuit.bounded import Unrolling
from exover.engines.aig.circuit.graph import FALSE, Circuit, Graph, Literal
from exover.engines.aig.circuit.solver import Exhausted, Solver

EFFORT, SOON = 200_000_000, 1_000_000
"""Propagations that the induction step may cost in all, and for a bad literal before the others were asked about."""


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
        pairs = {index: _Pair(-solver.literal(before[index]), after[index]) for index in left}
        try:
            return list(_kept(solver, pairs))
        except Exhausted:
            return []


@dataclass(frozen=True, slots=True)
class _Pair:
    """A bad literal in two steps: a literal of the solver that it is false in the first; the graph's in the second."""

    absent: int
    after: Literal


def _at_start(circuit: Circuit) -> list[bool]:
    """Return for each bad literal whether some first step makes it true."""
    unrolling = Unrolling(circuit)
    bad = unrolling.step()
    with closing(Solver(unrolling.graph.within_step())) as solver:
        return [literal != FALSE and solver.possible([literal]) for literal in bad]


def _kept(solver: Solver, pairs: Mapping[int, _Pair]) -> Iterable[int]:
    """Return the largest part of the bad literals of which no step makes one true that follows one which makes none.

    Each is asked about alone, those that are hard at last: together they are harder for a solver. The unsatisfiable
    core says which of the others have to be absent for that; if one of them is gone, it is asked about anew.
    """
    left, proved, waiting = dict(pairs), dict[int, set[int]](), deque((index, SOON) for index in pairs)
    while waiting:
        asked, granted = waiting.popleft()
        if asked not in left:
            continue
        try:
            broken = _broken(solver, left, asked, min(granted, EFFORT - solver.work))
        except Exhausted:
            if solver.work >= EFFORT:
                raise
            waiting.append((asked, EFFORT))
            continue
        if not broken:
            proved[asked] = solver.core()
        gone = {left.pop(index).absent for index in broken}
        anew = [index for index, core in proved.items() if not core.isdisjoint(gone)]
        for index in anew:
            del proved[index]
        waiting.extend((index, SOON) for index in anew)
    return left


def _broken(solver: Solver, left: Mapping[int, _Pair], asked: int, granted: int) -> set[int]:
    """Return literals that a step makes true, the one that is asked about among them, after one that makes none of
    those that are left true; none iff there is no such step. `Exhausted` after `granted` propagations.
    """
    absent = [pair.absent for pair in left.values()]
    if not solver.satisfiable([solver.literal(left[asked].after), *absent], granted):
        return set()
    seen = {index: pair.after for index, pair in left.items() if solver.knows(pair.after >> 1)}
    true = solver.true({literal >> 1 for literal in seen.values()})
    return {asked} | {index for index, literal in seen.items() if (literal >> 1 in true) != bool(literal & 1)}
