"""Formulas of one moment: conditions on its state, and what the step that led to it did."""

from collections.abc import Callable

from exover.loop.finite.predicates import StatePredicates
from exover.loop.finite.state_sets import S, StateSets
from exover.model.property import Atom, Broken, Conjunction, Disjunction, Formula, Happened, Negation, Passed


def moments(predicates: StatePredicates[S], formula: Formula) -> S:
    """Return the states of the loop in which a formula without temporal operators is true."""
    space = predicates.space
    match formula:
        case Atom(condition):
            return predicates.truth(condition)
        case Broken(rule, once_stopped):
            return predicates.rule(rule, once_stopped)
        case Happened() | Passed():
            return space.is_value(space.loop.history[formula], 1)
        case Negation() | Conjunction() | Disjunction():
            return connected(space, formula, lambda part: moments(predicates, part))
        case _:
            raise TypeError("a formula of one moment has no temporal operator")


def connected(space: StateSets[S], formula: Negation | Conjunction | Disjunction, true: Callable[[Formula], S]) -> S:
    """Return the states in which a formula is true, given the states in which its parts are `true`."""
    match formula:
        case Negation(part):
            return space.complement(true(part))
        case Conjunction(parts):
            return space.conjunction(map(true, parts))
        case Disjunction(parts):
            return space.disjunction(map(true, parts))
