"""Bounded model checking: a circuit unrolled step by step, and shortest runs (Biere et al. 1999)."""

from collections.abc import Mapping
from contextlib import closing, suppress
from dataclasses import field

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import FALSE, TRUE, Circuit, Graph, Literal
from exover.engines.aig.circuit.solver import Exhausted, Solver


@dataclass
class Unrolling:
    """The first steps of all runs in one graph, with inputs of their own; constants of the start are folded.

    `begun`: by node of a latch its literal before the first step, if runs begin elsewhere than at the start.
    """

    circuit: Circuit
    graph: Graph = field(default_factory=Graph)
    steps: list[dict[int, Literal]] = field(default_factory=list)
    """By step, by node of an input, its literal in the graph."""
    begun: Mapping[int, Literal] | None = None
    state: Mapping[int, Literal] = field(init=False)
    """By node of a latch its literal after the last step."""

    def __post_init__(self) -> None:
        self._latches = self.circuit.support(self.circuit.bad)
        nodes = self.circuit.cone([*self.circuit.bad, *(latch.next for latch in self._latches)])
        self._conjunctions = list(self.circuit.fanins.conjunctions(nodes))
        inputs = set(self.circuit.inputs)
        self._inputs = [node for node in nodes if node in inputs]
        start = {latch.node: TRUE if latch.initial else FALSE for latch in self._latches}
        self.state = start if self.begun is None else self.begun

    def step(self) -> list[Literal]:
        """Unroll one more step, and return the bad literals in it as literals of the graph."""
        inputs = {node: self.graph.input() for node in self._inputs}
        values = {0: FALSE, **self.state, **inputs}
        for node, left, right in self._conjunctions:
            values[node] = self.graph.conjunction(values[left >> 1] ^ (left & 1), values[right >> 1] ^ (right & 1))
        self.steps.append(inputs)
        self.state = {latch.node: values[latch.next >> 1] ^ (latch.next & 1) for latch in self._latches}
        return [values[bad >> 1] ^ (bad & 1) for bad in self.circuit.bad]

    def run(self, solver: Solver) -> Inputs:
        """Return the run that the last model of a solver of the graph describes."""
        true = solver.true(literal >> 1 for inputs in self.steps for literal in inputs.values())
        return tuple(
            frozenset(node for node, literal in inputs.items() if literal >> 1 in true) for inputs in self.steps
        )


@dataclass(frozen=True, slots=True)
class Shortest:
    """A run, and whether it is proved that none is shorter."""

    run: Inputs
    proved: bool


def shortest(circuit: Circuit, known: Mapping[int, Inputs], granted: int) -> dict[int, Shortest]:
    """Return, by index of bad literals, shortest runs that make them true in their last step.

    `known`: a run to each, of any length. `granted`: the propagations that all may cost; what is left then is not
    proved to be shortest.
    """
    found: dict[int, Shortest] = {}
    unrolling = Unrolling(circuit)
    left = dict(known)
    with closing(Solver(unrolling.graph.within_step())) as solver, suppress(Exhausted):
        while left:
            for index in [index for index, run in left.items() if len(run) == len(unrolling.steps) + 1]:
                found[index] = Shortest(left.pop(index), True)
            bad = unrolling.step() if left else []
            solver.grow(unrolling.graph.within_step())
            for index in list(left):
                if bad[index] != FALSE and solver.possible([bad[index]], granted - solver.work):
                    del left[index]
                    found[index] = Shortest(unrolling.run(solver), True)
    return found | {index: Shortest(run, False) for index, run in left.items()}
