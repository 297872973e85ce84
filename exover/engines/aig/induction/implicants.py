"""Reachability of states whose kind only a large circuit tells: by implicants, one cube after the other.

A solver finds states of the kind. Each is generalised to a cube, all of whose states are of the kind: an implicant, by
an unsatisfiable core (as IC3 does with what it is to block, Bradley 2011). Whether a cube is reachable is asked of a
model checker, which never sees the circuit that tells the kind. What it proves excludes cubes, until no state of the
kind is left, or one is reachable.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import field
from itertools import islice

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Answer, Clause, Inputs, Reachable, SayAnswer, StopRequested, Unreachable
from exover.engines.aig.circuit.cnf import Cnf
from exover.engines.aig.circuit.graph import Circuit, Graph, Literal, valuation
from exover.engines.aig.circuit.solver import Exhausted, Solver

Decide = Callable[[Circuit, SayAnswer, StopRequested], None]
"""A model checker: says the answer to each bad literal of a circuit, by its index, until it is to stop."""
StatesOfKind = tuple[Literal, Literal]
"""A kind of states, `(where, holds)`: those of a set that is easily described, in which something holds."""
PartOfKind = tuple[Literal, Clause]
"""The states of such a set `where` that are in a cube."""
ROUNDS = 1, 2, 4, 8, 8, 8, 8, 8
"""By round how many parts of a kind are asked about at once."""
EFFORT = 10_000_000
"""Propagations that one question to the solver may cost."""
KEPT = 1_000_000
"""How many variables, in sum, the solvers may have that are kept for later questions about their kinds."""


@dataclass
class Implicants:
    """Excludes kinds of states, literals of a graph that may grow.

    `following`: by latch what it is after a step. `always`: a literal that is true in every reachable state.
    """

    graph: Graph
    following: Sequence[Literal]
    always: Literal
    decide: Decide
    stop: StopRequested
    clauses: dict[Clause, None] = field(default_factory=dict)
    """What was proved: an inductive invariant."""
    excluded: dict[PartOfKind, None] = field(default_factory=dict)
    """The parts that it excludes."""
    _searches: "dict[int, _Search]" = field(default_factory=dict)
    """Of the kinds that were asked about, by name, those asked about last at the end."""

    def __post_init__(self) -> None:
        self._cnf = Cnf(self.graph.within_step())

    def exclude(self, kinds: Mapping[int, StatesOfKind]) -> tuple[list[int], list[Inputs]]:
        """Return the kinds of which no state is reachable, by name, and runs to states of others.

        What the solver of a kind knows is of use when a kind of the same name is asked about again, much of whose
        circuit is the same.
        """
        circuit = self.graph.within_step()
        self._cnf.grow(circuit)
        for name, kind in kinds.items():
            search = self._searches.pop(name, None) or _Search(self, Solver(circuit, self._cnf))
            search.begin(kind)
            self._searches[name] = search
        searches = {name: self._searches[name] for name in kinds}
        runs = self._runs(searches.values())
        excluded = [name for name, search in searches.items() if search.is_there() is False]
        self._forget(excluded)
        return excluded, runs

    def _forget(self, excluded: Collection[int]) -> None:
        """Close the solvers of these kinds, and the least recently used ones while all have too many variables."""
        kept = 0
        for name, search in reversed(list(self._searches.items())):
            kept += search.solver.variables
            if name in excluded or kept > KEPT:
                search.solver.close()
                del self._searches[name]

    def _runs(self, searches: "Collection[_Search]") -> list[Inputs]:
        """Exclude parts of kinds until none is left, and return runs to those that are reachable, if some are."""
        for most in ROUNDS:
            parts = list(dict.fromkeys(part for search in searches for part in self._parts(search, searches, most)))
            if not parts or self.stop():
                break
            runs = self._ask(parts)
            for search in searches:
                search.learn()
            if runs:
                return runs
        return []

    def _parts(self, search: "_Search", searches: "Collection[_Search]", most: int) -> Iterator[PartOfKind]:
        """Yield up to so many parts of a kind that are not blocked, and block them for all."""
        for _ in range(most):
            part = search.part()
            if part is None:
                return
            for each in searches:
                each.block(part)
            yield part

    def _ask(self, parts: Sequence[PartOfKind]) -> list[Inputs]:
        """Ask whether states of these parts are reachable, and return runs to those that are.

        When one is, no more is made of the others: a run tells more than it costs to find more of them.
        """
        answers, runs = dict[int, Answer](), list[Inputs]()
        bad = [self.graph.all((where, *cube)) for where, cube in parts]

        def enough() -> bool:
            return self.stop() or any(isinstance(answer, Reachable) for answer in answers.values())

        self.decide(self.graph.circuit(self.following, bad), answers.__setitem__, enough)
        for place, answer in sorted(answers.items()):
            match answer:
                case Unreachable(invariant):
                    self.clauses |= dict.fromkeys(invariant)
                    self.excluded[parts[place]] = None
                case Reachable(inputs):
                    runs.append(inputs)
        return runs


@dataclass
class _Search:
    """The search for states of a kind; parts that are asked about are blocked where `_blocking` is assumed.

    It has a solver of its own: what tells its kind is a small part of what tells all, and a model is as large as what
    the solver knows.
    """

    given: Implicants
    solver: Solver
    _clauses: int = 0
    """How many of the proved clauses the solver knows."""
    _excluded: int = 0
    """How many of the excluded parts it knows."""

    def __post_init__(self) -> None:
        self.solver.add([self.solver.literal(self.given.always)])
        self._latches = [node for node, _ in self.given.graph.latches]

    def begin(self, kind: StatesOfKind) -> None:
        """Look for states of a kind from now on, of which none is blocked yet."""
        self.kind, self._blocking = kind, self.solver.fresh()
        self.learn()

    def learn(self) -> None:
        """Note what was proved since this was last called."""
        clauses, excluded = self.given.clauses, self.given.excluded
        for clause in islice(clauses, self._clauses, None):
            self.solver.add(self._literals(clause))
        for part in islice(excluded, self._excluded, None):
            self.solver.add(self._outside(*part))
        self._clauses, self._excluded = len(clauses), len(excluded)

    def is_there(self, blocking: bool = False) -> bool | None:
        """Return whether there is a state of the kind, which is not blocked; None if it takes too long to tell."""
        return self._can_be([self._blocking] * blocking + self._literals(self.kind))

    def part(self) -> PartOfKind | None:
        """Return a part of the kind that is not blocked, if it is known that there is one."""
        return (self.kind[0], self._implicant()) if self.is_there(blocking=True) else None

    def block(self, part: PartOfKind) -> None:
        """Block a part: `part` returns no state of it until `begin` is called again."""
        self.solver.add([-self._blocking, *self._outside(*part)])

    def _outside(self, where: Literal, cube: Clause) -> list[int]:
        return [-each for each in self._literals([where, *cube])]

    def _literals(self, literals: Sequence[Literal]) -> list[int]:
        return list(map(self.solver.literal, literals))

    def _can_be(self, assumed: Sequence[int]) -> bool | None:
        """Return whether some state fulfils what is assumed; None if it takes too long to tell."""
        try:
            return self.solver.satisfiable(assumed, EFFORT)
        except Exhausted:
            return None

    def _implicant(self) -> Clause:
        """Return a cube of latches, true in the last model, whose states in the set are all of the kind."""
        true = self.solver.true(self._latches)
        left = valuation(filter(self.solver.knows, self._latches), true)
        for dropped in (None, *left):
            if dropped is None or dropped in left:
                core = self._core([each for each in left if each != dropped])
                left = left if core is None else core
        return tuple(sorted(left))

    def _core(self, cube: Sequence[Literal]) -> list[Literal] | None:
        """Return literals of a cube that are enough for a state of the set to be of the kind; None if the cube is not.

        None as well if it takes too long to tell.
        """
        where, holds = self._literals(self.kind)
        if self._can_be([where, *self._literals(cube), -holds]) is not False:
            return None
        core = self.solver.core()
        return [each for each in cube if self.solver.literal(each) in core]
