"""The tree of a spec to its canonical text: parsed, it gives an equal tree, whose text is the same."""

from collections.abc import Iterable
from typing import assert_never

from exover.syntax import tree
from exover.syntax.format import (
    _listed,
    _refs,
    _value,
    format_clause,
    format_condition,
    format_resource,
    format_rule,
)
from exover.syntax.lex import string_literal

_INDENT = "    "


def format_spec(spec: tree.Spec | tree.Part) -> str:
    """Return the text of a spec or a part, with a newline at its end.

    An empty line stands around blocks and between items of different kinds.
    """
    lines = [f"{'spec' if isinstance(spec, tree.Spec) else 'part'} {spec.name.text};"]
    before: tree.Item | None = None
    for item in spec.items:
        block = isinstance(item, tree.Module | tree.Context)
        if before is None or block or _kind(item) is not _kind(before):
            lines.append("")
        lines += _item(item)
        before = item
    return "\n".join(lines) + "\n"


def _kind(item: tree.Item) -> type:
    return tree.Mutex if isinstance(item, tree.MutexOver) else type(item)


def _item(item: tree.Item) -> list[str]:
    match item:
        case tree.Include(path):
            return [f"include {string_literal(path)};"]
        case tree.Enum(name, values):
            return [f"enum {name.text} {{ {_names(values)} }}"]
        case tree.Const(name, value):
            return [f"const {name.text} = {_value(value)};"]
        case tree.Define(name, condition):
            return [f"define {name.text} = {format_condition(condition)};"]
        case tree.Group(name, requests):
            return [f"group {name.text} = {_refs(requests)};"]
        case tree.Module(name, title, members):
            shown = "" if title is None else " " + string_literal(title)
            return _block(f"module {name.text}{shown}", [line for member in members for line in _member(member)])
        case tree.Poster():
            return [_poster(item)]
        case tree.Latch(name, condition, until):
            return [f"latch {name.text}: when {format_condition(condition)} until {_refs(until)};"]
        case tree.Resource():
            return [format_resource(item)]
        case tree.Context(request, clauses):
            return _block(f"context {_listed(request)}", [format_clause(clause) for clause in clauses])
        case _:
            return [format_rule(item)]


def _block(head: str, lines: list[str]) -> list[str]:
    return [f"{head} {{", *(_INDENT + line for line in lines), "}"] if lines else [f"{head} {{}}"]


def _member(member: tree.Member) -> list[str]:
    match member:
        case tree.Poster():
            return [_poster(member)]
        case tree.State(name, kind, initial):
            return [f"state {name.text}: {_type(kind)} = {_value(initial)};"]
        case tree.Request(name, params, results, statuses, instances, clauses):
            head = f"request {name.text}({_params(params)})"
            head += f" returns ({_params(results)})" if results else ""
            head += f" fails ({_names(statuses)})" if statuses else ""
            head += f" instances {instances.text}" if instances else ""
            return _block(head, [format_clause(clause) for clause in clauses]) if clauses else [f"{head};"]
        case _:
            assert_never(member)


def _poster(poster: tree.Poster) -> str:
    otherwise = "" if poster.otherwise is None else f" else {_value(poster.otherwise)}"
    return f"poster {poster.name.text}: {_type(poster.type)} = {_value(poster.initial)}{otherwise};"


def _type(kind: tree.Type) -> str:
    match kind:
        case tree.BoolType():
            return "bool"
        case tree.IntType(range=bounds):
            return f"int in {_range(bounds)}"
        case tree.RealType(range=bounds):
            return "real" if bounds is None else f"real in {_range(bounds)}"
        case tree.NamedType(name):
            return name.text
        case tree.SetType(values):
            return f"{{{_names(values)}}}"
        case _:
            assert_never(kind)


def _range(bounds: tree.Range) -> str:
    return f"{_value(bounds.low)} .. {_value(bounds.high)}"


def _params(params: Iterable[tree.Param]) -> str:
    return ", ".join(f"{param.name.text}: {_type(param.type)}" for param in params)


def _names(names: Iterable[tree.Name]) -> str:
    return ", ".join(name.text for name in names)
