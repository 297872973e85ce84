"""Diagnostics as tests expect them."""

from collections.abc import Iterable

from exover.diagnostics import CODES, Diagnostic
from exover.source import Source


def places_of(reports: Iterable[Diagnostic], text: str) -> list[str]:
    """Return code and place of each report on a text, as `E106 1:20`; every report has to have a place."""
    source, found = Source("t", text), []
    for report in reports:
        assert report.code in CODES
        assert report.span is not None
        line, column = source.position(report.span.start)
        found.append(f"{report.code} {line}:{column}")
    return found
