"""Where text is: sources, spans and positions.

A span counts characters (code points) of the decoded text, not bytes. Lines end with ``\\n`` or ``\\r\\n``; a
carriage return alone is a blank and ends no line. Lines and columns count from 1, and a tab is one column.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

TAB_WIDTH = 4
"""Blanks that one tab of a source line takes when the line is shown."""
_BLOCK = 1 << 10


class Span(NamedTuple):
    """The characters ``start <= offset < end`` of a text; empty (``start == end``) is the gap before ``start``.

    Nearly every node of a tree has one: a tuple takes half the time of a frozen dataclass to make.
    """

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
    _lines_before: list[int] = field(default_factory=list, init=False, repr=False, compare=False)

    def position(self, offset: int) -> tuple[int, int]:
        """Return line and column, both from 1, of the character at ``offset``.

        An offset behind the text counts as its end, one before it as its beginning.
        """
        inside = min(max(offset, 0), len(self.text))
        block = inside // _BLOCK
        lines = self._counts()[block] + self.text.count("\n", block * _BLOCK, inside)
        return lines + 1, inside - self.line_span(inside).start + 1

    def line_span(self, offset: int) -> Span:
        """Return the span of the line of the character at ``offset``, without its end of line."""
        inside = min(max(offset, 0), len(self.text))
        start = self.text.rfind("\n", 0, inside) + 1
        found = self.text.find("\n", inside)
        end = len(self.text) if found < 0 else found
        if end > start and self.text[end - 1] == "\r":
            end -= 1
        return Span(start, end)

    def slice(self, span: Span) -> str:
        """Return the characters of ``span``."""
        return self.text[span.start : span.end]

    def _counts(self) -> list[int]:
        """Return the number of line ends before each block of the text.

        Counted at the first question and kept: a list of all lines would be large where nearly nothing is asked.
        """
        counts = self._lines_before
        if not counts:
            counts.append(0)
            for start in range(0, len(self.text), _BLOCK):
                counts.append(counts[-1] + self.text.count("\n", start, start + _BLOCK))
        return counts
