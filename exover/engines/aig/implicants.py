"""Whether states of a kind are reachable, where it takes a large circuit to tell their kind: one cube after the other.

A solver finds states of the kind. Each is generalised to a cube, all of whose states are of the kind: an implicant, by
an unsatisfiable core (as IC3 does with what it is to block, Bradley 2011). Whether a cube is reachable is asked of a
model checker, which never sees the circuit that tells the kind. What it proves excludes cubes, until no state of the
kind is left, or one is reachable.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from exover.engines.aig.answer import Answer, Clause, Inputs, Reachable, Unreachable
from exover.engines.aig.graph import FALSE, Circuit, Graph, Literal
from exover.engines.aig.solver import Exhausted, Solver

Decide = Callable[[Circuit, Callable[[int, Answer], None], Callable[[], bool]], None]
"""A solver: says the answer to each bad literal of a circuit, by its index, until it is to stop."""
Kind = tuple[Literal, Literal]
"""States of a kind: those of a set that is easily described, in which something holds."""
Part = tuple[Literal, Clause]
"""The states of such a set that are in a cube."""
ROUNDS = 1, 2, 4, 8, 8, 8, 8, 8
"""Parts of a kind that are asked about at once."""
EFFORT = 10_000_000
"""Propagations that one question to the solver may cost."""


@dataclass
class Implicants:
    """Excludes kinds of states, literals of a graph that may grow.

    `following`: by latch what it is after a step. `always`: a literal that is true in every reachable state.
    """

    graph: Graph
    following: Sequence[Literal]
    always: Literal
    decide: Decide
    stop: Callable[[], bool]
    clauses: dict[Clause, None] = field(default_factory=dict)
    """What was proved: an inductive invariant."""
    excluded: dict[Part, None] = field(default_factory=dict)
    """What follows from it."""

    def exclude(self, kinds: Sequence[Kind]) -> tuple[list[int], list[Inputs]]:
        """Return, by place, the kinds of which no state is reachable, and runs to states of others."""
        solver = Solver(self.graph.circuit([FALSE] * len(self.graph.latches), ()))
        try:
            return _Search(self, solver, kinds).result()
        finally:
            solver.close()


@dataclass
class _Search:
    """Kinds of states while they are looked for; what is only asked about is blocked while `blocking` is assumed."""

    given: Implicants
    solver: Solver
    kinds: Sequence[Kind]
    runs: list[Inputs] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.solver.add([self.solver.literal(self.given.always)])
        self._keep(self.given.clauses)
        for part in self.given.excluded:
            self._exclude(*part)
        self.blocking = self.solver.fresh()
        self.latches = [node for node, _ in self.given.graph.latches]

    def result(self) -> tuple[list[int], list[Inputs]]:
        """Return what `Implicants.exclude` does."""
        for most in ROUNDS:
            parts = list(dict.fromkeys(part for kind in self.kinds for part in self._parts(kind, most)))
            if not parts or self.given.stop():
                break
            self._ask(parts)
            if self.runs:
                break
        return [n for n, kind in enumerate(self.kinds) if self._is_there(self._literals(kind)) is False], self.runs

    def _literals(self, literals: Iterable[Literal]) -> list[int]:
        return [self.solver.literal(each) for each in literals]

    def _parts(self, kind: Kind, most: int) -> Iterator[Part]:
        """Yield up to so many parts of a kind that are not blocked, and block them."""
        for _ in range(most):
            if self._is_there([self.blocking, *self._literals(kind)]) is not True:
                return
            part = kind[0], self._implicant(kind)
            self.solver.add([-self.blocking, *(-each for each in self._literals([kind[0], *part[1]]))])
            yield part

    def _is_there(self, assumed: Sequence[int]) -> bool | None:
        """Return whether some state fulfils what is assumed; None if it takes too long to tell."""
        try:
            return self.solver.satisfiable(assumed, EFFORT)
        except Exhausted:
            return None

    def _implicant(self, kind: Kind) -> Clause:
        """Return a cube of latches, true in the last model, whose states in the set are all of the kind."""
        true = self.solver.true(self.latches)
        left = [2 * node + (node not in true) for node in self.latches if self.solver.knows(node)]
        for dropped in (None, *left):
            if dropped is None or dropped in left:
                core = self._core(kind, [each for each in left if each != dropped])
                left = left if core is None else core
        return tuple(sorted(left))

    def _core(self, kind: Kind, cube: Sequence[Literal]) -> list[Literal] | None:
        """Return literals of a cube that are enough for a state of the set to be of the kind; None if the cube is not.

        None as well if it takes too long to tell.
        """
        where, holds = self._literals(kind)
        if self._is_there([where, *self._literals(cube), -holds]) is not False:
            return None
        core = self.solver.core()
        return [each for each in cube if self.solver.literal(each) in core]

    def _ask(self, parts: Sequence[Part]) -> None:
        """Ask whether states of these parts are reachable."""
        graph, answers = self.given.graph, dict[int, Answer]()
        bad = [graph.all((where, *cube)) for where, cube in parts]
        self.given.decide(graph.circuit(self.given.following, bad), answers.__setitem__, self.given.stop)
        for place, answer in sorted(answers.items()):
            match answer:
                case Unreachable(invariant):
                    self._keep(invariant)
                    self._exclude(*parts[place])
                case Reachable(inputs):
                    self.runs.append(inputs)

    def _keep(self, clauses: Iterable[Clause]) -> None:
        for clause in clauses:
            self.given.clauses[clause] = None
            self.solver.add([self.solver.literal(each) for each in clause])

    def _exclude(self, where: Literal, cube: Clause) -> None:
        self.given.excluded[where, cube] = None
        self.solver.add([-each for each in self._literals([where, *cube])])
