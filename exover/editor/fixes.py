"""Quick fixes: one change of the text that removes a mistake: the nearest name, the meant word, a missing `;`."""

import re
from collections.abc import Iterator, Sequence
from difflib import SequenceMatcher

from exover.dataclass import dataclass
from exover.diagnostics import Diagnostic
from exover.editor.analysis import TextAnalysis
from exover.editor.files import Files
from exover.source import Source, Span

_MEANT = re.compile(r"did you mean `([^`…]+)`\?\Z|write `(?![^`]*(?:[A-Z]{2}|\b[a-z]\b))([^`…]+)`\Z")
"""Matches advice that is one change; placeholders, as `CONDITION` and `a`, do not match."""
_WORD = re.compile(r"([A-Za-z_][A-Za-z0-9_]*)[ \t\r\n]*\Z")
_SYNTAX = "E1"
_NEAR = 200
_SIGNS = frozenset("<>=")
"""Characters of operators of other languages (`<>`, `=<`, `=>`), of which a mistake is at one character only."""


@dataclass(frozen=True, slots=True)
class Fix:
    """A change: its title, the span that is replaced, and the new text."""

    title: str
    span: Span
    text: str

    def applied(self, source: Source) -> str:
        """Return a text with the change."""
        start, end = self.span.start - source.base, self.span.end - source.base
        return source.text[:start] + self.text + source.text[end:]


def fixes(
    files: Files, path: str, document: Source, mistakes: Sequence[Diagnostic]
) -> Iterator[tuple[Diagnostic, Fix]]:
    """Yield the mistakes of a document that one change removes, each with that."""
    for each in mistakes:
        if change := fix(each, document):
            after = files.supposed(path, change.applied(document))
            if after and removes(change, each, document, after):
                yield each, change


def fix(diagnostic: Diagnostic, source: Source) -> Fix | None:
    """Return the change that a mistake advises; None if that is no single one.

    The word that is meant stands for the one that it resembles: that of the mistake, or the one before.
    """
    if diagnostic.span is None:
        return None
    if diagnostic.code == "E107":
        return Fix("insert `;`", Span(diagnostic.span.start, diagnostic.span.start), ";")
    meant = _MEANT.search(diagnostic.help)
    if meant is None:
        return None
    text, span = meant[1] or meant[2], diagnostic.span
    if source.slice(span) in _SIGNS:
        span = _sign(source, span)
        if span == diagnostic.span:  # blanks separate the characters of the operator
            return None
    before = _word_before(source, span)
    if before and _likeness(source.slice(before), text) > _likeness(source.slice(span), text):
        span = before
    return Fix(f"replace with `{text}`", span, text)


def removes(change: Fix, diagnostic: Diagnostic, source: Source, after: TextAnalysis) -> bool:
    """Return whether a mistake is gone after a change, none stands where text was changed, and the text can be read.

    Of a text that cannot be read now, other mistakes may be left.

    `after`: the analysis of the changed text.
    """
    assert diagnostic.span is not None
    if not diagnostic.code.startswith(_SYNTAX) and any(each.code.startswith(_SYNTAX) for each in after.mistakes):
        return False
    longer = len(change.text) - (change.span.end - change.span.start)
    start = min(change.span.start, diagnostic.span.start) - source.base
    end = max(change.span.end, diagnostic.span.end) - source.base + longer
    base = after.document.base
    left = (Span(each.span.start - base, each.span.end - base) for each in after.mistakes if each.span)
    return not any(each.start < end and start < max(each.end, each.start + 1) for each in left)


def _word_before(source: Source, span: Span) -> Span | None:
    """Return the span of the word before a span, if only blanks are between; else None."""
    end = span.start - source.base
    start = max(end - _NEAR, 0)
    found = _WORD.search(source.text[start:end])
    return Span(*(source.base + start + each for each in found.span(1))) if found else None


def _likeness(word: str, other: str) -> float:
    return SequenceMatcher(None, word, other).ratio()


def _sign(source: Source, span: Span) -> Span:
    """Return the span of the whole operator around one of its characters."""
    text, start, end = source.text, span.start - source.base, span.end - source.base
    while start > 0 and text[start - 1] in _SIGNS:
        start -= 1
    while end < len(text) and text[end] in _SIGNS:
        end += 1
    return Span(source.base + start, source.base + end)
