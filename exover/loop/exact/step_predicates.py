"""Formulas of one moment, exactly: conditions on its state, and what the step that led to it did."""

from collections.abc import Callable
from functools import partial
from typing import TypeVar

from exover.loop.exact.condition_formulas import ConditionFormulas
from exover.model.property import Atom, Broken, Conjunction, Disjunction, Formula, Happened, Negation, Passed

T = TypeVar("T")
"""A formula of any kind."""


def moment(
    now: ConditionFormulas[T],
    once_stopped: ConditionFormulas[T],
    step: Callable[[Happened | Passed], T],
    formula: Formula,
) -> T:
    """Return the formula over a moment that is equivalent to a formula without temporal operators.

    `now`, `once_stopped`: make conditions on its state, the latter with stopping slots as idle; `step`: returns the
    condition that the step before the moment did something.
    """
    parts = partial(moment, now, once_stopped, step)
    match formula:
        case Atom(condition):
            return now.truth(condition)
        case Broken(rule, stopped):
            return (once_stopped if stopped else now).broken(rule)
        case Happened() | Passed():
            return step(formula)
        case Negation(part):
            return now.negation(parts(part))
        case Conjunction(members):
            return now.both(map(parts, members))
        case Disjunction(members):
            return now.either(map(parts, members))
        case _:
            raise TypeError("a formula of one moment has no temporal operator")
