"""How many states are reachable, exactly."""

from collections.abc import Collection
from heapq import heappop, heappush

from exover.verify.bdd.space import Set, Space
from exover.verify.bdd.steps import Stepper, explore
from exover.verify.loop import ClosedLoop
from exover.verify.program import writes

Part = tuple[frozenset[int], list[int]]
"""Variables, and the numbers of the events that touch these and no others."""


def count_states(stepper: Stepper) -> int:
    """Return the number of reachable states, as far as tables and properties tell them apart.

    What the last step did is no part of a state. The number is the product of those of independent parts of the loop,
    each explored while the others rest in the initial state. That is right if nothing is assumed and in no reachable
    state of a part a step that begins in another does anything; else the loop is explored as a whole.
    """
    space, total = stepper.space, 1
    if stepper.allowed == space.all:
        for variables, events in parts(stepper.loop):
            reached = explore(stepper, events)
            if reached & stepper.restless != space.none:
                break
            total *= count(space, reached, variables)
        else:
            return total
    lasting = [n for n, variable in enumerate(stepper.loop.variables) if variable.key[0] != "happened"]
    return count(space, explore(stepper), lasting)


def parts(loop: ClosedLoop) -> list[Part]:
    """Return the least parts such that every event and every component of a pass touches variables of one alone."""
    touched = [_touched(loop, number) for number in range(len(loop.events))]
    part_of = {var: {var} for group in touched for var in group}
    for group in (*touched, *(component.reads | component.writes for component in loop.body)):
        joined: set[int] = set().union(*(part_of.get(var, {var}) for var in group))
        part_of.update(dict.fromkeys(joined, joined))
    found: dict[int, Part] = {}
    for number, group in enumerate(touched):
        if group:
            part = part_of[min(group)]
            found.setdefault(min(part), (frozenset(part), []))[1].append(number)
    return list(found.values())


def _touched(loop: ClosedLoop, number: int) -> set[int]:
    """Return the variables that an event reads or writes; what notes that it happened is no part of a state."""
    program = loop.events[number].program
    found = loop.reads(program) | set(writes(program))
    return {var for var in found if loop.variables[var].key[0] != "happened"}


def count(space: Space, states: Set, variables: Collection[int]) -> int:
    """Return how many values these variables have together in a set in which each has one of its values.

    From the root to the leaves: in how many ways the bits that stand before a node can lead to it.
    """
    others = [name for var, names in enumerate(space.bits) if var not in variables for name in names]
    states = space.bdd.exist(others, states)
    levels = sorted(space.bdd.level_of_var(name) for var in variables for name in space.bits[var])
    place = {level: number for number, level in enumerate(levels)}
    ways: dict[Set, int] = {}
    queue: list[tuple[int, int, Set]] = []

    def lead(target: Set, at: int, number: int) -> None:
        """Note that so many more ways lead to a node, past all bits from this place on that stand before it."""
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
