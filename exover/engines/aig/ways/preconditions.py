"""In which states questions need a way, and in which words are one: weakest preconditions (Dijkstra 1975)."""

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property

from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import TRUE, Circuit, Graph
from exover.engines.aig.circuit.symbolic_simulation import Symbolic, SymbolicSimulation
from exover.engines.aig.induction.implicants import StatesOfKind
from exover.engines.aig.simulation.evaluation import Evaluator, evaluator
from exover.engines.aig.simulation.exploration import Seed, state_of
from exover.engines.aig.ways.way_literals import WayLiterals


class Preconditions:
    """For each question, by index, the states in which it needs a way, and those from which words lead to its goal.

    `home`: by latch its value, if it has the same one in all home states. `home_reachable`: home states can be reached
    from everywhere; questions with `from_home` need ways only there then.
    """

    def __init__(
        self,
        graph: Graph,
        circuit: Circuit,
        aims: Sequence[WayLiterals],
        fresh: Iterable[int],
        home: Mapping[int, bool],
        home_reachable: bool,
    ) -> None:
        self._graph = graph
        self._circuit = circuit
        self._aims = aims
        self._anywhere: Symbolic = {each.node: 2 * each.node for each in circuit.latches} | dict.fromkeys(fresh, TRUE)
        """By latch its literal in any state in which a way begins."""
        at_home = [home_reachable and aim.from_home for aim in aims]
        is_home = graph.all(2 * node + (not value) for node, value in home.items())
        self.begins = [is_home if so else aim.since for so, aim in zip(at_home, aims, strict=True)]
        """By question a literal over the state: it needs a way there."""
        self._unfoldings: dict[int, tuple[SymbolicSimulation, int]] = {}
        """By question the simulation of words from all states where its ways begin, and its place among these."""
        idle = self._anywhere | {node: int(value) for node, value in home.items()}
        for so, first in ((True, idle), (False, self._anywhere)):
            self._unfold([index for index, each in enumerate(at_home) if each == so], first)

    def _unfold(self, questions: Sequence[int], first: Symbolic) -> None:
        hits = tuple(self._aims[index].hit for index in questions)
        unfolding = SymbolicSimulation(self._graph, self._circuit, hits, first)
        self._unfoldings |= {index: (unfolding, place) for place, index in enumerate(questions)}

    def begin_anywhere(self, index: int) -> None:
        """Let a question need a way in every state of its `since`, not in home states alone."""
        self.begins[index] = self._aims[index].since
        self._unfold([index], self._anywhere)

    def needed(self, states: Sequence[Seed], questions: Iterable[int]) -> dict[int, int]:
        """Return, by question, in which of the states it needs a way, a bit for each."""
        conditions, everywhere = self._conditions, (1 << len(states)) - 1
        values = conditions.values(state_of(self._circuit.latches, states))
        return {index: conditions.read(values, self.begins[index], everywhere) for index in questions}

    def unhelped(self, index: int, words: Iterable[Inputs]) -> StatesOfKind:
        """Return two literals over the state: the question needs a way, and none of these words is one."""
        unfolding, place = self._unfoldings[index]
        helped = self._graph.any(unfolding.seen(word)[place] for word in words)
        return self.begins[index], self._graph.any((helped ^ 1, self._aims[index].lost))

    @cached_property
    def _conditions(self) -> Evaluator:
        """The evaluator of `begins` and of every `since`."""
        return evaluator(self._graph.within_step(), [*self.begins, *(aim.since for aim in self._aims)])
