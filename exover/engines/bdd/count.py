"""The exact number of reachable states."""

from collections.abc import Collection
from heapq import heappop, heappush
from math import prod

from exover.engines.bdd.decomposition import reachable
from exover.engines.bdd.manager import Set
from exover.engines.bdd.space import Space
from exover.engines.bdd.steps import Stepper


def count_states(stepper: Stepper) -> int:
    """Return the number of reachable states of the loop: classes that tables and properties do not tell apart."""
    return prod(count(stepper.space, states, variables) for variables, states in reachable(stepper))


def count(space: Space, states: Set, variables: Collection[int]) -> int:
    """Return the number of value combinations of these variables in a set of states.

    Counts, from the root down, the assignments to the bits above a node that lead to it.
    """
    states = space.on(states, variables)
    levels = sorted(space.bdd.level_of_var(name) for var in variables for name in space.bits[var])
    place = {level: number for number, level in enumerate(levels)}
    ways: dict[Set, int] = {}
    queue: list[tuple[int, int, Set]] = []

    def lead(target: Set, at: int, number: int) -> None:
        """Add a number of paths that lead to a node; bits that are skipped on the way double it."""
        if target == space.none:
            return
        there = len(levels) if target == space.all else place[target.level]
        if target not in ways:
            ways[target] = 0
            heappush(queue, (there, len(ways), target))
        ways[target] += number << there - at

    lead(states, 0, 1)
    while queue:
        at, _, node = heappop(queue)
        if at == len(levels):
            return ways[node]
        name = space.bdd.var_at_level(levels[at])
        for value in (False, True):
            lead(space.bdd.let({name: value}, node), at + 1, ways[node])
    return 0
