"""Substitution of constants for `self.p`, the parameters of the request whose clause a condition is."""

from typing import assert_never

from exover.model.evaluate import OPERATORS
from exover.model.expression import (
    FALSE,
    TRUE,
    And,
    Compare,
    Cond,
    Const,
    Last,
    ModelTerm,
    Not,
    Or,
    Own,
    Past,
    Status,
    Sum,
)


def substitute(cond: Cond, values: dict[str, Const]) -> Cond:
    """Return the condition with `values` substituted for every `self.p`; comparisons of two constants are folded."""
    match cond:
        case Compare(op, left, right):
            left, right = _replace(left, values), _replace(right, values)
            if isinstance(left, Const) and isinstance(right, Const):
                return TRUE if OPERATORS[op](left.value, right.value) else FALSE
            return Compare(op, left, right)
        case Not(part):
            return Not(substitute(part, values))
        case And(parts):
            return And(tuple(substitute(part, values) for part in parts))
        case Or(parts):
            return Or(tuple(substitute(part, values) for part in parts))
        case Status() | Past() | Last():
            return cond
        case _:
            assert_never(cond)


def _replace(term: ModelTerm, values: dict[str, Const]) -> ModelTerm:
    match term:
        case Own(name):
            return values[name]
        case Sum(constant, terms):
            return Sum(constant, tuple((factor, _replace(part, values)) for factor, part in terms))
        case _:
            return term
