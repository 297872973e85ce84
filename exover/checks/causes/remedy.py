"""Advice for a rule that a step breaks and no remedy restores: the kill that would have restored it."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from itertools import combinations

from exover.model.expression import And, Compare, Cond, Count, Or, Status
from exover.model.kleene import truth
from exover.model.model import Kill, Model, Rule
from exover.model.ranges import Ranges
from exover.model.reads import active_reads, reads
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.wording import remedy_text

MANY = 10
"""The greatest number of running requests of which each set is tried."""


def advice(reference: Reference, state: State, name: str) -> str:
    """Return, in words, the remedies that would restore the rule wherever it is broken; or if the form of its condition
    shows none, those that would in this state, in which it is.
    """
    rules = reference.model.rules_named(name)
    requests, remedies = _killable(reference.model, name), rules[0].remedies
    known = {request for remedy in remedies if isinstance(remedy, Kill) for request in remedy.requests}
    if _ends(reference.model, rules, requests):
        return f"write {_by(rules[0], _least(reference.model, rules, requests, known))}"
    for killed in _kills(state, requests, known):
        if not _broken(reference, state.idle(state.running(killed)), name):
            return f"{_by(rules[0], killed)} would restore it there"
    return "no kill would: let its condition name `active(…)` of what can be ended, or take the rule out"


def _kills(state: State, requests: Sequence[str], known: Collection[str]) -> Iterator[tuple[str, ...]]:
    """Yield the kills of requests to try in a state: with those that are killed anyway, then any; few requests first.

    Where more than `MANY` of them run: one more, or all.
    """
    running = [request for request in requests if state.running((request,))]
    sizes = range(1, len(running) + 1) if len(running) <= MANY else (1, len(running))
    some = [set(each) for size in sizes for each in combinations(running, size)]
    for more in (*(each | set(known) for each in some), *some):
        yield tuple(request for request in requests if request in more)


def _by(rule: Rule, killed: Sequence[str]) -> str:
    """Return the remedies of a rule and the kill; the kill alone if it stands for them."""
    kept = () if _stands_for_all(rule, killed) else rule.remedies
    return f"`by {' or '.join(map(remedy_text, (*kept, Kill(tuple(killed)))))}`"


def _stands_for_all(rule: Rule, killed: Collection[str]) -> bool:
    """Return whether all remedies of a rule kill some of these requests, and none restores it while another of them is
    active: each of them alone breaks the rule.
    """
    if not all(isinstance(each, Kill) and set(each.requests) <= set(killed) for each in rule.remedies):
        return False
    parts = rule.condition.parts if isinstance(rule.condition, And) else (rule.condition,)
    match [each for each in parts if any(read.kind in ("active", "used") for read in reads(each))]:
        case [Or(any_of)]:
            return set(any_of) >= {Status("active", each) for each in killed}
        case _:
            return False


def _least(model: Model, rules: Sequence[Rule], requests: Sequence[str], known: Collection[str]) -> Sequence[str]:
    """Return what is left of the requests when those that need not end are taken out, the last first, none `known`."""
    for each in reversed(requests):
        others = [other for other in requests if other != each]
        requests = others if each not in known and _ends(model, rules, others) else requests
    return requests


def _ends(model: Model, rules: Sequence[Rule], idle: Collection[str]) -> bool:
    """Return whether the conditions of rules are false whatever else holds, given that these requests are idle."""
    sharing = tuple(replace(each, shares=()) if each.name in idle else each for each in model.requests)
    left = Ranges(replace(model, requests=sharing))
    return all(truth(rule.condition, lambda part: _known(left, part, idle)) is False for rule in rules)


def _known(ranges: Ranges, condition: Cond, idle: Collection[str]) -> bool | None:
    match condition:
        case Status("active" | "running" | "stopping", request) if request in idle:
            return False
        case Compare(operator, Count(requests), right):
            counted = Count(tuple(each for each in requests if each not in idle))
            return next((each.truth for each in ranges.decided(Compare(operator, counted, right))), None)
        case Compare():
            return next((each.truth for each in ranges.decided(condition)), None)
        case _:
            return None


def _killable(model: Model, name: str) -> list[str]:
    """Return the requests that a kill of the rule may name: it reads their activity, or a resource that they use."""
    read = active_reads(model, model.rules_named(name))
    return [request.name for request in model.requests if request.name in read]


def _broken(reference: Reference, state: State, name: str) -> bool:
    instances = (each for rule in reference.model.rules_named(name) for each in reference.instances(state, rule))
    return any(reference.true(state, each) for each in instances)
