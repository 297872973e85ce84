"""CTL on explicit sets of moments; the path quantifiers range over fair runs (Emerson and Lei, 1987)."""

from typing import assert_never

from exover.model.property import (
    Atom,
    Conjunction,
    Disjunction,
    Formula,
    Happened,
    Negation,
    Next,
    SomeAlways,
    SomeNext,
    SomeUntil,
    Until,
    some_finally,
)
from tests.support.moments import Moments


def holds(of: Moments, formula: Formula) -> bool:
    """Return whether a formula of CTL is true at the start."""
    return 0 in satisfying(of, formula)


def can_be(of: Moments, premise: Formula) -> bool:
    """Return whether a premise is true in some moment of some run."""
    return holds(of, some_finally(premise))


def fair(of: Moments) -> set[int]:
    """Return the moments that a run goes on from for ever, fairly."""
    return _always(of, of.everything)


def satisfying(of: Moments, formula: Formula) -> set[int]:
    """Return the moments in which a formula of CTL is true."""
    match formula:
        case Atom() | Happened():
            return of.true(formula)
        case Negation(part):
            return of.everything - satisfying(of, part)
        case Conjunction(parts):
            return of.everything.intersection(*(satisfying(of, part) for part in parts))
        case Disjunction(parts):
            return set().union(*(satisfying(of, part) for part in parts))
        case SomeNext(part):
            return _before(of, satisfying(of, part) & fair(of))
        case SomeUntil(left, right):
            return _until(of, satisfying(of, left), satisfying(of, right) & fair(of))
        case SomeAlways(part):
            return _always(of, satisfying(of, part))
        case Next() | Until():
            raise AssertionError("a formula of CTL has no operator of LTL")
        case _:
            assert_never(formula)


def _before(of: Moments, goal: set[int]) -> set[int]:
    return {source for target in goal for source in of.before[target]}


def _until(of: Moments, left: set[int], right: set[int]) -> set[int]:
    found, queue = set(right), list(right)
    while queue:
        for source in of.before[queue.pop()]:
            if source in left and source not in found:
                found.add(source)
                queue.append(source)
    return found


def _always(of: Moments, part: set[int]) -> set[int]:
    """Return the moments from which a fair run stays in `part`: the greatest Z in it, each of whose moments has a
    next one from which every constraint is met again within Z."""
    found = set(part)
    while True:
        smaller = set(found)
        for constraint in of.constraints or [of.everything]:
            smaller &= _before(of, _until(of, found, found & constraint))
        if smaller == found:
            return found
        found = smaller
