"""Conditions of the loop as SMV expressions over the symbols of its variables at one point of a step."""

from collections.abc import Iterable, Mapping
from functools import reduce
from operator import and_, or_

from exover.engines.smv.expression import FALSE, TRUE, Cases, Expr, SmvSymbol, among, at_most, conjunction, total
from exover.loop.finite.builder import ClosedLoop
from exover.loop.finite.variables import GuardedValue, StateGuard


class SymbolConditions:
    """The algebra of expressions over the symbols, in which `exover.loop.finite.predicates` reads conditions."""

    none: Expr = FALSE
    all: Expr = TRUE

    def __init__(self, loop: ClosedLoop, symbols: Mapping[int, SmvSymbol]) -> None:
        self.loop = loop
        self._symbols = symbols

    def complement(self, states: Expr) -> Expr:
        """Return the negation."""
        return ~states

    def conjunction(self, parts: Iterable[Expr]) -> Expr:
        """Return that all parts are true, joined in their order."""
        return reduce(and_, parts, TRUE)

    def disjunction(self, parts: Iterable[Expr]) -> Expr:
        """Return that some part is true, joined in their order."""
        return reduce(or_, parts, FALSE)

    def is_value(self, var: int, value: int) -> Expr:
        """Return when a variable has this value."""
        return among(self._symbols[var], (value,))

    def among(self, var: int, values: Iterable[int]) -> Expr:
        """Return when a variable has one of these values."""
        return among(self._symbols[var], values)

    def sum_of(self, terms: list[tuple[int, GuardedValue]]) -> dict[int, Expr]:
        """Return for each value of `sum(factor * term)` when it has it."""
        return total(self._cases(terms))

    def test(self, entry: int, bound: int, fixed: Mapping[int, int]) -> Expr:
        """Return when `v[entry] <= bound`, entries of `fixed` having these values."""
        if entry in fixed:
            return self.all if fixed[entry] <= bound else self.none
        parts = [(entry, 1), *self.loop.bounds.sums.get(entry, ())]
        known = sum(factor * fixed[part] for part, factor in parts if part in fixed)
        rest = [(f, term) for part, f in parts if part not in fixed for term in self.loop.terms.get(part, ())]
        return at_most(self._cases(rest), bound - known)

    def _cases(self, terms: Iterable[tuple[int, GuardedValue]]) -> list[Cases]:
        return [tuple((self._guarded(guard), factor * n) for guard, n in term) for factor, term in terms]

    def _guarded(self, guard: StateGuard) -> Expr:
        return conjunction(self.among(var, values) for var, values in guard)
