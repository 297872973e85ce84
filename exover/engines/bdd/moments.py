"""Formulas of one moment: conditions on its state, and what the step that led to it did."""

from collections.abc import Callable

from exover.engines.bdd.holdings import Conditions
from exover.engines.bdd.meaning import Meaning
from exover.engines.bdd.space import Set
from exover.model.property import Atom, Broken, Conjunction, Disjunction, Formula, Happened, Negation, Passed


def moments(meaning: Meaning, formula: Formula) -> Set:
    """Return the states of the loop in which a formula without temporal operators is true."""
    space = meaning.space
    match formula:
        case Atom(condition):
            return meaning.truth(condition)
        case Broken(rule, calm):
            return meaning.rule(rule, calm)
        case Happened() | Passed():
            number = space.loop.observed.index(formula)
            return space.is_value(space.loop.index["happened", number], 1)
        case Negation() | Conjunction() | Disjunction():
            return connected(space, formula, lambda part: moments(meaning, part))
        case _:
            raise TypeError("a formula of one moment has no temporal operator")


def connected(space: Conditions, formula: Negation | Conjunction | Disjunction, true: Callable[[Formula], Set]) -> Set:
    """Return the states in which a formula is true; `true`: those in which a part of it is."""
    match formula:
        case Negation(part):
            return ~true(part)
        case Conjunction(parts):
            found = space.all
            for part in parts:
                found &= true(part)
            return found
        case Disjunction(parts):
            found = space.none
            for part in parts:
                found |= true(part)
            return found
