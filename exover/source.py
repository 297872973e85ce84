"""Where text is: sources, spans and positions.

A span counts characters (code points) of the decoded text, not bytes. Lines end with ``\\n`` or ``\\r\\n``; a
carriage return alone is a blank and ends no line. Lines and columns count from 1, and a tab is one column.

Offsets go on from a text to those that it includes: each has a range of offsets of its own, and a gap of one between
two of them, so that an offset alone says in which file it is.
"""

from bisect import bisect_right
from dataclasses import field
from typing import NamedTuple

from exover.dataclass import dataclass

STDIN = "<stdin>"
"""The name of a text from standard input."""
TAB_WIDTH = 4
"""The number of blanks that replace a tab when a source line is shown."""
_BLOCK = 1 << 10


class Span(NamedTuple):
    """The characters ``start <= offset < end`` of a text; empty (``start == end``) is the gap before ``start``.

    It is a tuple because nearly every node of a tree has one: making a frozen dataclass takes twice the time.
    """

    start: int
    end: int


class SourcePlace(NamedTuple):
    """The place of a character: the name of its file, line and column."""

    file: str
    line: int
    column: int


@dataclass(frozen=True, slots=True)
class Source:
    """A text and the name under which messages quote it; `base` is the offset of its first character.

    `parts` are the texts that it includes, directly or not, in the order of their offsets.
    """

    name: str
    text: str
    base: int = 0
    parts: tuple["Source", ...] = ()
    _lines_before: list[int] = field(default_factory=list, init=False, repr=False, compare=False)

    @property
    def end(self) -> int:
        """The offset after the last character of this text, not counting its parts."""
        return self.base + len(self.text)

    @property
    def span(self) -> Span:
        """The span of this text without its parts."""
        return Span(self.base, self.end)

    @property
    def files(self) -> tuple["Source", ...]:
        """This text and its parts."""
        return (self, *self.parts)

    def at(self, offset: int) -> "Source":
        """Return the text that contains an offset: this one, or one of its parts."""
        number = bisect_right(self.parts, offset, key=lambda part: part.base)
        return self.parts[number - 1] if number else self

    def place(self, offset: int) -> SourcePlace:
        """Return file, line and column of the character at ``offset``; as `position`."""
        return SourcePlace(self.at(offset).name, *self.position(offset))

    def position(self, offset: int) -> tuple[int, int]:
        """Return line and column, both from 1, of the character at ``offset`` in its file.

        An offset after the text counts as its end, one before it as its beginning.
        """
        file = self.at(offset)
        inside = file._inside(offset)
        block = inside // _BLOCK
        lines = file._counts()[block] + file.text.count("\n", block * _BLOCK, inside)
        return lines + 1, inside - file.text.rfind("\n", 0, inside)

    def line_span(self, offset: int) -> Span:
        """Return the span of the line of the character at ``offset``, without its end of line."""
        file = self.at(offset)
        inside = file._inside(offset)
        start = file.text.rfind("\n", 0, inside) + 1
        found = file.text.find("\n", inside)
        end = len(file.text) if found < 0 else found
        if end > start and file.text[end - 1] == "\r":
            end -= 1
        return Span(file.base + start, file.base + end)

    def slice(self, span: Span) -> str:
        """Return the characters of ``span``, which lies in one file."""
        file = self.at(span.start)
        return file.text[span.start - file.base : span.end - file.base]

    def _inside(self, offset: int) -> int:
        return min(max(offset - self.base, 0), len(self.text))

    def _counts(self) -> list[int]:
        """Return the number of line ends before each block of the text.

        Counted at the first use and kept: a list of all lines would be too large for few uses.
        """
        counts = self._lines_before
        if not counts:
            counts.append(0)
            for start in range(0, len(self.text), _BLOCK):
                counts.append(counts[-1] + self.text.count("\n", start, start + _BLOCK))
        return counts
