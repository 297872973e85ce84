"""Three-valued logic (Kleene 1952): True, False, and None for unknown."""

from collections.abc import Callable, Iterable

from exover.model.expression import And, Cond, Not, Or


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


def truth(cond: Cond, known: Callable[[Cond], bool | None]) -> bool | None:
    """Return the truth of a condition. `known` says that of a part, or None: then its own parts decide, if any.

    What stands inside a `where` is no part.
    """
    found = known(cond)
    if found is not None:
        return found
    match cond:
        case Not(part):
            return negated(truth(part, known))
        case And(parts):
            return every(truth(part, known) for part in parts)
        case Or(parts):
            return some(truth(part, known) for part in parts)
        case _:
            return None
