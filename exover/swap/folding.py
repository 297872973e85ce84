"""Conditions without parts that constants decide."""

from exover.model.evaluate import OPERATORS
from exover.model.expression import FALSE, TRUE, And, Compare, Cond, Const, Count, ModelTerm, Not, Or, Sum


def folded(cond: Cond) -> Cond:
    """Return an equivalent condition without parts that constants decide (constant folding)."""
    match cond:
        case And(parts):
            left = [part for part in map(folded, parts) if part != TRUE]
            return FALSE if FALSE in left else left[0] if len(left) == 1 else And(tuple(left))
        case Or(parts):
            left = [part for part in map(folded, parts) if part != FALSE]
            return TRUE if TRUE in left else left[0] if len(left) == 1 else Or(tuple(left))
        case Not(part):
            inner = folded(part)
            return FALSE if inner == TRUE else TRUE if inner == FALSE else Not(inner)
        case Compare(operator, left_side, right_side):
            return _decided(operator, left_side, right_side, cond)
        case _:
            return cond


def _decided(operator: str, left: ModelTerm, right: ModelTerm, cond: Compare) -> Cond:
    mine, other = _constant(left), _constant(right)
    if mine is None or other is None:
        return cond
    return TRUE if OPERATORS[operator](mine, other) else FALSE


def _constant(term: ModelTerm) -> int | float | str | bool | None:
    match term:
        case Const(value):
            return value
        case Count(()):
            return 0
        case Sum(constant, ()):
            return constant
        case _:
            return None
