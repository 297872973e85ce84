"""Concrete runs along rings of states that were found backwards: as few steps as possible."""

from collections.abc import Sequence

from exover.model.trace import Trace
from exover.verify.bdd.backwards import Ring, Way
from exover.verify.bdd.space import Set
from exover.verify.bdd.walk import Ends, Spurious, Walker


def follow(walker: Walker, rings: Sequence[Ring], last: Set, ends: Ends | None = None) -> Trace:
    """Return the run that goes on inwards through the rings, of which the goal is the first.

    If that has ways, a step along one of them, into `last` and as `ends` says, is the last. Raises `Spurious` if no
    concrete run does so.
    """
    for inner, ring in zip(reversed(rings[:-1]), reversed(rings[1:]), strict=True):
        _along(walker, ring.ways, inner.states, None)
    if rings[0].ways:
        _along(walker, rings[0].ways, last, ends)
    return walker.trace()


def _along(walker: Walker, ways: Sequence[Way], goal: Set, ends: Ends | None) -> None:
    """Take a step along one of the ways that are open."""
    none = walker.stepper.space.none
    if not any(walker.held & states != none and walker.step(number, goal, ends) for number, states in ways):
        raise Spurious("no concrete run was found that follows the loop")
