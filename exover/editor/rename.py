"""Renames a symbol everywhere, unless another name would change its meaning."""

import re

from exover.dataclass import dataclass
from exover.diagnostics import quote
from exover.editor.analysis import TextAnalysis, analyse_properties, analyse_spec
from exover.editor.files import Files
from exover.editor.symbols import SpecSymbol, SymbolOccurrence
from exover.source import Source, Span
from exover.syntax import tree
from exover.syntax.includes import parts_of
from exover.syntax.lex import RESERVED

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")


class RenameRefused(Exception):
    """A symbol cannot get this name; the text tells the user why."""


@dataclass(frozen=True, slots=True)
class FileRename:
    """The places of one file that get the new name."""

    file: Source
    spans: tuple[Span, ...]

    @property
    def path(self) -> str:
        """The path of the file."""
        return self.file.name


def rename_everywhere(files: Files, path: str, symbol: SpecSymbol, name: str) -> list[FileRename]:
    """Return the places to rename; raises `RenameRefused`, also if some are in a file that other specs have, too."""
    changes = rename(files.together(path), symbol, name)
    for change in changes:
        if len(owners := files.owners(change.path)) > 1:
            raise RenameRefused(f"{change.path} belongs to {' and '.join(sorted(owners))}: rename it by hand")
    return changes


def rename(texts: list[tuple[str, TextAnalysis]], symbol: SpecSymbol, name: str) -> list[FileRename]:
    """Return the places to rename, file by file. Raises `RenameRefused`.

    `texts`: a spec and its properties files, or a properties file alone. None of them may have a diagnostic before or
    after.
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
        if isinstance(found.root, tree.Part):
            raise RenameRefused(f"{path} is a part of no spec that is known, or of several")
        after = _renamed(found, spans, name, spec)
        spec = after if isinstance(found.root, tree.Spec) else spec
        if after.diagnostics:
            raise RenameRefused(f"with {quote(name)}, {path} would have a mistake: {after.diagnostics[0].message}")
        if _alike(found) != _alike(after):
            raise RenameRefused(f"with {quote(name)}, a name in {path} would mean something else")
        changes += _by_file(found.source, spans)
    return changes


def _by_file(source: Source, spans: tuple[Span, ...]) -> list[FileRename]:
    files = ((file, tuple(span for span in spans if source.at(span.start) is file)) for file in source.files)
    return [FileRename(file, inside) for file, inside in files if inside]


def _renamed(found: TextAnalysis, spans: tuple[Span, ...], name: str, spec: TextAnalysis | None) -> TextAnalysis:
    files = {file.name: file.text for file in found.source.files}
    for change in _by_file(found.source, spans):
        files[change.file.name] = _changed(change, name)
    source = Source(found.source.name, files[found.source.name])
    match found.root:
        case tree.Properties():
            return analyse_properties(source, spec)
        case _:
            parts = tuple(Source(part.name, files[part.name]) for part in found.source.parts)
            return analyse_spec(source, None, parts_of(Source(source.name, source.text, parts=parts)))


def _changed(change: FileRename, name: str) -> str:
    text, base, parts, end = change.file.text, change.file.base, [], 0
    for span in change.spans:
        parts += [text[end : span.start - base], name]
        end = span.end - base
    return "".join([*parts, text[end:]])


def _alike(found: TextAnalysis) -> list[int]:
    """Return for each name of a text, in order, the number of the first name that stands for the same symbol."""
    ordered: list[SymbolOccurrence] = sorted(found.index.occurrences, key=lambda each: each.span)
    first: dict[SpecSymbol, int] = {}
    return [first.setdefault(each.symbol, number) for number, each in enumerate(ordered)]
