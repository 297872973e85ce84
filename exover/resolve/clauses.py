"""The clauses of requests, in a module or a `context`: guards, rules made from clauses, resources and effects."""

from dataclasses import replace
from typing import Literal, assert_never

from exover.diagnostics import quote
from exover.model.expression import Compare, Cond, Const, Count, Past
from exover.model.model import (
    Consumption,
    Forget,
    Guard,
    Kill,
    KillSlot,
    Remedy,
    Rule,
    SetState,
    Share,
    Wait,
    interruption,
)
from exover.resolve.draft import Draft
from exover.resolve.idle import note_amount, note_fixed
from exover.resolve.names import (
    ListedRequest,
    QuantityName,
    Signature,
    entries,
    find_module,
    find_resource,
    instances_of,
    requests,
)
from exover.resolve.scope import AMOUNT, FAIL, GUARD
from exover.resolve.statuses import together
from exover.resolve.values import count, value
from exover.source import Span
from exover.syntax import tree

GuardClause = tree.Check | tree.WaitUntil | tree.SettleUntil
AmountClause = tree.Uses | tree.Consumes | tree.Produces
_INSTEAD = {
    "state": "a state gets a value: `on ok set {} = VALUE;`",
    "poster": "posters are observed: nothing forgets them",
    "latch": "a latch is reset by the requests behind its `until`",
}
"""What there is instead of `forget`, by the kind of what it names."""


def add_clauses(draft: Draft, owner: Signature, clauses: tuple[tree.Clause, ...]) -> None:
    """Add the clauses of request `owner` to the draft, in order."""
    for clause in clauses:
        match clause:
            case tree.Check() | tree.WaitUntil() | tree.SettleUntil():
                _guard(draft, owner, clause)
            case tree.FailWhen():
                _fail(draft, owner, clause)
            case tree.After():
                _after(draft, owner, clause)
            case tree.Before():
                _before(draft, owner, clause)
            case tree.Interrupts():
                _interrupts(draft, owner, clause)
            case tree.Uses():
                _uses(draft, owner, clause)
            case tree.Consumes() | tree.Produces():
                _consumable(draft, owner, clause)
            case tree.OnSet():
                _set(draft, owner, clause)
            case tree.OnForget(occasion):
                named = tuple(each for each in clause.requests if not _is_value(draft, owner, each))
                draft.parts[owner.name].affect(occasion, Forget(requests(draft.names, named, draft.mistakes)))
            case _:
                assert_never(clause)


# ---- guards ----


def _guard(draft: Draft, owner: Signature, clause: GuardClause) -> None:
    kind: Literal["check", "wait", "settle"]
    match clause:
        case tree.Check():
            kind = "check"
        case tree.WaitUntil():
            kind = "wait"
        case tree.SettleUntil():
            kind = "settle"
        case _:
            assert_never(clause)
    name = draft.label(f"{owner.name}.", kind, clause.label, clause.span)
    found = draft.meaning(GUARD, clause.condition, owner)
    place = draft.place()
    if found:
        note_fixed(draft.mistakes, found.cond, True, f"`{kind}` holds up nobody", clause.condition.span)
    if found and draft.has_room(1, clause.span):
        where = draft.where(clause.span)
        draft.parts[owner.name].guards.append(Guard(kind, name, found.cond, clause.because, place, where))


def _after(draft: Draft, owner: Signature, clause: tree.After) -> None:
    for entry in _others(draft, owner, clause.requests, "after"):
        name = f"{owner.name}.after.{entry.request}"
        _order(draft, owner.name, name, Past(entry.request), clause, entry.span)


def _before(draft: Draft, owner: Signature, clause: tree.Before) -> None:
    for entry in _others(draft, owner, clause.requests, "before"):
        name = f"{owner.name}.before.{entry.request}"
        _order(draft, entry.request, name, Past(owner.name), clause, entry.span)


def _order(draft: Draft, guarded: str, name: str, past: Past, clause: tree.After | tree.Before, span: Span) -> None:
    """Add to the request `guarded` a check that `past` holds."""
    draft.claim(name, span, labelled=False)
    guard = Guard("check", name, past, clause.because, draft.place(), draft.where(clause.span))
    if draft.has_room(1, clause.span):
        draft.parts[guarded].guards.append(guard)


def _others(draft: Draft, owner: Signature, nodes: tuple[tree.Listed, ...], word: str) -> tuple[ListedRequest, ...]:
    """Return the requests of a list without the owner, which is a mistake in it."""
    found = entries(draft.names, nodes, draft.mistakes)
    for entry in found:
        if entry.request == owner.name:
            draft.mistakes.add("E410", f"`{word}` pairs {quote(owner.name)} with itself", entry.span)
    return tuple(entry for entry in found if entry.request != owner.name)


# ---- rules made from clauses ----


def _fail(draft: Draft, owner: Signature, clause: tree.FailWhen) -> None:
    name = draft.label(f"{owner.name}.", "fail", clause.label, clause.span)
    found = draft.meaning(FAIL, clause.condition, owner)
    place = draft.place()
    if found:
        note_fixed(draft.mistakes, found.cond, False, "the request never fails for it", clause.condition.span)
    if found and draft.has_room(1, clause.span):
        remedies = _or_wait(KillSlot(), clause.else_wait)
        where = draft.where(clause.span)
        draft.rules.append(Rule(name, "fail", found.cond, remedies, clause.because, place, owner.name, where))


def _or_wait(remedy: Remedy, else_wait: bool) -> tuple[Remedy, ...]:
    return (remedy, Wait()) if else_wait else (remedy,)


def _interrupts(draft: Draft, owner: Signature, clause: tree.Interrupts) -> None:
    targets = _targets(draft, owner, clause)
    if not draft.has_room(len(targets), clause.span):
        return
    where = draft.where(clause.span)
    for entry in targets:
        itself = entry.request == owner.name
        name = interruption(owner.name, entry.request)
        draft.claim(name, entry.span, labelled=False)
        condition: Cond = together(owner.name, entry.request)
        if itself:
            condition = Compare(">", Count((owner.name,)), Const(1))
            draft.parts[owner.name].interrupts_self = True
        remedies = _or_wait(Kill((entry.request,)), clause.else_wait)
        place = draft.place()
        draft.rules.append(Rule(name, "interrupts", condition, remedies, clause.because, place, location=where))


def _targets(draft: Draft, owner: Signature, clause: tree.Interrupts) -> list[ListedRequest]:
    """Return the requests that a request interrupts, in the order of the text; itself only if `self` is listed."""
    nodes = [target for target in clause.targets if not isinstance(target, tree.SelfTarget | tree.AllTarget)]
    found: list[ListedRequest] = []
    for entry in entries(draft.names, nodes, draft.mistakes):
        if entry.request != owner.name:
            found.append(entry)
            continue
        hint = "`interrupts all` means every other request of the module"
        message = f"{quote(owner.name)} interrupts itself"
        draft.mistakes.add("E411", message, entry.span, label="write `self` for that", hint=hint)
    selves = [target for target in clause.targets if isinstance(target, tree.SelfTarget)]
    for extra in selves[1:]:
        draft.mistakes.add("E409", "`self` stands twice in one list", extra.span)
    found += [ListedRequest(owner.name, target.span) for target in selves[:1]]
    for target in clause.targets:
        if isinstance(target, tree.AllTarget):
            others = [name for name in draft.names.modules[owner.module].all if name != owner.name]
            found += [ListedRequest(name, target.span) for name in others]
            if not others:
                message = f"`all` names no request: {quote(owner.name)} is the only one of its module"
                draft.mistakes.add("E413", message, target.span, hint="`self` means the request itself")
    return sorted(found, key=lambda entry: entry.span.start)


# ---- resources and effects ----


def _amount(draft: Draft, owner: Signature, clause: AmountClause) -> tuple[int | None, Cond | None, bool]:
    """Return the amount of a clause, its `when`, and whether that is right."""
    number = count(clause.amount, draft.mistakes)
    found = draft.meaning(AMOUNT, clause.condition, owner) if clause.condition else None
    right = clause.condition is None or found is not None
    word = type(clause).__name__.lower()
    if number is not None:
        note_amount(draft.mistakes, word, number, clause.amount.span)
    if clause.condition and found:
        note_fixed(draft.mistakes, found.cond, False, f"`{word}` never counts", clause.condition.span)
    return number, found.cond if found else None, right


def _uses(draft: Draft, owner: Signature, clause: tree.Uses) -> None:
    resource = find_resource(draft.names, clause.resource, draft.mistakes)
    number, when, right = _amount(draft, owner, clause)
    if resource is None:
        return
    name = resource.name
    if resource.consumable:
        message = f"`uses` needs a renewable resource, {quote(name)} is consumable"
        hint = "did you mean `consumes`?"
        draft.mistakes.add("E405", message, clause.resource.span, hint=hint)
        return
    draft.users.setdefault(name, set()).add(owner.name)
    if number is not None and right:
        draft.totals[name] += number * instances_of(draft.names, owner.name)
        draft.parts[owner.name].shares.append(Share(name, number, when))


def _consumable(draft: Draft, owner: Signature, clause: tree.Consumes | tree.Produces) -> None:
    resource = find_resource(draft.names, clause.resource, draft.mistakes)
    number, when, right = _amount(draft, owner, clause)
    place = draft.place() if isinstance(clause, tree.Consumes) else 0
    if resource is None:
        return
    name = resource.name
    if not resource.consumable:
        word = "consumes" if isinstance(clause, tree.Consumes) else "produces"
        message = f"`{word}` needs a consumable resource, {quote(name)} is none"
        hint = "did you mean `uses`?"
        draft.mistakes.add("E406", message, clause.resource.span, hint=hint)
        return
    if number is None or not right:
        return
    draft.totals[name] += number
    parts = draft.parts[owner.name]
    if isinstance(clause, tree.Consumes):
        where = draft.where(clause.span)
        parts.consumptions.append(Consumption(name, number, when, clause.because, place, where))
    else:
        parts.productions.append(Share(name, number, when))


def _set(draft: Draft, owner: Signature, clause: tree.OnSet) -> None:
    state = _state(draft, owner, clause.state)
    if state is None:
        return
    readings: dict[str, str] = {
        name: known.kind for name, known in draft.names.modules[owner.module].quantities.items()
    }
    readings |= dict.fromkeys(owner.results, "result") | dict.fromkeys(owner.params, "parameter")
    known = replace(draft.names.constants, readings=readings)
    given = value(clause.value, state.type, known, draft.mistakes)
    if given is not None:
        draft.parts[owner.name].affect(clause.occasion, SetState(state.name, given))


def _is_value(draft: Draft, owner: Signature, node: tree.Listed) -> bool:
    """Return whether `forget` names a poster, a state or a latch, and note that mistake: a request has a past."""
    names = draft.names
    match node:
        case tree.Ref(module, name) if module.text in names.modules:
            known = names.modules[module.text]
            found = None if name.text in known.requests else known.quantities.get(name.text)
        case tree.GroupName(name) if name.text not in names.groups:
            found = names.modules[owner.module].quantities.get(name.text) or names.quantities.get(name.text)
        case _:
            found = None
    if found:
        message = f"`forget` empties the past of a request, {quote(found.name)} is a {found.kind}"
        draft.mistakes.add("E219", message, node.span, hint=_INSTEAD[found.kind].format(found.name))
    return found is not None


def _state(draft: Draft, owner: Signature, node: tree.NameUse) -> QuantityName | None:
    """Return the state that `set` names, or None and a mistake."""
    name = node.name.text
    module = node.module.text if node.module else owner.module
    known = find_module(draft.names, node.module, draft.mistakes) if node.module else draft.names.modules[module]
    if known is None:
        return None
    found = known.quantities.get(name) or (None if node.module else draft.names.quantities.get(name))
    if found is None and name not in known.requests:
        message = f"unknown state {quote(name)} of module {quote(module)}"
        states = [state for state, quantity in known.quantities.items() if quantity.kind == "state"]
        draft.mistakes.unknown("E207", message, name, node.span, lambda: states, scope=module)
        return None
    called, kind = (found.name, found.kind) if found else (f"{module}.{name}", "request")
    if kind != "state":
        message = f"`set` gives a value to a state, {quote(called)} is a {kind}"
        reason = "posters are observed: " if kind == "poster" else ""
        hint = f"{reason}declare `state NAME: TYPE = VALUE;` in a module for what the checker keeps"
        draft.mistakes.add("E219", message, node.span, hint=hint)
        return None
    return found
