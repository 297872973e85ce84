"""Houdini (Flanagan, Leino 2001): the largest part of some clauses that every step keeps if all of it is assumed."""

from collections.abc import Iterable, Sequence

from exover.engines.aig.circuit.answer import Clause
from exover.engines.aig.circuit.graph import Circuit, Literal
from exover.engines.aig.circuit.solver import Exhausted, Solver


class Induction:
    """Questions about one step of a circuit to one incremental SAT solver, which the caller closes."""

    def __init__(self, circuit: Circuit) -> None:
        self._latches = {latch.node: latch for latch in circuit.latches}
        self._solver = Solver(circuit)

    def close(self) -> None:
        """Free the solver."""
        self._solver.close()

    def kept(self, clauses: Iterable[Clause], known: Sequence[Clause] = ()) -> tuple[Clause, ...]:
        """Return the largest part of the clauses that is inductive: the start satisfies it, every step keeps it.

        In the order of the clauses. `known`: clauses that are an invariant, which are assumed besides.
        """
        found = tuple(clause for clause in dict.fromkeys(clauses) if self._starts(clause))
        while True:
            broken = self._broken(found, known)
            if not broken:
                return found
            found = tuple(clause for clause in found if clause not in broken)

    def excluded(self, clauses: Sequence[Clause], asked: Iterable[tuple[Literal, int | None]]) -> list[bool]:
        """Return for each literal whether no state that satisfies all clauses makes it true, whatever the inputs are.

        `asked`: each with the propagations that it may cost, if there is a limit; False if they are not enough.
        """
        assumed = self._assume(clauses)
        found = [self._is_excluded([assumed, self._solver.literal(literal)], granted) for literal, granted in asked]
        self._solver.add([-assumed])
        return found

    def _is_excluded(self, assumptions: Sequence[int], granted: int | None) -> bool:
        try:
            return not self._solver.satisfiable(assumptions, granted)
        except Exhausted:
            return False

    def enough(self, clauses: Sequence[Clause], bad: Literal) -> tuple[Clause, ...]:
        """Return few of the clauses that together exclude `bad` and are kept by every step: unsatisfiable cores say
        which are needed for the literal, then which for each of these (after Ivrii, Gurfinkel, Belov 2014).

        All of them if they do not exclude it, or some step does not keep them.
        """
        assumed = {self._assume([clause]): clause for clause in clauses}
        needed: dict[Clause, None] = {}
        left = [[self._solver.literal(bad)]]
        while left:
            wrong = left.pop()
            known = [literal for literal, clause in assumed.items() if clause in needed]
            if self._solver.satisfiable([*wrong, *known]):
                if self._solver.satisfiable([*wrong, *assumed]):
                    return tuple(clauses)
                core = self._solver.core()
                fresh = [clause for literal, clause in assumed.items() if literal in core and clause not in needed]
                needed |= dict.fromkeys(fresh)
                left += [[-self._solver.literal(literal) for literal in self._after(clause)] for clause in fresh]
        return tuple(needed)

    def _starts(self, clause: Clause) -> bool:
        return any(self._latches[literal >> 1].initial != bool(literal & 1) for literal in clause)

    def _after(self, clause: Clause) -> list[Literal]:
        """Return the next-state literals of the literals of a clause."""
        return [self._latches[literal >> 1].next ^ (literal & 1) for literal in clause]

    def _broken(self, clauses: Sequence[Clause], known: Sequence[Clause]) -> set[Clause]:
        """Return some clauses that a step from a state of all and the known clauses breaks; none iff no step does."""
        assumed = self._assume([*clauses, *known])
        after = {clause: self._after(clause) for clause in clauses}
        found: set[Clause] = set()
        for clause, literals in after.items():
            wrong = [-self._solver.literal(literal) for literal in literals]
            if clause not in found and self._solver.satisfiable([assumed, *wrong]):
                found |= self._wrong(after)
        self._solver.add([-assumed])
        return found

    def _wrong(self, after: dict[Clause, list[Literal]]) -> set[Clause]:
        """Return which clauses the step of the last model breaks, among those that the solver knows."""
        nodes = {literal >> 1 for literals in after.values() for literal in literals}
        known = set(filter(self._solver.knows, nodes))
        true = self._solver.true(known)
        return {
            clause
            for clause, literals in after.items()
            if all(each >> 1 in known and (each >> 1 in true) == bool(each & 1) for each in literals)
        }

    def _assume(self, clauses: Iterable[Clause]) -> int:
        """Return a literal of the solver that implies clauses."""
        assumed = self._solver.fresh()
        for clause in clauses:
            self._solver.add([-assumed, *map(self._solver.literal, clause)])
        return assumed
