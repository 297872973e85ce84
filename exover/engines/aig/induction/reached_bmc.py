"""Bounded model checking from many reached states at once.

A few steps are unrolled, not from the start but from whichever of some states suits: states that random runs have come
to. So runs are found that are far longer than what is unrolled, where simulation alone does not draw the last events
and model checking from the start does not get that deep (Ho, Shiple, Harer et al. 2000).
"""

from collections.abc import Iterable, Sequence
from contextlib import closing
from dataclasses import replace

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.bounded import Unrolling
from exover.engines.aig.circuit.graph import FALSE, Circuit, Graph, Literal
from exover.engines.aig.circuit.solver import Exhausted, Solver
from exover.engines.aig.simulation.exploration import Seed


@dataclass(frozen=True, slots=True)
class Depth:
    """The limits of a search: `steps` are unrolled.

    `each`: the propagations that a question may cost in a step; `patience`: those after which it is given up if nothing
    was found meanwhile.
    """

    steps: int = 8
    each: int = 300_000
    patience: int = 10_000_000


SHALLOW, START = Depth(), Depth(steps=14)
"""From many states, and from the start alone."""


def runs_from_start(circuit: Circuit) -> dict[int, Inputs]:
    """Return short runs that make bad literals true, by index, those that are found."""
    asked = range(len(circuit.bad))
    with closing(RunSearch(circuit, asked, from_start=True)) as search:
        return search.runs(asked, START)


def runs_from(
    circuit: Circuit, asked: Sequence[int], seeds: Sequence[Seed], depth: Depth = SHALLOW
) -> dict[int, Inputs]:
    """Return runs that make bad literals true, by index, those that are found; each goes on from one of the seeds.

    `seeds`: at least one, of all latches that the bad literals depend on.
    """
    if not asked:
        return {}
    with closing(RunSearch(circuit, asked)) as search:
        search.add(seeds)
        return search.runs(asked, depth)


class RunSearch:
    """An unrolling that begins in a state that the solver chooses, one of the seeds that are added, or at the start.

    What is unrolled and learnt is kept when seeds are added: that there are no others is assumed in each question.
    """

    def __init__(self, circuit: Circuit, asked: Iterable[int], from_start: bool = False) -> None:
        """Take a circuit, and the indices of those bad literals that may be asked for."""
        self._places = {index: place for place, index in enumerate(asked)}
        circuit = replace(circuit, bad=tuple(circuit.bad[index] for index in self._places))
        graph = Graph()
        self._state = {} if from_start else {latch.node: graph.input() for latch in circuit.support(circuit.bad)}
        self._unrolling = Unrolling(circuit, graph, begun=None if from_start else self._state)
        self._bad: list[list[Literal]] = []
        """By step what the bad literals are in it."""
        self._chosen: dict[Literal, Seed] = {}
        self._solver = Solver(graph.within_step())
        self._others = self._solver.fresh()
        """A literal of the solver: runs begin in a state of none of the seeds."""
        if not from_start:
            self._solver.add([self._others])

    def add(self, seeds: Sequence[Seed]) -> None:
        """Let runs begin in further seeds, of all latches that matter; of seeds with one state the first counts."""
        graph, solver = self._unrolling.graph, self._solver
        known = {seed.true for seed in self._chosen.values()}
        fresh = {seed.true: seed for seed in reversed(seeds) if seed.true not in known}
        chosen = {graph.input(): seed for seed in fresh.values()}
        solver.grow(graph.within_step())
        others = solver.fresh()
        solver.add([-self._others, *map(solver.literal, chosen), others])
        state = [(node, solver.literal(literal)) for node, literal in self._state.items()]
        for choice, seed in chosen.items():
            here = -solver.literal(choice)
            for node, literal in state:
                solver.add((here, literal if node in seed.true else -literal))
        self._others = others
        self._chosen |= chosen

    def runs(self, asked: Iterable[int], depth: Depth = SHALLOW) -> dict[int, Inputs]:
        """Return runs that make bad literals true, by index, those that are found."""
        found: dict[int, Inputs] = {}
        last = self._solver.work
        left = dict.fromkeys(asked)
        for step in range(depth.steps):
            bad = self._step(step)
            for index in list(left):
                if self._solver.work > last + depth.patience:
                    return found
                literal = bad[self._places[index]]
                if literal != FALSE and self._is_reached(literal, depth.each):
                    found[index] = (*self._begun(), *self._unrolling.run(self._solver)[: step + 1])
                    del left[index]
                    last = self._solver.work
            if not left:
                break
        return found

    def close(self) -> None:
        """Free the solver."""
        self._solver.close()

    def _step(self, step: int) -> list[Literal]:
        """Return the bad literals in a step, which is unrolled if it is the next one."""
        if step == len(self._bad):
            self._bad.append(self._unrolling.step())
            self._solver.grow(self._unrolling.graph.within_step())
        return self._bad[step]

    def _is_reached(self, bad: Literal, granted: int) -> bool:
        """Return whether a literal of the unrolling is found true; where it is shown false the solver learns that."""
        literal = self._solver.literal(bad)
        try:
            if self._solver.satisfiable([-self._others, literal], granted):
                return True
        except Exhausted:
            return False
        self._solver.add([-literal, self._others])
        return False

    def _begun(self) -> Inputs:
        """Return the run to the seed in which the run of the last model begins."""
        true = self._solver.true(each >> 1 for each in self._chosen)
        return next((seed.run for each, seed in self._chosen.items() if each >> 1 in true), ())
