"""A static variable order in which variables that are used together are close."""

from exover.loop.finite.builder import ClosedLoop
from exover.loop.finite.program import switched, writes

ROUNDS = 100
"""The greatest number of rounds."""


def arrange(loop: ClosedLoop) -> list[int]:
    """Return the variables in an order with short spans of the variables that events and components touch.

    FORCE (Aloul, Markov, Sakallah 2003): each variable moves to the mean of the centres of its groups, round by round,
    as long as the total span shrinks.
    """
    groups = _groups(loop)
    order = list(range(len(loop.variables)))
    best, least = order, _span(groups, order)
    for _ in range(ROUNDS):
        place = {var: position for position, var in enumerate(order)}
        centres = [sum(place[var] for var in group) / len(group) for group in groups]
        pulls: dict[int, list[float]] = {var: [place[var]] for var in order}
        for group, centre in zip(groups, centres, strict=True):
            for var in group:
                pulls[var].append(centre)
        order = sorted(order, key=lambda var: (sum(pulls[var]) / len(pulls[var]), var))
        span = _span(groups, order)
        if span >= least:
            break
        best, least = order, span
    return best


def _groups(loop: ClosedLoop) -> list[frozenset[int]]:
    """Return the sets of variables that one event or component touches, and those of one slot or waiting place."""
    found = {component.reads | component.writes for component in loop.body}
    for event in loop.events:
        found.add(frozenset(switched(event.program)) | frozenset(writes(event.program)))
    owned: dict[tuple[str, object], set[int]] = {}
    for number, variable in enumerate(loop.variables):
        kind = {"class": "phase", "order": "phase", "cell": "place", "standing": "place", "fallen": "place"}
        name = str(variable.key[0])
        owned.setdefault((kind.get(name, name), variable.key[1]), set()).add(number)
    found |= {frozenset(group) for group in owned.values()}
    return sorted((group for group in found if len(group) > 1), key=sorted)


def _span(groups: list[frozenset[int]], order: list[int]) -> int:
    place = {var: position for position, var in enumerate(order)}
    return sum(max(place[v] for v in group) - min(place[v] for v in group) for group in groups)
