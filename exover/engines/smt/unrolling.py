"""Unrolling of a system's transition relation, moment by moment (Biere, Cimatti, Clarke, Zhu 1999)."""

from collections.abc import Iterable, Sequence
from dataclasses import field
from fractions import Fraction
from typing import Any

from exover.dataclass import dataclass
from exover.engines.smt.relation import Move
from exover.engines.smt.solver import Clock, Inconclusive, Translation, Valuation, new_solver
from exover.engines.smt.system import System
from exover.loop.exact.events import Kind
from exover.loop.exact.term import Number, Term


@dataclass(frozen=True, slots=True)
class Taken:
    """A step of a run that was found: the kind of event, and the values it brings by input."""

    kind: Kind
    values: dict[str, bool | Number]


@dataclass
class Unrolled:
    """Moments 0 to `depth` of a run; the first is the start, or any that satisfies the lemmas."""

    system: System
    clock: Clock
    from_start: bool = True
    depth: int = 0
    _at: list[Translation] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.relation = self.system.relation
        self.solver = new_solver()
        terms = self.system.terms
        self._plain = Translation()
        self._step = self._plain(self.relation.step)
        if self.from_start:
            self.add(0, *(terms.equal(var, value) for var, value in self.system.initial.items()))
        self.add(0, *self.system.lemmas)

    def at(self, moment: int, term: Term) -> Any:
        """Return the expression of a term at a moment; inputs are those of the step from it."""
        while len(self._at) <= moment:
            self._at.append(Translation(f"@{len(self._at)}"))
        return self._at[moment](term)

    def add(self, moment: int, *terms: Term) -> None:
        """Assert that terms are true at a moment."""
        self.solver.add([self.at(moment, term) for term in terms])

    def grow(self) -> None:
        """Add a step."""
        import z3

        now, then = self.depth, self.depth + 1
        pairs = [(self._plain(var), self.at(now, var)) for var in (*self.system.vars.values(), *self.relation.inputs)]
        pairs += [(self._plain(self.relation.next[name]), self.at(then, var)) for name, var in self.system.vars.items()]
        self.solver.add(z3.substitute(self._step, pairs))
        self.depth = then
        self.add(then, *self.system.lemmas)

    def grow_to(self, depth: int) -> None:
        """Add steps until there are so many."""
        while self.depth < depth:
            self.grow()

    def check(self, conditions: Iterable[Any], most: float = float("inf")) -> Any:
        """Return a model of Z3 in which the conditions are true; None if there is none; raises `Inconclusive`."""
        import z3

        self.solver.push()
        try:
            self.solver.add(list(conditions))
            self.clock.limit(self.solver, most)
            answer = self.solver.check()
            if answer == z3.unknown:
                raise Inconclusive("the solver gave up")
            return self.solver.model() if answer == z3.sat else None
        finally:
            self.solver.pop()

    # ---- what was found ----

    def taken(self, model: Any, depth: int) -> list[Taken]:
        """Return the steps of a run up to a moment."""
        return [self._taken(model, moment) for moment in range(depth)]

    def _taken(self, model: Any, moment: int) -> Taken:
        values = Valuation(model, lambda term: self.at(moment, term))
        number = sum(bool(values.value(bit)) << place for place, bit in enumerate(self.relation.bits))
        move = self.move(number)
        return Taken(move.kind, {each.var.name: values.value(each.var) for each in move.inputs})

    def move(self, number: int) -> Move:
        """Return a move by its number."""
        return self.system.moves[number]

    def values(self, model: Any, moment: int) -> dict[Term, Term]:
        """Return the constants that the variables are at a moment."""
        found, terms = Valuation(model, lambda term: self.at(moment, term)), self.system.terms
        return {var: terms.literal(found.value(var), var.sort) for var in self.system.vars.values()}

    def same(self, one: int, other: int) -> Any:
        """Return the condition that two moments have the same state, arguments that do not count left out."""
        import z3

        owners, layout = self.system.layout.owners, self.system.layout
        found = []
        for name, var in self.system.vars.items():
            if name in self.system.observers:
                continue
            equal = self.at(one, var) == self.at(other, var)
            owner = owners.get(name)
            found.append(z3.Implies(self.at(one, layout.vars[owner]), equal) if owner else equal)
        return z3.And(found)


def reals(steps: Sequence[Taken]) -> list[Fraction]:
    """Return the fractions among the values of a run."""
    return [value for taken in steps for value in taken.values.values() if isinstance(value, Fraction)]
