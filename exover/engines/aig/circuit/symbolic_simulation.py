"""Symbolic simulation: steps from symbolic states with constant inputs, so that each step is one of a single event.

A state is given as literals over the latches of some moment; constants are folded by the graph in which all is built.
"""

from collections.abc import Iterable, Mapping
from dataclasses import field

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import FALSE, TRUE, Circuit, Graph, Literal, cone

Symbolic = Mapping[int, Literal]
"""A symbolic state: by node of a latch its literal."""


@dataclass
class SymbolicSimulation:
    """Runs of constant inputs from one symbolic state; runs that begin alike share the steps that they share.

    `watched`: literals over state and inputs that are evaluated in each step. Their values, and the states, are
    literals of `graph`.
    """

    graph: Graph
    circuit: Circuit
    watched: tuple[Literal, ...]
    first: Symbolic
    _steps: dict[Inputs, tuple[Symbolic, tuple[Literal, ...]]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        support = self.circuit.support(self.watched)
        self._latches = [latch for latch in self.circuit.latches if latch in set(support)]
        nodes = self.circuit.cone([*self.watched, *(latch.next for latch in self._latches)])
        self._conjunctions = list(self.circuit.fanins.conjunctions(nodes))
        self._inputs = set(self.circuit.inputs)

    def seen(self, run: Inputs) -> list[Literal]:
        """Return for each watched literal where, over the first state, some step of this run makes it true."""
        found: list[list[Literal]] = [[] for _ in self.watched]
        for length in range(1, len(run) + 1):
            for index, literal in enumerate(self._after(run[:length])[1]):
                found[index].append(literal)
        return [self.graph.any(literals) for literals in found]

    def state(self, run: Inputs) -> Symbolic:
        """Return the state that a run leads to."""
        return self._after(run)[0]

    def _after(self, run: Inputs) -> tuple[Symbolic, tuple[Literal, ...]]:
        if not run:
            return self.first, ()
        known = self._steps.get(run)
        if known is None:
            known = self._steps[run] = self.step(self._after(run[:-1])[0], run[-1])
        return known

    def step(self, state: Symbolic, true: Iterable[int]) -> tuple[Symbolic, tuple[Literal, ...]]:
        """Return the state after a step with these true inputs, and the watched literals in it."""
        values = [FALSE] * len(self.circuit.fanins)
        for latch in self._latches:
            values[latch.node] = state[latch.node]
        for node in true:
            values[node] = TRUE
        both = self.graph.conjunction
        for node, left, right in self._conjunctions:
            one, other = values[left >> 1] ^ (left & 1), values[right >> 1] ^ (right & 1)
            if one == FALSE or other == FALSE:
                continue
            values[node] = other if one == TRUE else one if other == TRUE else both(one, other)
        after = {latch.node: values[latch.next >> 1] ^ (latch.next & 1) for latch in self._latches}
        return after, tuple(values[literal >> 1] ^ (literal & 1) for literal in self.watched)


def substituted(graph: Graph, roots: Iterable[Literal], leaves: Mapping[int, Literal]) -> list[Literal]:
    """Return literals with inputs and latches substituted; `leaves`: by node its literal, others stay as they are."""
    roots = list(roots)
    values = {0: FALSE, **leaves}
    for node in sorted(cone(graph.fanins, roots)):
        pair = graph.fanins[node]
        if pair is None:
            values.setdefault(node, 2 * node)
            continue
        one, other = (values[literal >> 1] ^ (literal & 1) for literal in pair)
        values[node] = graph.conjunction(one, other)
    return [values[root >> 1] ^ (root & 1) for root in roots]
