"""A new name for what has one, everywhere, and only if no other name comes to mean something else."""

import re
from dataclasses import dataclass

from exover.diagnostics import quote
from exover.editor.analysis import TextAnalysis, analyse_properties, analyse_spec
from exover.editor.symbols import Occurrence, SpecSymbol
from exover.source import Source, Span
from exover.syntax import tree
from exover.syntax.lex import RESERVED

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")


class RenameRefused(Exception):
    """A name cannot be given; the text tells the user why."""


@dataclass(frozen=True, slots=True)
class Change:
    """The places of one text that get the new name."""

    path: str
    spans: tuple[Span, ...]


def rename(texts: list[tuple[str, TextAnalysis]], symbol: SpecSymbol, name: str) -> list[Change]:
    """Return where a symbol is named, text by text. Raises `RenameRefused`.

    `texts` are a spec and its properties files, or one of these alone. None may have a mistake, before or after.
    """
    if not _NAME.match(name) or name in RESERVED:
        raise RenameRefused(f"{quote(name)} is no name: letters, digits and `_`, and no reserved word")
    if not any(symbol in found.index.declared for _, found in texts):
        raise RenameRefused(f"{quote(symbol.name)} is declared in no file that is known")
    changes, spec = [], None
    for path, found in texts:
        spans = tuple(each.span for each in found.index.of(symbol))
        if not found.current or found.diagnostics:
            raise RenameRefused(f"{path} has mistakes: mend them first")
        after = _renamed(found, spans, name, spec)
        spec = after if isinstance(found.root, tree.Spec) else spec
        if after.diagnostics:
            raise RenameRefused(f"with {quote(name)}, {path} would have a mistake: {after.diagnostics[0].message}")
        if _alike(found) != _alike(after):
            raise RenameRefused(f"with {quote(name)}, a name in {path} would mean something else")
        if spans:
            changes.append(Change(path, spans))
    return changes


def _renamed(found: TextAnalysis, spans: tuple[Span, ...], name: str, spec: TextAnalysis | None) -> TextAnalysis:
    text, parts, end = found.source.text, [], 0
    for span in spans:
        parts += [text[end : span.start], name]
        end = span.end
    source = Source(found.source.name, "".join([*parts, text[end:]]))
    return analyse_spec(source) if isinstance(found.root, tree.Spec) else analyse_properties(source, spec)


def _alike(found: TextAnalysis) -> list[int]:
    """Return for every name of a text the number of the first that stands for the same."""
    ordered: list[Occurrence] = sorted(found.index.occurrences, key=lambda each: each.span)
    first: dict[SpecSymbol, int] = {}
    return [first.setdefault(each.symbol, number) for number, each in enumerate(ordered)]
