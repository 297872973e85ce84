"""Converts analyses of a text to values of the Language Server Protocol, and its URIs to paths."""

from collections.abc import Iterator
from typing import Any

from lsprotocol import types
from pygls.uris import to_fs_path

from exover.diagnostics import Diagnostic
from exover.editor.analysis import TextAnalysis
from exover.editor.completion import Proposal
from exover.editor.findings import PlacedFinding
from exover.editor.fixes import Fix
from exover.editor.hover import declaration
from exover.editor.includes import WrittenPath
from exover.editor.symbols import SpecSymbol, SymbolSort
from exover.editor.text import EditorText, PositionEncoding
from exover.source import Span
from exover.syntax import tree

SEVERITIES = {
    "error": types.DiagnosticSeverity.Error,
    "warning": types.DiagnosticSeverity.Warning,
    "note": types.DiagnosticSeverity.Information,
}
ENCODINGS: dict[str, PositionEncoding] = {"utf-8": "utf-8", "utf-16": "utf-16", "utf-32": "utf-32"}
KINDS: dict[SymbolSort, tuple[types.SymbolKind, types.CompletionItemKind]] = {
    "spec": (types.SymbolKind.File, types.CompletionItemKind.File),
    "enum": (types.SymbolKind.Enum, types.CompletionItemKind.Enum),
    "value": (types.SymbolKind.EnumMember, types.CompletionItemKind.EnumMember),
    "const": (types.SymbolKind.Constant, types.CompletionItemKind.Constant),
    "define": (types.SymbolKind.Function, types.CompletionItemKind.Function),
    "group": (types.SymbolKind.Array, types.CompletionItemKind.Class),
    "module": (types.SymbolKind.Module, types.CompletionItemKind.Module),
    "request": (types.SymbolKind.Method, types.CompletionItemKind.Method),
    "parameter": (types.SymbolKind.Variable, types.CompletionItemKind.Variable),
    "result": (types.SymbolKind.Variable, types.CompletionItemKind.Variable),
    "status": (types.SymbolKind.EnumMember, types.CompletionItemKind.EnumMember),
    "poster": (types.SymbolKind.Field, types.CompletionItemKind.Field),
    "state": (types.SymbolKind.Property, types.CompletionItemKind.Property),
    "latch": (types.SymbolKind.Boolean, types.CompletionItemKind.Variable),
    "resource": (types.SymbolKind.Number, types.CompletionItemKind.Unit),
    "rule": (types.SymbolKind.Event, types.CompletionItemKind.Event),
    "property": (types.SymbolKind.Event, types.CompletionItemKind.Event),
}


def path_of(uri: str) -> str:
    """Return the path of a `file:` URI; another URI, or one whose path has a NUL, is returned as it is."""
    path = to_fs_path(uri) if uri.startswith("file:") else None
    return path if path and "\0" not in path else uri


def position(place: tuple[int, int]) -> types.Position:
    """Return a place as a position of the protocol."""
    return types.Position(*place)


def range_of(text: EditorText, span: Span) -> types.Range:
    """Return a span as a range of the protocol."""
    start, end = text.range(span)
    return types.Range(position(start), position(end))


def mistake(text: EditorText, found: Diagnostic) -> types.Diagnostic:
    """Return a mistake as a diagnostic; one without a place stands at the beginning of the text."""
    said = [f"{found.message}{f' ({found.label})' if found.label else ''}", found.advice]
    return types.Diagnostic(
        range_of(text, found.span or Span(text.base, text.base)),
        "\n".join(filter(None, said)),
        SEVERITIES[found.severity],
        found.code,
        source="exover",
    )


def finding(text: EditorText, found: PlacedFinding) -> types.Diagnostic:
    """Return a finding as a diagnostic, from the place of its subject to the end of that line."""
    line = text.line(found.line - 1)
    start = min(line.start + found.column - 1, line.end)
    return types.Diagnostic(
        range_of(text, Span(start, line.end)),
        f"{found.subject}: {found.message}",
        SEVERITIES[found.severity],
        found.check,
        source="exover check",
    )


def completion(analyses: list[TextAnalysis], each: Proposal) -> types.CompletionItem:
    """Return a proposal as a completion item; for a name, with its declaration as documentation."""
    if each.symbol is None:
        return types.CompletionItem(each.text, kind=types.CompletionItemKind.Keyword, sort_text=f"1{each.text}")
    known = next((found for found in analyses if each.symbol in found.index.declared), None)
    told = declaration(known, each.symbol) if known else f"{each.symbol.sort} `{each.symbol.name}`"
    documentation = types.MarkupContent(types.MarkupKind.Markdown, told)
    kind, detail = KINDS[each.symbol.sort][1], each.symbol.sort
    return types.CompletionItem(
        each.text, kind=kind, detail=detail, documentation=documentation, sort_text=f"0{each.text}"
    )


def path_completion(text: EditorText, written: WrittenPath, path: str) -> types.CompletionItem:
    """Return a path that may stand in an `include` as a completion item."""
    kind = types.CompletionItemKind.Folder if path.endswith("/") else types.CompletionItemKind.File
    return types.CompletionItem(path, kind=kind, text_edit=types.TextEdit(range_of(text, written.span), path))


def action(text: EditorText, uri: str, found: Diagnostic, change: Fix) -> types.CodeAction:
    """Return a change that removes a mistake as a code action."""
    edit = types.TextEdit(range_of(text, change.span), change.text)
    return types.CodeAction(
        change.title,
        types.CodeActionKind.QuickFix,
        [mistake(text, found)],
        is_preferred=True,
        edit=types.WorkspaceEdit({uri: [edit]}),
    )


def outline(text: EditorText, found: TextAnalysis) -> list[types.DocumentSymbol]:
    """Return the document symbols: members below their modules, labels of clauses below their requests."""
    if found.root is None:
        return []
    at = {each.span: symbol for symbol, each in found.index.declared.items()}
    items = [item for item in found.root.items if found.document.base <= item.span.start <= found.document.end]
    return list(_outlined(text, items, at))


def _outlined(text: EditorText, nodes: Any, at: dict[Span, SpecSymbol]) -> Iterator[types.DocumentSymbol]:
    for node in nodes:
        name: Any = getattr(node, "label", None) or getattr(node, "name", None)
        symbol = at.get(name.span) if isinstance(name, tree.Name) else None
        below = list(_outlined(text, getattr(node, "members", ()) or getattr(node, "clauses", ()), at))
        if symbol is None:
            yield from below
            continue
        yield types.DocumentSymbol(
            name.text,
            KINDS[symbol.sort][0],
            range_of(text, node.span),
            range_of(text, name.span),
            symbol.sort,
            children=below,
        )
