"""The semantic actions of the grammar: for each production of grammar.lark, how a reduction makes a node of the tree.

Most actions make the node of that name from exactly their children, in order. A child is a node, a tuple of nodes, a
text, a bool, or None for a part that is left out; a token that the grammar keeps is a Name (words of the user), a
Number, a str (strings, already decoded) or a Token (keywords and operators). The span of the production comes last.
"""

from collections.abc import Callable
from typing import Any

from exover.source import Span
from exover.syntax import tree
from exover.syntax.lex import INT, NAME, NUMBER, STRING, Token, string_value

Action = Callable[..., Any]


def _number_of(token: Token) -> tree.Number:
    return tree.Number(token.text, False, Span(token.start, token.end))


VALUES: dict[str, Callable[[Token], Any]] = {
    NAME: lambda token: tree.Name(token.text, Span(token.start, token.end)),
    INT: _number_of,
    NUMBER: _number_of,
    STRING: lambda token: string_value(token.text),
}
"""The value of a token of each of these kinds as a child of a production; a token of another kind is its own value."""


def _listing(*parts: Any) -> tuple[Any, ...]:
    return parts[:-1]


def _optional(*parts: Any) -> Any:
    """Return the child of an optional part, None if it is left out."""
    return parts[0] if len(parts) > 1 else None


def _optional_list(*parts: Any) -> Any:
    return parts[0] if len(parts) > 1 else ()


def _text(token: Token, span: Span) -> str:
    return token.text


def _word(word: tree.Name | Token, span: Span) -> tree.Name:
    return tree.Name(word.text, span) if isinstance(word, Token) else word


def _truth(token: Token, span: Span) -> tree.Truth:
    return tree.Truth(token.text == "true", span)


def _name(name: tree.Name, span: Span) -> tree.NameUse:
    return tree.NameUse(None, name, span)


def _plain_name(first: tree.Name, second: tree.Name | None, span: Span) -> tree.NameUse:
    return tree.NameUse(None, first, span) if second is None else tree.NameUse(first, second, span)


def _module(name: tree.Name, title: str | None, *rest: Any) -> tree.Module:
    return tree.Module(name, title, rest[:-1], rest[-1])


def _request(
    name: tree.Name,
    params: tuple[tree.Param, ...] | None,
    results: tuple[tree.Param, ...],
    statuses: tuple[tree.Name, ...],
    instances: tree.Number | None,
    clauses: tuple[tree.Clause, ...],
    span: Span,
) -> tree.Request:
    return tree.Request(name, params or (), results, statuses, instances, clauses, span)


def _resource(
    name: tree.Name,
    capacity: tree.Number,
    consumable: tuple[bool, tree.Number | None],
    remedies: tuple[tree.Remedy, ...],
    because: str | None,
    span: Span,
) -> tree.Resource:
    return tree.Resource(name, capacity, consumable[0], consumable[1], remedies, because, span)


def _launch(
    label: tree.Name | None,
    request: tree.Ref,
    arguments: tuple[tree.Value, ...] | None,
    condition: tree.Cond,
    because: str | None,
    span: Span,
) -> tree.Launch:
    return tree.Launch(label, request, arguments or (), condition, because, span)


def _interrupts(targets: tuple[tree.Target, ...], else_wait: bool, because: str | None, span: Span) -> tree.Interrupts:
    match targets:
        case (tree.GroupName(name=tree.Name(text="all"), span=where),):
            return tree.Interrupts((tree.AllTarget(where),), else_wait, because, span)
        case _:
            return tree.Interrupts(targets, else_wait, because, span)


def _connected(connective: tree.Connective) -> Action:
    return lambda *parts: tree.Connected(connective, parts[:-1], parts[-1])


def _temporal(operator: Token, part: tree.Formula, span: Span) -> tree.Temporal:
    return tree.Temporal(operator.text, part, Span(operator.start, operator.end), span)  # type: ignore[arg-type]


def _temporal_binary(left: tree.Formula, operator: Token, right: tree.Formula, span: Span) -> tree.TemporalBinary:
    place = Span(operator.start, operator.end)
    return tree.TemporalBinary(left, operator.text, right, place, span)  # type: ignore[arg-type]


def _quantified(quantifier: Token, part: tree.Formula, span: Span) -> tree.Quantified:
    place = Span(quantifier.start, quantifier.end)
    return tree.Quantified(quantifier.text, part, place, span)  # type: ignore[arg-type]


def _last(request: tree.Ref, relation: str, outcome: tree.Outcome, span: Span) -> tree.Last:
    return tree.Last(request, relation == "==", outcome, span)


ACTIONS: dict[str, Action] = {
    "spec": lambda name, *rest: tree.Spec(name, rest[:-1], rest[-1]),
    "part": lambda name, *rest: tree.Part(name, rest[:-1], rest[-1]),
    "include": tree.Include,
    "properties": lambda name, *rest: tree.Properties(name, rest[:-1], rest[-1]),
    "property": tree.Property,
    "assume_fair": tree.AssumeFair,
    "assume_always": lambda condition, span: tree.Assume(False, condition, span),
    "assume_never": lambda condition, span: tree.Assume(True, condition, span),
    "never": tree.Never,
    "always": tree.Always,
    "possible": tree.Possible,
    "always_possible": tree.AlwaysPossible,
    "from_possible": tree.FromPossible,
    "leads_to": tree.LeadsTo,
    "precedes": tree.Precedes,
    "until": tree.Until,
    "raw": tree.Raw,
    "logic": _text,
    "equivalent": _connected("iff"),
    "implication": _connected("implies"),
    "either": _connected("or"),
    "both": _connected("and"),
    "negative_formula": _connected("not"),
    "temporal": _temporal,
    "temporal_binary": _temporal_binary,
    "quantified": _quantified,
    "quantifier": lambda quantifier, span: quantifier,
    "enum": tree.Enum,
    "const": tree.Const,
    "define": tree.Define,
    "group": tree.Group,
    "module": _module,
    "request": _request,
    "returns": _optional_list,
    "fails": _optional_list,
    "instances": _optional,
    "block": _listing,
    "names": _listing,
    "params": _listing,
    "param": tree.Param,
    "bool_type": tree.BoolType,
    "int_type": tree.IntType,
    "real_type": tree.RealType,
    "named_type": tree.NamedType,
    "set_type": tree.SetType,
    "range": tree.Range,
    "poster": tree.Poster,
    "state": tree.State,
    "latch": tree.Latch,
    "resource": _resource,
    "consumable": lambda span: (False, None),
    "is_consumable": lambda initial, span: (True, initial),
    "context": lambda request, *rest: tree.Context(request, rest[:-1], rest[-1]),
    "check": tree.Check,
    "wait_until": tree.WaitUntil,
    "settle_until": tree.SettleUntil,
    "fail_when": tree.FailWhen,
    "after": tree.After,
    "before": tree.Before,
    "interrupts": _interrupts,
    "uses": tree.Uses,
    "consumes": tree.Consumes,
    "produces": tree.Produces,
    "on_set": tree.OnSet,
    "on_forget": tree.OnForget,
    "when": _optional,
    "else_wait": lambda span: False,
    "with_else_wait": lambda span: True,
    "occasion": _text,
    "mutex": tree.Mutex,
    "mutex_over": tree.MutexOver,
    "limit": tree.Limit,
    "forbid": tree.Forbid,
    "launch": _launch,
    "by": _listing,
    "reject": tree.Reject,
    "wait": tree.Wait,
    "kill": tree.Kill,
    "ending": _optional,
    "label": lambda name, span: name,
    "label_or_until": lambda word, span: _label(word),
    "label_or_when": lambda word, span: _label(word),
    "label_or_at": lambda word, span: _label(word),
    "label_or_ref": lambda name, span: name,
    "implies": tree.Implies,
    "disjunction": lambda *parts: tree.Or(parts[:-1], parts[-1]),
    "conjunction": lambda *parts: tree.And(parts[:-1], parts[-1]),
    "negated": tree.Not,
    "predicate": lambda kind, requests, span: tree.Predicate(kind, requests, None, span),
    "predicate_with": lambda kind, request, condition, span: tree.Predicate(kind, (request,), condition, span),
    "last": _last,
    "used": tree.Used,
    "level": tree.Level,
    "compare": tree.Compare,
    "in_range": tree.InRange,
    "in_set": lambda term, *rest: tree.InSet(term, rest[:-1], rest[-1]),
    "kind": _text,
    "outcome": _text,
    "equality": _text,
    "relation": _text,
    "term": lambda first, *rest: tree.Sum(first, rest[:-1], rest[-1]),
    "addend": lambda sign, term, span: tree.Addend(sign.text == "-", term, span),
    "product": lambda *parts: tree.Product(parts[:-1], parts[-1]),
    "name": _name,
    "qualified": tree.NameUse,
    "self_name": tree.SelfName,
    "word": _word,
    "plain_name": _plain_name,
    "ref": tree.Ref,
    "module_all": tree.ModuleAll,
    "group_name": tree.GroupName,
    "refs": _listing,
    "self_target": tree.SelfTarget,
    "targets": _listing,
    "value_word": tree.Word,
    "values": _listing,
    "positive": lambda number, span: number,
    "negative": lambda number, span: tree.Number(number.text, True, span),
    "count": lambda number, span: number,
    "truth": _truth,
}


def _label(word: tree.Name | Token) -> tree.Name:
    # The span of the label alone, without the colon that is part of the production.
    return tree.Name(word.text, Span(word.start, word.end)) if isinstance(word, Token) else word
