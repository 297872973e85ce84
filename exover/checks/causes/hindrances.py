"""What the reason of an obstacle reads, which requests hinder by being active, and what a request changes of it."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

from exover.model.decision import BUSY, Reason
from exover.model.expression import And, Compare, Cond, Count, Not, Or, Status, Used, operands
from exover.model.model import Effect, Forget, Model, Request, SetState
from exover.model.reads import Read, reads, rule_reads, users
from exover.model.state import State


def reason_reads(model: Model, state: State, request: Request, reason: Reason) -> Sequence[Read]:
    """Return what the guard, rule or consumption of a reason reads, without idle requests that could hinder.

    Of a resource, who uses it; of an idle request whose way is being cleared, that it waits; if the reason is that the
    request is busy, whether it is active or waits.
    """
    read: dict[Read, None] = {}
    if reason == BUSY:
        read[Read("active" if state.active([request.name]) else "waiting", request.name)] = None
    idle = {name for name in hindering(model, request, reason) if not state.active([name])}
    for guard in request.guards:
        if guard.name == reason.rule:
            in_the_way = idle - set(made_by(model, guard.condition, truth=True))
            told = (each for each in reads(guard.condition) if each.kind != "active" or each.name not in in_the_way)
            read |= dict.fromkeys(sorted(told))
    for each in (each for rule in model.rules_named(reason.rule) for each in sorted(rule_reads(rule))):
        holders = [Read("active", name) for name in users(model, each.name)] if each.kind == "used" else [each]
        for held in holders:
            if held.kind != "active" or held.name not in idle:
                read[held] = None
            elif held.name != request.name and (place := state.places[held.name]) and place.clearing:
                read[Read("waiting", held.name)] = None
    if any(clause.resource == reason.rule for clause in request.consumptions):
        read[Read("level", reason.rule)] = None
    return tuple(read)


def hindering(model: Model, request: Request, reason: Reason) -> Iterator[str]:
    """Yield the requests that may hinder by being active: those that have to end before a guard or rule lets the
    request pass, and the request itself if it is busy.
    """
    if reason == BUSY:
        yield request.name
    for guard in request.guards:
        if guard.name == reason.rule:
            yield from made_by(model, guard.condition, truth=False)
    for rule in model.rules_named(reason.rule):
        yield from made_by(model, rule.condition, truth=True)
        yield from (rule.slot_of,) if rule.slot_of else ()


def made_by(model: Model, condition: Cond, truth: bool) -> Iterator[str]:
    """Yield the requests that may make a condition true, or else false, by being active."""
    match condition:
        case Status("active" | "running" | "stopping", request) if truth:
            yield request
        case Not(part):
            yield from made_by(model, part, not truth)
        case And(parts) | Or(parts):
            for part in parts:
                yield from made_by(model, part, truth)
        case Compare():
            for term in operands(condition):
                match term:
                    case Count(requests):
                        yield from requests
                    case Used(resource):
                        yield from users(model, resource)
        case _:
            pass


def touches(request: Request, read: Collection[Read], levels: Collection[str]) -> bool:
    """Return whether something that is read is about the request itself, or is one of these levels."""
    if any(each.name == request.name and each.kind in ("active", "waiting", "past", "last") for each in read):
        return True
    return any(each.kind == "level" and each.name in levels for each in read)


def settings(model: Model, request: Request, read: Collection[Read]) -> list[Effect]:
    """Return the effects of a request that set something that is read, with the latches that it resets."""
    named = {each.name for each in read if each.kind in ("reading", "past")}
    resets = [SetState(latch.name, False) for latch in model.latches if request.name in latch.resets]
    return [each for each in (*request.effects, *resets) if named.intersection(_names(each))]


def _names(effect: Effect) -> tuple[str, ...]:
    return (effect.state,) if isinstance(effect, SetState) else effect.requests


def changed(state: State, effect: Effect) -> State:
    """Return the state after an effect."""
    match effect:
        case SetState(name, value):
            return state.with_reading(name, value)
        case Forget(requests):
            return replace(state, past={**state.past, **dict.fromkeys(requests)})
