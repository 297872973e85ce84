"""CTL on sets of states; path quantifiers range over fair runs (Emerson, Lei 1986)."""

from collections.abc import Callable
from dataclasses import field
from typing import assert_never

from exover.dataclass import dataclass
from exover.engines.bdd.backward_reachability import Ring
from exover.engines.bdd.fixpoints import Fixpoints
from exover.engines.bdd.manager import Set
from exover.loop.finite.predicates import StatePredicates
from exover.loop.finite.step_predicates import connected, moments
from exover.model.property import (
    TRUE,
    Atom,
    Broken,
    Conjunction,
    Disjunction,
    Formula,
    Happened,
    Negation,
    Next,
    Passed,
    SomeAlways,
    SomeNext,
    SomeUntil,
    Until,
)


@dataclass
class Ctl:
    """The states in which formulas are true; `way`: the rings of the runs from the start into given states, or None."""

    meaning: StatePredicates[Set]
    fixpoints: Fixpoints
    way: Callable[[Set], list[Ring] | None]
    _known: dict[Formula, Set] = field(default_factory=dict)

    def starts_with(self, formula: Formula) -> bool:
        """Return whether a formula is true at the start; EF is answered by reachability instead of a fixpoint."""
        match formula:
            case Negation(part):
                return not self.starts_with(part)
            case Conjunction(parts):
                return all(self.starts_with(part) for part in parts)
            case Disjunction(parts):
                return any(self.starts_with(part) for part in parts)
            case SomeUntil(left, right) if left == TRUE:
                return self.comes_to(right)
            case _:
                space = self.fixpoints.steps.space
                return bool(space.initial & self.true(formula) != space.none)

    def comes_to(self, formula: Formula) -> bool:
        """Return whether a formula is true in some moment of some fair run (EF over fair runs)."""
        states = self.true(formula)
        return self.way(states) is not None and self.way(states & self.fixpoints.fair) is not None

    def true(self, formula: Formula) -> Set:
        """Return the states of the universe in which a formula is true."""
        if formula not in self._known:
            self._known[formula] = self._true(formula) & self.fixpoints.steps.universe
        return self._known[formula]

    def _true(self, formula: Formula) -> Set:
        fixpoints = self.fixpoints
        match formula:
            case Atom() | Happened() | Passed() | Broken():
                return moments(self.meaning, formula)
            case Negation() | Conjunction() | Disjunction():
                return connected(self.meaning.space, formula, self.true)
            case SomeNext(part):
                return fixpoints.before(self.true(part) & fixpoints.fair)
            case SomeUntil(left, right):
                return fixpoints.until(self.true(left), self.true(right) & fixpoints.fair)
            case SomeAlways(part):
                return fixpoints.always(self.true(part))
            case Next() | Until():
                raise TypeError("a formula of CTL has no operator of LTL")
            case _:
                assert_never(formula)
