"""The reachable states, computed separately for independent parts of the loop."""

from collections.abc import Collection

from exover.engines.bdd.manager import Set
from exover.engines.bdd.steps import Stepper, explore
from exover.loop.finite.builder import ClosedLoop
from exover.loop.finite.program import writes

Part = tuple[frozenset[int], list[int]]
"""Variables, and the numbers of the events that touch no others."""


def reachable(stepper: Stepper) -> list[tuple[frozenset[int], Set]]:
    """Return the reachable states as a product: for each part its variables and the set of their values.

    `happened` variables are left out. Each part is explored while the others stay in the initial state. That is exact
    if there are no assumptions and no component is unstable at the start of a step in a reachable state of a part; else
    the loop is explored as a whole, as one part.
    """
    space, found = stepper.space, []
    lasting = frozenset(n for n, variable in enumerate(stepper.loop.variables) if variable.key[0] != "happened")
    if stepper.allowed == space.all:
        for variables, events in parts(stepper.loop):
            reached = explore(stepper, events)
            if reached & stepper.spontaneous != space.none:
                break
            found.append((variables, space.on(reached, variables)))
        else:
            resting = lasting.difference(*(variables for variables, _ in found))
            return [*found, (resting, space.on(space.initial, resting))]
    return [(lasting, space.on(explore(stepper), lasting))]


def parts(loop: ClosedLoop) -> list[Part]:
    """Return the finest partition such that every event and every component touches variables of one part only.

    `happened` variables are left out.
    """
    touched = [_lasting(loop, loop.reads(event.program) | set(writes(event.program))) for event in loop.events]
    part_of = {var: {var} for group in touched for var in group}
    for group in (*touched, *(_lasting(loop, component.reads | component.writes) for component in loop.body)):
        joined: set[int] = set().union(*(part_of.get(var, {var}) for var in group))
        part_of.update(dict.fromkeys(joined, joined))
    found: dict[int, Part] = {}
    for number, group in enumerate(touched):
        if group:
            part = part_of[min(group)]
            found.setdefault(min(part), (frozenset(part), []))[1].append(number)
    return list(found.values())


def _lasting(loop: ClosedLoop, variables: Collection[int]) -> set[int]:
    return {var for var in variables if loop.variables[var].key[0] != "happened"}
