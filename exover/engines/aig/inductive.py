"""Which of some clauses every step keeps, if all of them are assumed: Houdini (Flanagan, Leino 2001)."""

from collections.abc import Iterable, Sequence
from typing import Any

from exover.engines.aig.answer import Clause
from exover.engines.aig.graph import Circuit, Literal, ordered


class Induction:
    """The steps of a circuit, and one SAT solver that is asked of them again and again.

    It is to be closed. The variable of a node is its number plus 1.
    """

    def __init__(self, circuit: Circuit) -> None:
        from pysat.solvers import Solver

        self._latches = {latch.node: latch for latch in circuit.latches}
        self._solver: Any = Solver(name="cadical195")
        self._fresh = len(circuit.fanins) + 1
        self._add([-_variable(0)])
        self._circuit, self._known = circuit, {0}

    def _add(self, clause: Sequence[int]) -> None:
        self._solver.add_clause(clause)

    def close(self) -> None:
        """Free the solver."""
        self._solver.delete()

    def _learn(self, roots: Iterable[Literal]) -> None:
        """Tell the solver what literals are made of."""
        fresh = self._circuit.cone(roots) - self._known
        self._known |= fresh
        for node, left, right in ordered(self._circuit, fresh):
            mine, one, other = _variable(2 * node), _variable(left), _variable(right)
            self._add([-mine, one])
            self._add([-mine, other])
            self._add([mine, -one, -other])

    def _after(self, literal: Literal) -> Literal:
        """Return what a literal of a latch is after a step."""
        return self._latches[literal >> 1].next ^ (literal & 1)

    def starts(self, clause: Clause) -> bool:
        """Return whether the start satisfies a clause."""
        return any(self._latches[literal >> 1].initial != bool(literal & 1) for literal in clause)

    def kept(self, clauses: Iterable[Clause]) -> tuple[Clause, ...]:
        """Return the most of the clauses that the start satisfies and that every step keeps, in their order."""
        found = tuple(clause for clause in dict.fromkeys(clauses) if self.starts(clause))
        while True:
            broken = self._broken(found)
            if not broken:
                return found
            found = tuple(clause for clause in found if clause not in broken)

    def _broken(self, clauses: Sequence[Clause]) -> set[Clause]:
        """Return clauses that some step from a state of all of them breaks: none iff there is no such step."""
        assumed = self._assume(clauses)
        found: set[Clause] = set()
        for clause in clauses:
            after = [self._after(literal) for literal in clause]
            self._learn(after)
            if clause not in found and self._solver.solve([assumed, *(-_variable(literal) for literal in after)]):
                model = self._solver.get_model()
                found |= {each for each in clauses if self._breaks(model, each)}
        self._add([-assumed])
        return found

    def _breaks(self, model: Sequence[int], clause: Clause) -> bool:
        """Return whether a clause is false after the step of a model, as far as the model tells."""
        for literal in clause:
            variable = _variable(self._after(literal))
            if abs(variable) > len(model) or model[abs(variable) - 1] == variable:
                return False
            if self._after(literal) >> 1 not in self._known:
                return False
        return True

    def _assume(self, clauses: Sequence[Clause]) -> int:
        """Return a variable that implies clauses."""
        self._fresh += 1
        for clause in clauses:
            self._add([-self._fresh, *map(_variable, clause)])
        return self._fresh

    def excluded(self, clauses: Sequence[Clause], literals: Iterable[Literal]) -> list[bool]:
        """Return of each literal whether no state of all the clauses makes it true, whatever the inputs are."""
        assumed = self._assume(clauses)
        found = []
        for literal in literals:
            self._learn([literal])
            found.append(not self._solver.solve([assumed, _variable(literal)]))
        self._add([-assumed])
        return found


def _variable(literal: Literal) -> int:
    """Return the literal of the solver."""
    variable = (literal >> 1) + 1
    return -variable if literal & 1 else variable
