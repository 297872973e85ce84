"""Resolves conditions: connectives, predicates and shorthand of the tree become conditions of the model."""

from collections.abc import Sequence
from typing import assert_never

from exover.diagnostics import quote
from exover.model.expression import (
    FALSE,
    TRUE,
    And,
    Compare,
    Cond,
    Const,
    Last,
    Level,
    Not,
    Or,
    Past,
    Phase,
    Status,
    Used,
)
from exover.model.types import Bool, Enum
from exover.resolve.circles import in_order, note_circle
from exover.resolve.mistakes import Mistakes
from exover.resolve.names import SymbolTable, find_request, find_resource, requests
from exover.resolve.scope import DEFINE, Defined, Meaning, NameScope, Typed
from exover.resolve.terms import no_order, operand, relate, unit
from exover.resolve.values import Symbol, count, describe
from exover.source import Span
from exover.syntax import tree

MAX_ATOMS = 100_000
"""The most atoms of a condition with its defines and lists expanded: each of many defines may double the size."""
MAX_DEPTH = 200
"""The most levels of a condition with its defines expanded, so that engines may recurse on it."""


def meaning(scope: NameScope, node: tree.Cond) -> Meaning | None:
    """Return the meaning of a condition in its scope, or None with its mistakes noted."""
    cond = condition(scope, node, 0)
    tally = scope.tally
    if cond is None or not _bounded(scope, node.span):
        return None
    return Meaning(cond, frozenset(tally.reads), tally.size, tally.depth)


def _bounded(scope: NameScope, span: Span) -> bool:
    """Return whether the condition that is being resolved is within MAX_ATOMS and MAX_DEPTH; if not, note it."""
    tally = scope.tally
    right = tally.size <= MAX_ATOMS and tally.depth <= MAX_DEPTH
    if not right:
        limits = f"at most {MAX_ATOMS} comparisons and predicates, nested at most {MAX_DEPTH} deep"
        scope.mistakes.add("E414", "the condition is too large with its defines expanded", span, hint=limits)
    return right


def _all_true(parts: Sequence[Cond | None]) -> tuple[Cond, ...] | None:
    """Return the parts; None if one is None, for a mistake."""
    right = tuple(part for part in parts if part is not None)
    return right if len(right) == len(parts) else None


def condition(scope: NameScope, node: tree.Cond, depth: int) -> Cond | None:
    """Return the condition of the model, or None with its mistakes noted; it is at level `depth` of the whole."""
    scope.tally.depth = max(scope.tally.depth, depth)
    match node:
        case tree.Not(part):
            inner = condition(scope, part, depth + 1)
            return None if inner is None else Not(inner)
        case tree.And(parts):
            found = _all_true([condition(scope, part, depth + 1) for part in parts])
            return None if found is None else And(found)
        case tree.Or(parts):
            found = _all_true([condition(scope, part, depth + 1) for part in parts])
            return None if found is None else Or(found)
        case tree.Implies(left, right):
            found = _all_true([condition(scope, left, depth + 2), condition(scope, right, depth + 1)])
            return None if found is None else Or((Not(found[0]), found[1]))
        case tree.Predicate() | tree.Last() | tree.Used() | tree.Level():
            return _about_state(scope, node, depth)
        case tree.Compare() | tree.InRange() | tree.InSet():
            return _comparison(scope, node, depth)
        case _:
            return _bare(scope, node, depth)


# ---- predicates ----


def _about_state(
    scope: NameScope, node: tree.Predicate | tree.Last | tree.Used | tree.Level, depth: int
) -> Cond | None:
    if scope.subject:
        hint = "join it with `and` behind the bracket"
        scope.mistakes.add("E415", "a predicate cannot stand inside `with`", node.span, hint=hint)
        return None
    match node:
        case tree.Predicate():
            return _predicate(scope, node, depth)
        case tree.Last(ref, equal, outcome):
            scope.tally.size += 1
            request = find_request(scope.names, ref, scope.mistakes)
            if request is None or not scope.read("last", request.name, node.span):
                return None
            return Last(request.name, outcome) if equal else Not(Last(request.name, outcome))
        case tree.Used() | tree.Level():
            return _amount(scope, node)
        case _:
            assert_never(node)


def _predicate(scope: NameScope, node: tree.Predicate, depth: int) -> Cond | None:
    match node.kind:
        case "asked" | "launched" | "rejected" | "killed" | "ended" as kind:
            message = f"`{kind}` speaks of a step, {scope.standing.name} of a state"
            hint = "only a properties file tells what a step did"
            scope.mistakes.add("E417", message, node.span, hint=hint)
            return None
        case kind if node.condition is None:
            return _any_of(scope, node, kind, depth)
        case kind:
            return _with(scope, node, kind, depth)


def _atom(kind: tree.StateKind, request: str, where: Cond | None = None) -> Status | Past:
    if kind == "past":
        return Past(request, where)
    phase: Phase = kind
    return Status(phase, request, where)


def _any_of(scope: NameScope, node: tree.Predicate, kind: tree.StateKind, depth: int) -> Cond | None:
    """Return the disjunction of the predicate over the requests of the list."""
    found = requests(scope.names, node.requests, scope.mistakes)
    scope.tally.size += len(found)
    scope.tally.depth = max(scope.tally.depth, depth + 1)
    if not all(scope.read(kind, request, node.span) for request in found):
        return None
    atoms = tuple(_atom(kind, request) for request in found)
    return atoms[0] if len(atoms) == 1 else Or(atoms)


def _with(scope: NameScope, node: tree.Predicate, kind: tree.StateKind, depth: int) -> Cond | None:
    """Return `kind(request with condition)`."""
    ref = node.requests[0]
    assert isinstance(ref, tree.Ref) and node.condition is not None, "the grammar has one request before `with`"
    request = find_request(scope.names, ref, scope.mistakes)
    if request is None:
        return None
    where = condition(scope.inside(request, kind == "past"), node.condition, depth + 1)
    scope.tally.size += 1
    if not scope.read(kind, request.name, node.span) or where is None:
        return None
    return _atom(kind, request.name, where)


def _amount(scope: NameScope, node: tree.Used | tree.Level) -> Cond | None:
    """Return the comparison of `used(…)` or `level(…)` with a number, or None with a mistake noted."""
    scope.tally.size += 1
    resource = find_resource(scope.names, node.resource, scope.mistakes)
    number = count(node.amount, scope.mistakes)
    if resource is None:
        return None
    name = resource.name
    if isinstance(node, tree.Used) and resource.consumable:
        message, hint = f"`used` needs a renewable resource, {quote(name)} is consumable", f"level({name})"
        scope.mistakes.add("E405", message, node.span, hint=f"did you mean {quote(hint)}?")
        return None
    if isinstance(node, tree.Level) and not resource.consumable:
        message, hint = f"`level` needs a consumable resource, {quote(name)} is none", f"used({name})"
        scope.mistakes.add("E406", message, node.span, hint=f"did you mean {quote(hint)}?")
        return None
    if not scope.read("used" if isinstance(node, tree.Used) else "level", name, node.span) or number is None:
        return None
    term = Used(name) if isinstance(node, tree.Used) else Level(name)
    return Compare(node.relation, term, Const(number))


# ---- comparisons ----


def _comparison(scope: NameScope, node: tree.Compare | tree.InRange | tree.InSet, depth: int) -> Cond | None:
    match node:
        case tree.Compare(left, relation, right):
            scope.tally.size += 1
            return relate(scope, relation, operand(scope, left), operand(scope, right), node.span)
        case tree.InRange():
            scope.tally.size += 2
            scope.tally.depth = max(scope.tally.depth, depth + 1)
            return _in_range(scope, node)
        case tree.InSet(term, members):
            scope.tally.size += len(members)
            scope.tally.depth = max(scope.tally.depth, depth + 1)
            one = operand(scope, term)
            equal = _all_true([relate(scope, "==", one, operand(scope, member), node.span) for member in members])
            if equal is None:
                return None
            return equal[0] if len(equal) == 1 else Or(equal)
        case _:
            assert_never(node)


def _in_range(scope: NameScope, node: tree.InRange) -> Cond | None:
    term, low, high = (operand(scope, part) for part in (node.term, node.low, node.high))
    if isinstance(term, Typed) and isinstance(term.type, Bool | Enum):
        no_order(scope, term.type, node.span)
        return None
    found = _all_true(
        [relate(scope, ">=", term, low, node.span), relate(scope, "<=", term, high, node.span)],
    )
    return None if found is None else And(found)


def _bare(scope: NameScope, node: tree.Term, depth: int) -> Cond | None:
    """Return the condition of a bare term, which must be a bool or a define; else None with a mistake noted."""
    found = operand(scope, node) if isinstance(node, tree.Product | tree.Sum) else unit(scope, node)
    scope.tally.size += not isinstance(found, Defined)
    match found:
        case None:
            return None
        case Defined(name, known, span):
            if known is None or not scope.read_all(known, name, span):
                return None
            scope.tally.size += known.size
            scope.tally.depth = max(scope.tally.depth, depth + known.depth)
            return known.cond
        case Typed(Bool(), Const(value)):
            return TRUE if value else FALSE
        case Typed(Bool(), term):
            return Compare("==", term, Const(True))
        case Symbol(name) if name not in scope.names.constants.enum_values:
            scope.unknown(found)
        case _:
            what, hint = "an enum value" if isinstance(found, Symbol) else "a number", ""
            text = scope.mistakes.source.slice(node.span)
            if isinstance(found, Typed):
                what = describe(found.type)
                if isinstance(found.type, Enum):
                    hint = f"compare it with a value: `{text} == {found.type.values[0]}`"
            scope.mistakes.add("E304", f"a condition is needed, {quote(text)} is {what}", node.span, hint=hint)
    return None


# ---- defines ----


def defines(names: SymbolTable, mistakes: Mistakes) -> dict[str, Meaning | None]:
    """Return the meaning of every define, None for one with a mistake; each is resolved after those that it uses."""
    needs = {name: sorted(names_in(node.condition)) for name, node in names.defines.items()}
    order, circles = in_order(needs)
    meanings: dict[str, Meaning | None] = {}
    for circle in circles:
        note_circle("define", [names.defines[name].name for name in circle], mistakes)
        meanings.update(dict.fromkeys(circle))
    for name in order:
        if name not in meanings:
            meanings[name] = meaning(NameScope(names, meanings, mistakes, DEFINE), names.defines[name].condition)
    return meanings


def names_in(node: tree.Cond) -> set[str]:
    """Return the names that are used as conditions, outside `with`; defines are among them."""
    match node:
        case tree.Not(part):
            return names_in(part)
        case tree.And(parts) | tree.Or(parts):
            return set().union(*(names_in(part) for part in parts))
        case tree.Implies(left, right):
            return names_in(left) | names_in(right)
        case tree.NameUse(None, name):
            return {name.text}
        case _:
            return set()
