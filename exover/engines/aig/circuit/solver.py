"""An incremental SAT solver for one step of a circuit, which loads cones when they are asked for."""

from collections.abc import Iterable, Sequence
from functools import partial

from exover.engines.aig.circuit.cnf import Cnf, NodeClauses, signed
from exover.engines.aig.circuit.graph import Circuit, Literal


class Exhausted(Exception):
    """The propagations that were granted are spent."""


class Solver:
    """One step of a circuit in an incremental solver; cones are added when a literal of them is first asked for.

    A literal of the solver is an int as in DIMACS. Work is counted in propagations, `CALL` for each question besides,
    so that equal questions cost the same on every machine.
    """

    CALL = 2_000

    def __init__(self, circuit: Circuit, cnf: Cnf | None = None) -> None:
        """Take a circuit; `cnf`: its clauses, if another solver has them already."""
        import pysolvers
        from pysat.solvers import Minisat22

        self.cnf = cnf or Cnf(circuit)
        self.work = 0
        self.calls = 0
        self._solver = Minisat22()
        self._add = partial(pysolvers.minisat22_add_cl, self._solver.minisat)
        self._variables = {0: 1}
        self._last = 1
        self._propagations = 0
        self._add([-1])

    def literal(self, literal: Literal) -> int:
        """Return the solver's literal of a literal of the circuit, and load its cone."""
        node = literal >> 1
        variable = self._variables.get(node)
        if variable is None:
            self._load(node)
            variable = self._variables[node]
        return -variable if literal & 1 else variable

    @property
    def variables(self) -> int:
        """How many variables it has."""
        return self._last

    def knows(self, node: int) -> bool:
        """Return True iff the node is in a cone that was asked for."""
        return node in self._variables

    def grow(self, circuit: Circuit) -> None:
        """Continue with a circuit that has the same nodes and further ones."""
        self.cnf.grow(circuit)

    def _load(self, root: int) -> None:
        """Add the cone of a node."""
        variables = self._variables
        fresh: list[tuple[int, NodeClauses]] = []
        waiting = [root]
        while waiting:
            node = waiting.pop()
            if node in variables:
                continue
            self._last += 1
            variables[node] = self._last
            gate = self.cnf.gate(node)
            if gate is not None:
                fresh.append((node, gate))
                waiting += gate[0]
        for node, (leaves, clauses) in fresh:
            literals = signed([*map(variables.__getitem__, leaves), variables[node]])
            for pick in clauses:
                self._add(pick(literals))

    def fresh(self) -> int:
        """Return a new variable, on which there are no clauses."""
        self._last += 1
        return self._last

    def add(self, clause: Iterable[int]) -> None:
        """Add a clause of the solver's literals."""
        self._add(list(clause))

    def satisfiable(self, assumptions: Sequence[int], granted: int | None = None) -> bool:
        """Return True iff all clauses and assumptions can be true; `Exhausted` after `granted` propagations."""
        self.calls += 1
        self._solver.prop_budget(-1 if granted is None else max(1, granted))
        # Else python-sat installs a handler of its own for Ctrl-C, and does not take it away once it was heard.
        found = self._solver.solve_limited(assumptions, expect_interrupt=True)
        propagations = self._solver.accum_stats()["propagations"]
        self.work += propagations - self._propagations + self.CALL
        self._propagations = propagations
        if found is None:
            raise Exhausted
        return bool(found)

    def possible(self, literals: Iterable[Literal], granted: int | None = None) -> bool:
        """Return True iff literals of the circuit can be true together; `Exhausted` as in `satisfiable`."""
        return self.satisfiable([self.literal(each) for each in literals], granted)

    def core(self) -> set[int]:
        """Return assumptions of the last question that cannot be true together."""
        return set(self._solver.get_core() or ())

    def true(self, nodes: Iterable[int]) -> set[int]:
        """Return which of the nodes are true in the last model; those that it does not know are not.

        Nor are leaves that no clause names, as the function of the node above ignores them: a model may end before.
        """
        model = self._solver.get_model()
        known = {node: variable for node in nodes if (variable := self._variables.get(node)) is not None}
        return {node for node, variable in known.items() if variable <= len(model) and model[variable - 1] > 0}

    def close(self) -> None:
        """Free the solver, once: python-sat would free it again if a signal's handler raised while it is freed."""
        import pysolvers

        freed, self._solver.minisat = self._solver.minisat, None
        if freed is not None:
            pysolvers.minisat22_del(freed)
