"""What mends a mistake by one change of the text: the nearest name, the word that is meant, a missing `;`."""

import re

from exover.dataclass import dataclass
from exover.diagnostics import Diagnostic
from exover.source import Span

_MEANT = re.compile(r"did you mean `([^`…]+)`\?\Z|write `(?![^`]*[A-Z]{2})([^`…]+)`\Z")
"""Advice that is one change; what stands for something else, as `CONDITION` does, is none."""


@dataclass(frozen=True, slots=True)
class Fix:
    """A change: what it is called, and what stands in the place of a span then."""

    title: str
    span: Span
    text: str


def fix(diagnostic: Diagnostic) -> Fix | None:
    """Return what mends a mistake; None if no single change is known to."""
    if diagnostic.span is None:
        return None
    if diagnostic.code == "E107":
        return Fix("insert `;`", Span(diagnostic.span.start, diagnostic.span.start), ";")
    meant = _MEANT.search(diagnostic.help)
    text = (meant[1] or meant[2]) if meant else ""
    return Fix(f"replace with `{text}`", diagnostic.span, text) if text else None
