"""Runs of so many steps: the moves of a system unrolled, moment by moment (Biere, Cimatti, Clarke, Zhu 1999)."""

from collections.abc import Iterable, Sequence
from dataclasses import field
from fractions import Fraction
from functools import cached_property
from typing import Any

from exover.dataclass import dataclass
from exover.engines.smt.solver import Clock, Inconclusive, Translation, Valuation, new_solver
from exover.engines.smt.system import Move, System
from exover.loop.exact.events import Kind
from exover.loop.exact.term import Number, Term, variables


@dataclass(frozen=True, slots=True)
class Taken:
    """A step of a run that was found: the kind of event, and the values it brings by input."""

    kind: Kind
    values: dict[str, bool | Number]


@dataclass(frozen=True)
class Relation:
    """The moves of a system as one relation between two moments: a choice of a move, and what it makes of the first."""

    system: System

    @cached_property
    def bits(self) -> tuple[Term, ...]:
        """The variables whose values choose the move."""
        count = max(len(self.system.moves) - 1, 0).bit_length()
        return tuple(self.system.terms.var(f"choice {bit}", "Bool") for bit in range(count))

    def chosen(self, number: int) -> Term:
        """Return where the move of this number is chosen."""
        terms = self.system.terms
        pairs = enumerate(self.bits)
        return terms.both(bit if number >> place & 1 else terms.negation(bit) for place, bit in pairs)

    @cached_property
    def allowed(self) -> Term:
        """Return where the chosen move is one, and allowed."""
        terms = self.system.terms
        return terms.either(
            terms.both((self.chosen(number), move.allowed)) for number, move in enumerate(self.system.moves)
        )

    @cached_property
    def after(self) -> dict[str, Term]:
        """By variable what it is after the chosen move."""
        terms, found = self.system.terms, {}
        for name, var in self.system.vars.items():
            by_value: dict[Term, list[Term]] = {}
            for number, move in enumerate(self.system.moves):
                value = move.after.get(name, var)
                if value is not var:
                    by_value.setdefault(value, []).append(self.chosen(number))
            result = var
            for value, choices in by_value.items():
                result = terms.choose(terms.either(choices), value, result)
            found[name] = result
        return found


@dataclass
class Unrolled:
    """Moments 0 to `depth` of a run; the first is the start, or any that satisfies the lemmas."""

    system: System
    clock: Clock
    from_start: bool = True
    depth: int = 0
    _at: list[Translation] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.relation = Relation(self.system)
        self.solver = new_solver()
        terms = self.system.terms
        self._next = {name: terms.var(f"{name}'", var.sort) for name, var in self.system.vars.items()}
        step = terms.both(
            [self.relation.allowed]
            + [terms.equal(self._next[name], value) for name, value in self.relation.after.items()]
        )
        self._plain = Translation()
        self._step = self._plain(step)
        self._moving = sorted(
            variables([step]) - {*self.system.vars.values(), *self._next.values()}, key=lambda v: v.name
        )
        if self.from_start:
            self.add(0, *(terms.equal(var, value) for var, value in self.system.initial.items()))
        self.add(0, *self.system.lemmas)

    def at(self, moment: int, term: Term) -> Any:
        """Return the expression of a term at a moment; inputs are those of the step from it."""
        while len(self._at) <= moment:
            self._at.append(Translation(f"@{len(self._at)}"))
        return self._at[moment](term)

    def add(self, moment: int, *terms: Term) -> None:
        """Demand that terms are true at a moment."""
        self.solver.add([self.at(moment, term) for term in terms])

    def grow(self) -> None:
        """Add a step."""
        import z3

        now, then = self.depth, self.depth + 1
        pairs = [(self._plain(var), self.at(now, var)) for var in (*self.system.vars.values(), *self._moving)]
        pairs += [(self._plain(self._next[name]), self.at(then, var)) for name, var in self.system.vars.items()]
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
            self.solver.set("timeout", self.clock.left(most))
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
