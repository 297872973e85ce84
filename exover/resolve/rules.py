"""Resolves declarations outside modules: mutexes, limits, `forbid`, launch rules, resources and latches."""

from itertools import combinations

from exover.diagnostics import quote
from exover.model.expression import Compare, Const, Count, Used
from exover.model.model import Kill, Latch, Launch, Resource, Rule, Wait
from exover.model.types import Value as ModelValue
from exover.model.wording import counted
from exover.resolve.draft import Draft
from exover.resolve.idle import note_fixed, note_limit, note_mutex
from exover.resolve.names import ListedRequest, Signature, entries, find_request, instances_of, requests
from exover.resolve.scope import FORBID, LATCH, LAUNCH
from exover.resolve.statuses import together
from exover.resolve.values import count, value
from exover.syntax import tree


def add_mutex(draft: Draft, node: tree.Mutex) -> None:
    """Add one rule for each pair of the list."""
    name = draft.label("", "mutex", node.label, node.span)
    names = tuple(entry.request for entry in entries(draft.names, node.requests, draft.mistakes))
    note_mutex(draft.mistakes, names, node.requests[0].span)
    remedies = draft.remedies(node.remedies, frozenset(names))
    if not draft.has_room(len(names) * (len(names) - 1) // 2, node.span):
        return
    where = draft.where(node.span)
    for first, second in combinations(names, 2):
        pair = together(first, second)
        draft.rules.append(Rule(name, "mutex", pair, remedies, node.because, draft.place(), location=where))


def add_over(draft: Draft, node: tree.MutexOver) -> None:
    """Add one rule for each pair of a winner and a loser."""
    name = draft.label("", "mutex", node.label, node.span)
    winners = requests(draft.names, node.winners, draft.mistakes)
    losers = entries(draft.names, node.losers, draft.mistakes)
    _no_self(draft, winners, losers)
    if not draft.has_room(len(winners) * len(losers), node.span):
        return
    where = draft.where(node.span)
    for winner in winners:
        for loser in losers:
            kill = Kill((loser.request,))
            remedies = (kill, Wait()) if node.else_wait else (kill,)
            pair = together(winner, loser.request)
            draft.rules.append(Rule(name, "over", pair, remedies, node.because, draft.place(), location=where))


def _no_self(draft: Draft, winners: tuple[str, ...], losers: tuple[ListedRequest, ...]) -> None:
    known = frozenset(winners)
    for loser in losers:
        if loser.request in known:
            draft.mistakes.add("E410", f"`over` pairs {quote(loser.request)} with itself", loser.span)


def add_limit(draft: Draft, node: tree.Limit) -> None:
    """Add the rule that at most `node.most` slots of the listed requests are active."""
    name = draft.label("", "limit", node.label, node.span)
    most = count(node.most, draft.mistakes)
    names = tuple(entry.request for entry in entries(draft.names, node.requests, draft.mistakes))
    remedies = draft.remedies(node.remedies, frozenset(names))
    place = draft.place()
    if most is not None:
        slots = sum(instances_of(draft.names, name) for name in names)
        note_limit(draft.mistakes, most, slots, node.most.span)
    if most is not None and draft.has_room(1, node.span):
        condition = Compare(">", Count(names), Const(most))
        where = draft.where(node.span)
        draft.rules.append(Rule(name, "limit", condition, remedies, node.because, place, location=where))


def add_forbid(draft: Draft, node: tree.Forbid) -> None:
    """Add the rule of a `forbid`."""
    name = draft.label("", "forbid", node.label, node.span)
    found = draft.meaning(FORBID, node.condition)
    reads = found.reads if found else frozenset()
    active = frozenset(request for kind, request in reads if kind == "active") if found else None
    used = frozenset(resource for kind, resource in reads if kind == "used")
    remedies = draft.remedies(node.remedies, active, used)
    place = draft.place()
    if found:
        note_fixed(draft.mistakes, found.cond, False, "it forbids nothing", node.condition.span)
    if found and draft.has_room(1, node.span):
        where = draft.where(node.span)
        draft.rules.append(Rule(name, "forbid", found.cond, remedies, node.because, place, location=where))


def add_resource(draft: Draft, node: tree.Resource) -> None:
    """Add the resource and, if it is renewable, its rule."""
    name = node.name.text
    if draft.names.resources[name].span != node.name.span:
        return  # a second resource of the name, a mistake that `declare` notes
    draft.claim(name, node.name.span)
    capacity = count(node.capacity, draft.mistakes)
    initial = capacity if node.initial is None else count(node.initial, draft.mistakes)
    remedies = draft.remedies(node.remedies, None if node.consumable else frozenset(), frozenset({name}))
    _check_consumable(draft, node)
    if capacity is None or initial is None:
        return
    if initial > capacity and node.initial is not None:
        message = f"{quote(node.initial.text)} is not in 0 .. {capacity}"
        draft.mistakes.add("E307", message, node.initial.span)
    draft.totals[name] += capacity
    where = draft.where(node.name.span)
    draft.resources.append(Resource(name, capacity, node.consumable, initial, remedies, node.because, where))
    if not node.consumable and draft.has_room(1, node.span):
        condition = Compare(">", Used(name), Const(capacity))
        where = draft.where(node.span)
        draft.rules.append(Rule(name, "resource", condition, remedies, node.because, draft.place(), location=where))


def _check_consumable(draft: Draft, node: tree.Resource) -> None:
    for remedy in node.remedies:
        if node.consumable and isinstance(remedy, tree.Kill):
            message = f"no kill gives back what is consumed of {quote(node.name.text)}"
            draft.mistakes.add("E407", message, remedy.span, hint="its remedies are `reject` and `wait`")


def add_launch(draft: Draft, node: tree.Launch) -> None:
    """Add the launch rule."""
    name = draft.label("", "launch", node.label, node.span)
    request = find_request(draft.names, node.request, draft.mistakes)
    args = _arguments(draft, node, request) if request else None
    found = draft.meaning(LAUNCH, node.condition)
    if found:
        note_fixed(draft.mistakes, found.cond, False, "nothing is ever launched", node.condition.span)
    if request and found and args is not None:
        where = draft.where(node.span)
        draft.launches.append(Launch(name, request.name, args, found.cond, node.because, where))


def _arguments(draft: Draft, node: tree.Launch, request: Signature) -> tuple[ModelValue, ...] | None:
    """Return the arguments, converted to the types of the parameters, or None with a mistake noted."""
    params, name, count = request.params, request.name, len(request.params)
    if len(node.arguments) != count:
        message = f"{quote(name)} takes {counted(count, 'argument')}, not {len(node.arguments)}"
        hint = (
            f"give a value for each parameter: {quote(', '.join(params))}" if params else f"write {quote(f'{name}()')}"
        )
        draft.mistakes.add("E311", message, node.request.span, hint=hint)
        return None
    found = [
        value(given, kind, draft.names.constants, draft.mistakes, f"for {quote(parameter)} of {quote(name)}")
        for given, (parameter, kind) in zip(node.arguments, params.items(), strict=True)
    ]
    right = tuple(argument for argument in found if argument is not None)
    return right if len(right) == len(found) else None


def add_latch(draft: Draft, node: tree.Latch) -> None:
    """Add the latch, which may read the latches before it."""
    before = frozenset(latch.name for latch in draft.latches)
    found = draft.meaning(LATCH, node.condition, latches=before)
    resets = requests(draft.names, node.until, draft.mistakes)
    if found:
        where = draft.where(node.name.span)
        draft.latches.append(Latch(node.name.text, found.cond, resets, where))
