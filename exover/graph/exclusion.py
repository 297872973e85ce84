"""Mutual exclusion: pairs of requests that a rule keeps from being active together; members of limits and resources."""

from collections.abc import Iterator
from itertools import combinations, product
from typing import NamedTuple

from exover.dataclass import dataclass
from exover.model.expression import And, Cond, Count, Or, Status, Used
from exover.model.index import ModelIndex
from exover.model.model import Model, Request, Rule
from exover.model.reads import all_needs, excess
from exover.ocrd.conflicts import pair


class Exclusion(NamedTuple):
    """Two requests, or one with itself; `sometimes`: only for some arguments, or in some states."""

    first: str
    second: str
    sometimes: bool


@dataclass(frozen=True, slots=True)
class Member:
    """A request with its share of the capacity of a limit or resource: the least and the most, over its arguments."""

    request: str
    least: int
    most: int
    capacity: int


def members(rule: Rule, model: Model) -> tuple[Member, ...]:
    """Return the members of a limit or of a renewable resource, in the order of the text; of another rule none."""
    return _counted(rule.condition, model) if rule.kind in ("limit", "resource") else ()


def _counted(cond: Cond, model: Model) -> tuple[Member, ...]:
    """Return the requests that a condition counts, or whose shares it adds up, if it is that these are too many."""
    match excess(cond):
        case Count(requests), most:
            return tuple(Member(name, 1, 1, most) for name in requests)
        case Used(resource), most:
            users = (_member(request, resource, most) for request in model.requests)
            return tuple(user for user in users if user.most)
        case _:
            return ()


def _member(request: Request, resource: str, capacity: int) -> Member:
    shares = [share for share in request.shares if share.resource == resource]
    always = sum(share.amount for share in shares if share.when is None)
    return Member(request.name, always, sum(share.amount for share in shares), capacity)


def exclusions(rule: Rule, model: Model) -> Iterator[Exclusion]:
    """Yield the pairs that a rule keeps apart, each in the order of the text, some perhaps twice."""
    if both := pair(rule):
        yield Exclusion(*both, sometimes=False)
    elif not rule.slot_of and (found := _counted(rule.condition, model)):
        yield from _exceeding(found, model)
    else:
        own = (Status("active", rule.slot_of),) if rule.slot_of else ()
        order = ModelIndex(model).request
        for first, second in _together(And((*own, rule.condition)), model):
            if first != second or model.request[first].instances > 1:
                one, other = sorted((first, second), key=order.__getitem__)
                yield Exclusion(one, other, sometimes=True)


def _exceeding(found: tuple[Member, ...], model: Model) -> Iterator[Exclusion]:
    """Yield the pairs of members that together exceed the capacity."""
    several = ((one, one) for one in found if model.request[one.request].instances > 1)
    for one, other in (*several, *combinations(found, 2)):
        if one.most + other.most > one.capacity:
            yield Exclusion(one.request, other.request, one.least + other.least <= one.capacity)


def _together(cond: Cond, model: Model) -> Iterator[tuple[str, str]]:
    """Yield the pairs of requests that, active together, may make a condition true."""
    match cond:
        case Or(parts):
            for part in parts:
                yield from _together(part, model)
        case And(parts):
            for one, other in combinations(all_needs(cond, model), 2):
                yield from product(sorted(one), sorted(other))
            for part in parts:
                yield from _together(part, model)
        case _:
            yield from ((each.first, each.second) for each in _exceeding(_counted(cond, model), model))
