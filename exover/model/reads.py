"""What a condition reads, by name: used for the rules in question, for wakeups and for cones of influence."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass  # that of exover has no order
from typing import Literal

from exover.model.expression import (
    And,
    Compare,
    Cond,
    Const,
    Count,
    Last,
    Level,
    Or,
    Past,
    Reading,
    Status,
    Used,
    atoms,
    leaves,
)
from exover.model.model import Effect, Forget, Model, Request, Rule, SetState


@dataclass(frozen=True, slots=True, order=True)
class Read:
    """One thing that a condition reads: whether a request is active or waiting, its past or its last outcome, the used
    amount or the level of a resource, or a reading.
    """

    kind: Literal["active", "waiting", "past", "last", "used", "level", "reading"]
    name: str


def reads(cond: Cond) -> frozenset[Read]:
    """Return everything that a condition reads, inside `where` too; parameters are not counted."""
    found: set[Read] = set()
    for atom in atoms(cond):
        match atom:
            case Status(phase, request, where):
                found.add(Read("waiting" if phase == "waiting" else "active", request))
                found |= reads(where) if where else frozenset()
            case Past(request, where):
                found.add(Read("past", request))
                found |= reads(where) if where else frozenset()
            case Last(request, _):
                found.add(Read("last", request))
            case Compare(_, left, right):
                for term in (*leaves(left), *leaves(right)):
                    match term:
                        case Used(name):
                            found.add(Read("used", name))
                        case Level(name):
                            found.add(Read("level", name))
                        case Reading(name):
                            found.add(Read("reading", name))
                        case Count(requests):
                            found |= {Read("active", request) for request in requests}
                        case _:
                            pass
    return frozenset(found)


def rule_reads(rule: Rule) -> frozenset[Read]:
    """Return what the F of a rule reads; a rule for each slot of a request also reads whether that is active."""
    own = frozenset({Read("active", rule.slot_of)}) if rule.slot_of else frozenset()
    return reads(rule.condition) | own


def changes(effects: tuple[Effect, ...]) -> frozenset[Read]:
    """Return what the effects of `on` clauses change."""
    found: set[Read] = set()
    for effect in effects:
        match effect:
            case SetState(state, _):
                found.add(Read("reading", state))
            case Forget(requests):
                found |= {Read("past", request) for request in requests}
    return frozenset(found)


def launching(request: Request) -> frozenset[Read]:
    """Return what launching the request changes; a rule whose F reads one of these is in question for it."""
    return (
        frozenset({Read("active", request.name)})
        | {Read("used", share.resource) for share in request.shares}
        | {Read("level", consumption.resource) for consumption in request.consumptions}
        | changes(request.on_launch)
    )


def users(model: Model, resource: str) -> tuple[str, ...]:
    """Return the requests that use a resource, in the order of the text."""
    return tuple(each.name for each in model.requests if any(share.resource == resource for share in each.shares))


def active_reads(model: Model, rules: Iterable[Rule]) -> set[str]:
    """Return the requests of which rules read whether they are active, or what they use of a resource."""
    read = {each for rule in rules for each in rule_reads(rule)}
    using = {name for each in read if each.kind == "used" for name in users(model, each.name)}
    return using | {each.name for each in read if each.kind == "active"}


def excess(cond: Cond) -> tuple[Count | Used, int] | None:
    """Return the count, or what is used of a resource, and the number above which it is iff the condition holds; None
    if the condition is of another form.
    """
    match cond:
        case Compare(">", (Count() | Used()) as counted, Const(int(most))):
            return counted, most
        case Compare(">=", (Count() | Used()) as counted, Const(int(least))):
            return counted, least - 1
        case _:
            return None


def needs(cond: Cond, model: Model) -> frozenset[str] | None:
    """Return requests of which at least one is active in each state where the condition holds; None if the form of the
    condition shows none.
    """
    match cond:
        case Status("waiting", _, _):
            return None
        case Status(_, request, _):
            return frozenset({request})
        case And():
            return min(all_needs(cond, model), key=len, default=None)
        case Or(parts):
            every = [needs(part, model) for part in parts]
            return frozenset().union(*(n for n in every if n is not None)) if None not in every else None
    match excess(cond):
        case Count(requests), most if most >= 0:
            return frozenset(requests)
        case Used(resource), most if most >= 0:
            return frozenset(users(model, resource))
        case _:
            return None


def all_needs(cond: Cond, model: Model) -> tuple[frozenset[str], ...]:
    """Return sets of requests: at least one of each set is active in each state where the condition holds."""
    parts = cond.parts if isinstance(cond, And) else (cond,)
    return tuple(needed for part in parts if (needed := needs(part, model)) is not None)


def rule_needs(rule: Rule, model: Model) -> tuple[frozenset[str], ...]:
    """Return sets of requests: at least one of each set is active in each state where the F of the rule holds."""
    own = (frozenset({rule.slot_of}),) if rule.slot_of else ()
    return own + all_needs(rule.condition, model)


class RulesByNeed:
    """Rules in order, found by the requests of which their F needs one active.

    `needed`: for each rule, sets of requests; its F is false unless at least one of each set is active.
    """

    def __init__(self, rules: Sequence[Rule], needed: Sequence[tuple[frozenset[str], ...]]) -> None:
        self._rules = rules
        self._needed = needed
        self._needing: dict[str | None, list[int]] = {None: []}
        """For each request, the places of the rules with it in the least of the sets; for None, those without sets."""
        for place, sets in enumerate(needed):
            for name in min(sets, key=len) if sets else (None,):
                self._needing.setdefault(name, []).append(place)

    def possible(self, active: set[str]) -> list[Rule]:
        """Return the rules in order, without those whose F is false because only these requests are active."""
        places = {place for name in (*active, None) for place in self._needing.get(name, ())}
        return [self._rules[at] for at in sorted(places) if not any(map(active.isdisjoint, self._needed[at]))]


def in_question(model: Model) -> dict[str, tuple[Rule, ...]]:
    """Return for each request the rules whose F reads something that its launch changes, in the order of the text."""
    naming: dict[Read, list[Rule]] = {}
    for rule in model.rules:
        for read in rule_reads(rule):
            naming.setdefault(read, []).append(rule)
    order = {id(rule): index for index, rule in enumerate(model.rules)}
    found = {}
    for request in model.requests:
        rules = {order[id(rule)]: rule for read in launching(request) for rule in naming.get(read, ())}
        found[request.name] = tuple(rules[index] for index in sorted(rules))
    return found
