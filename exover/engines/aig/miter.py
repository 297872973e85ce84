"""A smaller circuit in place of another, as far as a SAT solver shows that they are equal.

Outputs are compared in turn, those of small numbers first; what is found equal helps with what is made of it (Brand
1993; Kuehlmann, Krohm 1997).
"""

from exover.engines.aig.graph import FALSE, Circuit, Graph, Literal, ordered
from exover.engines.aig.solver import Exhausted, Solver

GRANTED = 400_000_000
"""Propagations that all comparisons may cost."""
EACH = 20_000_000
"""Propagations that a comparison may cost."""


def confirmed(circuit: Circuit, other: Circuit) -> Circuit:
    """Return a circuit that equals the given one: of `other` what is shown to be equal, else what stands in `circuit`.

    Both have the same nodes for inputs and latches, and as many bad literals. What latches become in a step and bad
    literals are compared, for all states and inputs. Nodes of inputs and latches are kept. If what is kept of both is
    more than the given circuit, that is returned.
    """
    assert (circuit.inputs, len(circuit.bad)) == (other.inputs, len(other.bad))
    assert [latch.node for latch in circuit.latches] == [latch.node for latch in other.latches]
    graph = _leaves(circuit)
    theirs, mine = _copied(other, graph), _copied(circuit, graph)
    kept = list(mine)
    solver = Solver(graph.circuit([FALSE] * len(graph.latches), ()))
    for place in sorted(range(len(mine)), key=lambda place: max(mine[place], theirs[place])):
        if _same(solver, mine[place], theirs[place]):
            kept[place] = theirs[place]
    solver.close()
    count = len(circuit.latches)
    both = graph.circuit(kept[:count], kept[count:])
    alone = _leaves(circuit)
    kept = _copied(both, alone)
    found = alone.circuit(kept[:count], kept[count:])
    return found if _size(found) < _size(circuit) else circuit


def _size(circuit: Circuit) -> int:
    return len(circuit.cone([*(latch.next for latch in circuit.latches), *circuit.bad]))


def _leaves(circuit: Circuit) -> Graph:
    """Return a graph of nothing but the inputs and latches of a circuit."""
    latches = [(latch.node, latch.initial) for latch in circuit.latches]
    last = max((*circuit.inputs, *(node for node, _ in latches)), default=0)
    return Graph([None] * (last + 1), list(circuit.inputs), latches)


def _copied(circuit: Circuit, graph: Graph) -> list[Literal]:
    """Return what latches become and the bad literals, made anew in a graph with the same leaves."""
    roots = [*(latch.next for latch in circuit.latches), *circuit.bad]
    nodes = circuit.cone(roots)
    values = {node: 2 * node for node in nodes if circuit.fanins[node] is None}
    for node, left, right in ordered(circuit, nodes):
        values[node] = graph.conjunction(values[left >> 1] ^ (left & 1), values[right >> 1] ^ (right & 1))
    return [values[root >> 1] ^ (root & 1) for root in roots]


def _same(solver: Solver, one: Literal, other: Literal) -> bool:
    """Return True iff it is shown that two literals are equal, which the solver knows from then on."""
    if one == other:
        return True
    a, b = solver.literal(one), solver.literal(other)
    for assumptions in ([a, -b], [-a, b]):
        granted = min(EACH, GRANTED - solver.work)
        try:
            if granted <= 0 or solver.satisfiable(assumptions, granted):
                return False
        except Exhausted:
            return False
    solver.add([a, -b])
    solver.add([-a, b])
    return True
