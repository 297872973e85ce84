"""Truth of which something may not be known, None (Kleene 1952)."""

from collections.abc import Iterable


def negated(truth: bool | None) -> bool | None:
    """Return the negation."""
    return None if truth is None else not truth


def every(truths: Iterable[bool | None]) -> bool | None:
    """Return the conjunction."""
    known = set(truths)
    return False if False in known else None if None in known else True


def some(truths: Iterable[bool | None]) -> bool | None:
    """Return the disjunction."""
    known = set(truths)
    return True if True in known else None if None in known else False
