"""Quick fixes: one change of the text that removes a mistake: the nearest name, the meant word, a missing `;`."""

import re

from exover.dataclass import dataclass
from exover.diagnostics import Diagnostic
from exover.source import Source, Span

_MEANT = re.compile(r"did you mean `([^`…]+)`\?\Z|write `(?![^`]*(?:[A-Z]{2}|\b[a-z]\b))([^`…]+)`\Z")
"""Matches advice that is one change; placeholders, as `CONDITION` and `a`, do not match."""
_SIGNS = frozenset("<>=")
"""Characters of operators of other languages (`<>`, `=<`, `=>`), of which a mistake is at one character only."""


@dataclass(frozen=True, slots=True)
class Fix:
    """A change: its title, the span that is replaced, and the new text."""

    title: str
    span: Span
    text: str


def fix(diagnostic: Diagnostic, source: Source) -> Fix | None:
    """Return the change that removes a mistake of a text; None if no single change is known."""
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
    return Fix(f"replace with `{text}`", span, text)


def _sign(source: Source, span: Span) -> Span:
    """Return the span of the whole operator around one of its characters."""
    text, start, end = source.text, span.start - source.base, span.end - source.base
    while start > 0 and text[start - 1] in _SIGNS:
        start -= 1
    while end < len(text) and text[end] in _SIGNS:
        end += 1
    return Span(source.base + start, source.base + end)
