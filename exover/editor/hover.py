"""Hover: Markdown about the name or the statement at a place of a text."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from exover.editor.analysis import TextAnalysis
from exover.editor.findings import PlacedFinding
from exover.editor.symbols import SpecSymbol, SymbolOccurrence, children
from exover.escaping import plain_markdown
from exover.model.model import Guard, Launch, Location, Model, Request, Rule
from exover.model.reads import in_question
from exover.model.wording import condition_text, remedy_text, value_text
from exover.source import Source, Span
from exover.syntax import tree
from exover.syntax.lex import tokens

MAX_RULES = 20
"""The most rules that are listed for one name or statement."""
MAX_EXCERPT = 300
_CLOSING = frozenset((",", ";", ")", ""))
"""Tokens before which no blank stands; the last is the end of the text."""
STATEMENTS = (
    tree.Mutex,
    tree.MutexOver,
    tree.Limit,
    tree.Forbid,
    tree.Launch,
    tree.Resource,
    tree.Check,
    tree.WaitUntil,
    tree.SettleUntil,
    tree.FailWhen,
    tree.After,
    tree.Before,
    tree.Interrupts,
)
"""The statements that stand for rules, guards or launches of the model."""


def hover(
    analysis: TextAnalysis,
    offset: int,
    spec: TextAnalysis | None = None,
    uses: Mapping[str, PlacedFinding] | None = None,
) -> tuple[str, Span] | None:
    """Return the Markdown at an offset and the span that it is about; None if there is none.

    `spec`: for a properties file, the analysis of its spec, which declares most names. `uses`: the findings of the
    check `rule-use`, by subject.
    """
    if not analysis.current:
        return None
    found = analysis.index.at(offset)
    if found:
        return _of_name(analysis, found, spec, uses or {}), found.span
    node = _statement(analysis.root, offset)
    if node is None or analysis.model is None:
        return None
    here = _location(analysis.source, node)
    meant = [each for each in _all(analysis.model) if each.location == here]
    if not meant:
        return None
    parts = [_list("stands for", list(map(_rule, meant))), *_used({each.name for each in meant}, uses or {})]
    return "\n\n".join(parts), node.span


def _used(names: Iterable[str], uses: Mapping[str, PlacedFinding]) -> Iterator[str]:
    """Yield for each rule with a finding of `rule-use` whether it is in use."""
    for name in sorted(names):
        if name in uses:
            yield f"`{name}` is {'not ' if uses[name].violated else ''}in use: {uses[name].message}"


def _of_name(
    analysis: TextAnalysis, found: SymbolOccurrence, spec: TextAnalysis | None, uses: Mapping[str, PlacedFinding]
) -> str:
    told = [
        declaration(each, found.symbol) for each in (analysis, spec) if each and found.symbol in each.index.declared
    ]
    parts = told[:1] or [f"{found.symbol.sort} `{found.symbol.name}`"]
    if analysis.model:
        parts += _use(analysis.model, found.symbol)
    if found.symbol.sort in ("rule", "resource"):
        parts += _used([found.symbol.name], uses)
    return "\n\n".join(parts)


def declaration(analysis: TextAnalysis, symbol: SpecSymbol) -> str:
    """Return the declaration of a symbol as Markdown; of modules and requests, without the part in braces."""
    declared = analysis.index.declared[symbol]
    name = f"{symbol.sort} `{symbol.name}`"
    if symbol.sort == "spec":
        return name
    text = (analysis.last or analysis).source.slice(declared.node.span)
    told = _bare(text, head=isinstance(declared.node, tree.Module | tree.Request))
    cut = told if len(told) <= MAX_EXCERPT else f"{told[:MAX_EXCERPT]}…"
    return f"{name}\n\n```exo\n{cut}\n```"


def _bare(text: str, head: bool) -> str:
    """Return a text on one line: without its comments, and with one blank where anything parts two words.

    `head`: only up to the first brace outside of parentheses.
    """
    found, end, depth = "", 0, 0
    for token in tokens(text, [], formulas=True):
        depth += (token.text == "(") - (token.text == ")")
        if head and token.text == "{" and depth == 0:
            break
        parted = token.start > end > 0 and token.text not in _CLOSING
        found += " " * parted + token.text
        end = token.end
    return found


def _use(model: Model, symbol: SpecSymbol) -> Iterator[str]:
    """Yield the list of rules that decide about a request, or the list of what a rule stands for."""
    request = model.request.get(symbol.name) if symbol.sort == "request" else None
    if request:
        yield _list("decided by", list(_deciders(model, request)))
    meant = named(model, symbol.name) if symbol.sort in ("rule", "resource") else []
    if meant:
        yield _list("stands for", list(map(_rule, meant)))
    if symbol.sort == "resource" and model.resource[symbol.name].consumable:
        yield _list("consumed by", list(_consumers(model, symbol.name)))


def _deciders(model: Model, request: Request) -> Iterator[str]:
    names = [guard.name for guard in request.guards] + [clause.resource for clause in request.consumptions]
    names += [rule.name for rule in in_question(model)[request.name]]
    names += [launch.name for launch in model.launches if launch.request == request.name]
    texts = model.texts | {clause.resource: model.text(clause) for clause in reversed(request.consumptions)}
    for name in dict.fromkeys(names):
        because = texts.get(name)
        yield f"`{name}`" + (f": {plain_markdown(because)}" if because else "")


def _consumers(model: Model, resource: str) -> Iterator[str]:
    for request in model.requests:
        for each in (clause for clause in request.consumptions if clause.resource == resource):
            when = f" when `{condition_text(each.when)}`" if each.when else ""
            yield f"`{request.name}`: {each.amount}{when}"


def named(model: Model, name: str) -> list[Rule | Guard | Launch]:
    """Return the rules, guards and launches of the model with this name."""
    return [each for each in _all(model) if each.name == name]


def _all(model: Model) -> Iterator[Rule | Guard | Launch]:
    yield from model.rules
    for request in model.requests:
        yield from request.guards
    yield from model.launches


def _rule(each: Rule | Guard | Launch) -> str:
    match each:
        case Guard():
            word = "check" if each.kind == "check" else f"{each.kind} until"
            return f"`{each.name}`: `{word} {condition_text(each.condition)}`"
        case Launch():
            values = ", ".join(map(value_text, each.args))
            return f"`{each.name}`: `launch {each.request}({values}) when {condition_text(each.condition)}`"
        case Rule():
            remedies = " or ".join(map(remedy_text, each.remedies))
            slot = f"a slot of {each.slot_of} active and " if each.slot_of else ""
            return f"`{each.name}`: `forbid {slot}{condition_text(each.condition)} by {remedies}`"


def _list(title: str, lines: list[str]) -> str:
    if not lines:
        return ""
    shown = [f"- {line}" for line in lines[:MAX_RULES]]
    more = [f"- and {len(lines) - MAX_RULES} more"] if len(lines) > MAX_RULES else []
    return "\n".join([f"{title}:", "", *shown, *more])


def _location(source: Source, node: Any) -> Location:
    start = node.name.span.start if isinstance(node, tree.Resource) else node.span.start
    return Location(*source.place(start))


def _statement(node: Any, offset: int) -> Any:
    """Return the innermost of `STATEMENTS` around an offset; None if there is none."""
    found = node if isinstance(node, STATEMENTS) else None
    for child in children(node):
        if child.span.start <= offset <= child.span.end:
            found = _statement(child, offset) or found
    return found
