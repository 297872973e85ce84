"""Three-valued logic (Kleene 1952): True, False, and None for unknown."""

from collections.abc import Iterable


def negated(truth: bool | None) -> bool | None:
    """Return the negation; that of None is None."""
    return None if truth is None else not truth


def every(truths: Iterable[bool | None]) -> bool | None:
    """Return the conjunction: False if one is False, else None if one is None, else True."""
    known = set(truths)
    return False if False in known else None if None in known else True


def some(truths: Iterable[bool | None]) -> bool | None:
    """Return the disjunction: True if one is True, else None if one is None, else False."""
    known = set(truths)
    return True if True in known else None if None in known else False
