"""Where text is: sources, spans and positions.

A span counts characters (code points) of the decoded text, not bytes. Lines end with ``\\n`` or ``\\r\\n``; a
carriage return alone is a blank and ends no line. Lines and columns count from 1, and a tab is one column.
"""

from bisect import bisect_right
from dataclasses import dataclass, field

TAB_WIDTH = 4
"""Blanks that one tab of a source line takes when the line is shown."""


@dataclass(frozen=True, slots=True)
class Span:
    """The characters ``start <= offset < end`` of a text; empty (``start == end``) is the gap before ``start``."""

    start: int
    end: int

    def to(self, other: "Span") -> "Span":
        """Return the span from the beginning of this one to the end of ``other``."""
        return Span(self.start, other.end)


@dataclass(frozen=True, slots=True)
class Source:
    """A text and the name under which messages quote it."""

    name: str
    text: str
    _starts: list[int] = field(default_factory=list, init=False, repr=False, compare=False)

    def _line_starts(self) -> list[int]:
        # Found at the first question and kept: most sources are never asked, and some are large.
        if not self._starts:
            self._starts.append(0)
            at = self.text.find("\n")
            while at >= 0:
                self._starts.append(at + 1)
                at = self.text.find("\n", at + 1)
        return self._starts

    def position(self, offset: int) -> tuple[int, int]:
        """Return line and column, both from 1, of the character at ``offset``.

        An offset behind the text counts as its end, one before it as its beginning.
        """
        inside = min(max(offset, 0), len(self.text))
        starts = self._line_starts()
        line = bisect_right(starts, inside)
        return line, inside - starts[line - 1] + 1

    def line_span(self, line: int) -> Span:
        """Return the span of line number ``line`` (from 1) without its end of line."""
        starts = self._line_starts()
        start = starts[line - 1]
        end = starts[line] - 1 if line < len(starts) else len(self.text)
        if end > start and self.text[end - 1] == "\r":
            end -= 1
        return Span(start, end)

    def line_text(self, line: int) -> str:
        """Return line number ``line`` (from 1) without its end of line."""
        span = self.line_span(line)
        return self.text[span.start : span.end]

    def slice(self, span: Span) -> str:
        """Return the characters of ``span``."""
        return self.text[span.start : span.end]
