"""Numbers and Booleans that are Python values or terms of Z3: operations on Python values are computed at once."""

from fractions import Fraction
from typing import Any


def z3() -> Any:
    """Return Z3, imported when it is first needed."""
    import z3

    return z3


def lifted(value: Any) -> Any:
    """Return a value as a term of Z3."""
    make = {bool: z3().BoolVal, int: z3().IntVal, Fraction: z3().RealVal}.get(type(value))
    return value if make is None else make(value)


def plain(term: Any) -> Any:
    """Return a Boolean constant of Z3 as Python's, and any other term as it is."""
    return True if z3().is_true(term) else False if z3().is_false(term) else term


def conj(*parts: Any) -> Any:
    """Return the conjunction."""
    left = [part for part in parts if part is not True]
    return False if any(part is False for part in left) else z3().And(*left) if left else True


def disj(*parts: Any) -> Any:
    """Return the disjunction."""
    left = [part for part in parts if part is not False]
    return True if any(part is True for part in left) else z3().Or(*left) if left else False


def neg(part: Any) -> Any:
    """Return the negation."""
    return not part if isinstance(part, bool) else z3().Not(part)


def ite(cond: Any, yes: Any, no: Any) -> Any:
    """Return `yes` where the condition holds, else `no`."""
    if isinstance(cond, bool):
        return yes if cond else no
    if isinstance(yes, bool):
        return disj(cond, no) if yes else conj(neg(cond), no)
    left, right = lifted(yes), lifted(no)
    return yes if left.eq(right) else z3().If(cond, left, right)
