"""Bounded model checking from many reached states at once.

A few steps are unrolled, not from the start but from whichever of some states suits: states that random runs have come
to. So runs are found that are far longer than what is unrolled, where simulation alone does not draw the last events
and model checking from the start does not get that deep (Ho, Shiple, Harer et al. 2000).
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace

from exover.dataclass import dataclass
from exover.engines.aig.answer import Inputs
from exover.engines.aig.bounded import Unrolling
from exover.engines.aig.exploration import Seed
from exover.engines.aig.graph import FALSE, TRUE, Circuit, Graph, Literal
from exover.engines.aig.solver import Exhausted, Solver


@dataclass(frozen=True, slots=True)
class Depth:
    """How far is looked: `steps` are unrolled.

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
    start = Seed(frozenset(latch.node for latch in circuit.latches if latch.initial), ())
    return runs_from(circuit, range(len(circuit.bad)), [start], START)


def runs_from(
    circuit: Circuit, asked: Iterable[int], seeds: Sequence[Seed], depth: Depth = SHALLOW
) -> dict[int, Inputs]:
    """Return runs that make bad literals true, by index, those that are found; each goes on from one of the seeds.

    `seeds`: at least one, of all latches that the bad literals depend on.
    """
    left = [index for index in asked if circuit.bad[index] != FALSE]
    if not left:
        return {}
    part = replace(circuit, bad=tuple(circuit.bad[index] for index in left))
    search = _Search(part, list({seed.true: seed for seed in reversed(seeds)}.values()))
    try:
        return {left[place]: run for place, run in search.runs(depth).items()}
    finally:
        search.solver.close()


class _Search:
    """An unrolling from one of the seeds, which the solver chooses."""

    def __init__(self, circuit: Circuit, seeds: Sequence[Seed]) -> None:
        self.seeds = seeds
        graph = Graph()
        nodes = [latch.node for latch in circuit.support(circuit.bad)]
        begun: dict[int, Literal]
        if len(seeds) == 1:
            begun = {node: TRUE if node in seeds[0].true else FALSE for node in nodes}
        else:
            begun = {node: graph.input() for node in nodes}
        self.chosen = [graph.input() for _ in seeds] if len(seeds) > 1 else []
        self.unrolling = Unrolling(circuit, graph, begun=begun)
        self.solver = Solver(graph.circuit((), ()))
        self.solver.add([self.solver.literal(each) for each in self.chosen or (TRUE,)])
        state = [(node, self.solver.literal(literal)) for node, literal in begun.items()]
        for seed, chosen in zip(seeds, self.chosen, strict=False):
            here = -self.solver.literal(chosen)
            for node, literal in state:
                self.solver.add((here, literal if node in seed.true else -literal))

    def runs(self, depth: Depth) -> dict[int, Inputs]:
        """Return runs by the place of the bad literal."""
        found: dict[int, Inputs] = {}
        solver, last = self.solver, self.solver.work
        left = dict.fromkeys(range(len(self.unrolling.circuit.bad)))
        for _ in range(depth.steps):
            bad = self.unrolling.step()
            solver.grow(self.unrolling.graph.circuit((), ()))
            for place in list(left):
                if solver.work > last + depth.patience:
                    return found
                if bad[place] != FALSE and self._is_reached(bad[place], depth.each):
                    found[place] = (*self._seed().run, *self.unrolling.run(solver))
                    del left[place]
                    last = solver.work
            if not left:
                break
        return found

    def _is_reached(self, bad: Literal, granted: int) -> bool:
        """Return whether a literal of the unrolling is found true; where it is shown false the solver learns that."""
        literal = self.solver.literal(bad)
        try:
            if self.solver.satisfiable([literal], granted):
                return True
        except Exhausted:
            return False
        self.solver.add([-literal])
        return False

    def _seed(self) -> Seed:
        """Return the seed of the last model."""
        true = self.solver.true(each >> 1 for each in self.chosen)
        return self.seeds[next((place for place, each in enumerate(self.chosen) if each >> 1 in true), 0)]
