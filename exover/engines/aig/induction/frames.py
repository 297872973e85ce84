"""The frames of PDR, and a solver: clauses of frame `k` hold in every state that at most `k` steps reach."""

from collections import Counter
from collections.abc import Iterable, Sequence

from exover.engines.aig.circuit.answer import Clause, StopRequested
from exover.engines.aig.circuit.graph import Circuit, Literal, valuation
from exover.engines.aig.circuit.solver import Exhausted, Solver
from exover.engines.aig.simulation.reached import Cube, Reached


class Stopped(Exception):
    """The caller wants no more answers."""


class Frames:
    """The frames, and questions about one step from a frame."""

    RENEW = 300
    """After how many dropped temporary clauses the solver is made anew."""

    def __init__(self, circuit: Circuit, known: Iterable[Clause], reached: Reached, stop: StopRequested) -> None:
        self.circuit, self.reached, self.stop = circuit, reached, stop
        self.latches = [latch for latch in circuit.latches if 2 * latch.node in reached.words]
        self.following = {latch.node: latch.next for latch in self.latches}
        self.start = [2 * latch.node + (not latch.initial) for latch in self.latches]
        self.away = frozenset(literal ^ 1 for literal in self.start)
        self.inputs = frozenset(circuit.inputs)
        self.forever: list[Cube] = [tuple(literal ^ 1 for literal in clause) for clause in known]
        self.levels: list[list[Cube]] = [[], []]
        self.uses: Counter[Literal] = Counter()
        """How many of the cubes that were learnt hold a literal: cubes of literals that others hold say more."""
        self.done = 0
        self.granted: int | None = None
        self.solver = Solver(circuit)
        self._renew()

    @property
    def work(self) -> int:
        """Return the propagations so far."""
        return self.done + self.solver.work

    def _renew(self) -> None:
        """Make a new solver of what is known."""
        self.done += self.solver.work
        self.solver.close()
        self.solver = Solver(self.circuit, self.solver.cnf)
        self._dead = 0
        self._gates: list[int] = []
        for cube in self.forever:
            self._exclude(cube, None)
        for level, cubes in enumerate(self.levels):
            self._gate(level)
            for cube in cubes:
                self._exclude(cube, self._gates[level])

    def _gate(self, level: int) -> None:
        """Make the activation literals of the frames up to this one, as far as they are missing."""
        while len(self._gates) <= level:
            gate = self.solver.fresh()
            if not self._gates:
                for literal in self.start:
                    self.solver.add([-gate, self.solver.literal(literal)])
            self._gates.append(gate)
        while len(self.levels) <= level:
            self.levels.append([])

    def _exclude(self, cube: Cube, gate: int | None) -> None:
        """Tell the solver that no state of the cube is in the frames of a gate."""
        clause = [-self.solver.literal(literal) for literal in cube]
        self.solver.add(clause if gate is None else [-gate, *clause])

    def frame(self, level: int) -> list[int]:
        """Return assumptions that the state lies in a frame."""
        self._gate(level)
        return self._gates[level:]

    def after(self, literal: Literal) -> int:
        """Return the solver's literal for a literal of a latch one step later."""
        return self.solver.literal(self.following[literal >> 1] ^ (literal & 1))

    def ask(self, assumptions: Sequence[int]) -> bool:
        """Return True iff some step satisfies the assumptions. Raises `Stopped` or `Exhausted`."""
        if self.stop():
            raise Stopped
        left = None if self.granted is None else self.granted - self.work
        if left is not None and left <= 0:
            raise Exhausted
        return self.solver.satisfiable(assumptions, left)

    def temporary(self, clause: Iterable[int]) -> int:
        """Return a literal that stands for a clause until it is dropped."""
        gate = self.solver.fresh()
        self.solver.add([-gate, *clause])
        return gate

    def drop(self, gate: int) -> None:
        """Drop a temporary clause."""
        self.solver.add([-gate])
        self._dead += 1

    def step(self) -> tuple[Cube, frozenset[int]]:
        """Return the state, as far as the solver knows its latches, and the true inputs of the last model."""
        nodes = [latch.node for latch in self.latches if self.solver.knows(latch.node)]
        true = self.solver.true([*nodes, *self.inputs])
        return tuple(valuation(nodes, true)), self.inputs & true

    def lifted(self, state: Cube, inputs: frozenset[int], goal: Sequence[int]) -> Cube:
        """Return literals of the state that suffice for these inputs to lead to the goal (Chockler et al. 2011)."""
        solver = self.solver
        if len(goal) == 1:
            gate, wrong = None, -goal[0]
        else:
            gate = wrong = self.temporary([-literal for literal in goal])
        known = filter(solver.knows, self.circuit.inputs)
        fixed = [wrong, *map(solver.literal, valuation(known, inputs))]
        by_variable = {solver.literal(literal): literal for literal in self.often_first(state)}
        held = list(by_variable)
        while True:
            if self.ask([*fixed, *held]):
                raise AssertionError("a step does not lead where it led")
            core = self.solver.core()
            smaller = [variable for variable in held if variable in core]
            if len(smaller) > 0.9 * len(held) or len(smaller) <= 1:
                break
            held = smaller
        if gate is not None:
            self.drop(gate)
        return tuple(sorted(by_variable[variable] for variable in smaller))

    def inductive(self, level: int, cube: Cube) -> Cube | None:
        """Return a part of the cube that is inductive relative to a frame; `None` if the cube is entered from outside.

        The part does not hold the start if the cube does not.
        """
        after = {self.after(literal): literal for literal in self.often_first(cube)}
        gate = self.temporary([-self.solver.literal(literal) for literal in cube])
        try:
            if self.ask([gate, *self.frame(level), *after]):
                return None
            core = self.solver.core()
        finally:
            self.drop(gate)
        part = [literal for variable, literal in after.items() if variable in core]
        if not self.leaves_start(part):
            part += [literal for literal in after.values() if literal in self.away][:1]
        return tuple(sorted(part))

    def leaves_start(self, cube: Iterable[Literal]) -> bool:
        """Return True iff a cube does not hold the start."""
        return not self.away.isdisjoint(cube)

    def often_first(self, cube: Iterable[Literal]) -> list[Literal]:
        """Return the literals of a cube, those first that are in most learnt cubes."""
        return sorted(cube, key=lambda literal: (-self.uses[literal], literal))

    def enters(self, level: int, cube: Cube) -> bool:
        """Return True iff some step from a frame enters the cube."""
        return self.ask([*self.frame(level), *(self.after(literal) for literal in cube)])

    def learn(self, cube: Cube, level: int) -> None:
        """Exclude a cube from the frames up to this one."""
        literals = set(cube)
        for cubes in self.levels[1 : level + 1]:
            cubes[:] = [other for other in cubes if not literals.issubset(other)]
        self.uses.update(cube)
        self.raise_to(cube, level)

    def raise_to(self, cube: Cube, level: int) -> None:
        """Exclude a cube from this frame, too; lower ones exclude it already."""
        self._gate(level)
        self.levels[level].append(cube)
        self._exclude(cube, self._gates[level])

    def excluded(self, cube: Cube, level: int) -> bool:
        """Return True iff a cube is excluded from a frame by one clause."""
        literals = set(cube)
        cubes = (other for frame in (self.forever, *self.levels[level:]) for other in frame)
        return any(literals.issuperset(other) for other in cubes)

    def assume(self, cubes: Iterable[Cube]) -> None:
        """Add cubes that, with what holds forever already, no run enters."""
        for cube in cubes:
            self.forever.append(cube)
            self._exclude(cube, None)

    def invariant(self) -> tuple[Clause, ...]:
        """Return the clauses that hold forever."""
        return tuple(tuple(literal ^ 1 for literal in cube) for cube in self.forever)

    def tidy(self) -> None:
        """Make a new solver if the old one holds too many dropped clauses."""
        if self._dead > self.RENEW:
            self._renew()

    def settle(self, level: int) -> None:
        """Make the clauses of a frame and above hold forever."""
        for cubes in self.levels[level:]:
            self.forever += cubes
            for cube in cubes:
                self._exclude(cube, None)
            cubes.clear()
        del self.levels[level + 1 :]
        self._gates = self._gates[: level + 1]
