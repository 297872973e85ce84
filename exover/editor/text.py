"""Places in the Language Server Protocol: lines from 0, columns from 0 in code units of a position encoding."""

import re
from bisect import bisect_right
from functools import cached_property
from typing import Literal

from exover.dataclass import dataclass
from exover.source import Span

PositionEncoding = Literal["utf-8", "utf-16", "utf-32"]
Place = tuple[int, int]
"""A line and a column, both from 0."""
_END_OF_LINE = re.compile(r"\r\n|\n|\r")
_BYTES = {"utf-8": 1, "utf-16": 2, "utf-32": 4}
_CODECS = {"utf-8": "utf-8", "utf-16": "utf-16-le", "utf-32": "utf-32-le"}
_MARK = "\ufeff"


def without_mark(text: str, encoding: PositionEncoding) -> str:
    """Return a text whose byte order mark, if it begins with one, is replaced by blanks of the same width in units."""
    width = len(_MARK.encode(_CODECS[encoding])) // _BYTES[encoding]
    return " " * width + text[1:] if text.startswith(_MARK) else text


@dataclass(frozen=True)
class EditorText:
    """A text whose lines end as in the protocol: with a line feed, a carriage return, or both.

    `base` is the offset of its first character, as in a `Source`.
    """

    text: str
    encoding: PositionEncoding = "utf-16"
    base: int = 0

    @cached_property
    def _starts(self) -> list[int]:
        return [0, *(match.end() for match in _END_OF_LINE.finditer(self.text))]

    def place(self, offset: int) -> Place:
        """Return line and column of the character at an offset; one outside the text counts as its nearest end."""
        inside = min(max(offset - self.base, 0), len(self.text))
        line = bisect_right(self._starts, inside) - 1
        return line, self._units(self.text[self._starts[line] : inside])

    def offset(self, place: Place) -> int:
        """Return the offset of a place; a column behind a line counts as its end, a line behind the last as the end."""
        line, column = place
        if line >= len(self._starts):
            return self.base + len(self.text)
        start = self._starts[line]
        found = _END_OF_LINE.search(self.text, start)
        content = self.text[start : found.start() if found else len(self.text)]
        cut = content.encode(_CODECS[self.encoding], "surrogatepass")[: max(column, 0) * _BYTES[self.encoding]]
        return self.base + start + len(cut.decode(_CODECS[self.encoding], "ignore"))

    def range(self, span: Span) -> tuple[Place, Place]:
        """Return the places where a span begins and ends."""
        return self.place(span.start), self.place(span.end)

    def line(self, number: int) -> Span:
        """Return the span of a line, from 0, without its line end; for one behind the last, the end of the text.

        Lines are counted as in a `Source`: a carriage return alone ends none.
        """
        start = 0
        for _ in range(number):
            start = self.text.find("\n", start) + 1
            if start == 0:
                return Span(self.base + len(self.text), self.base + len(self.text))
        found = self.text.find("\n", start)
        end = len(self.text) if found < 0 else found
        return Span(self.base + start, self.base + start + len(self.text[start:end].rstrip("\r")))

    def _units(self, part: str) -> int:
        return len(part.encode(_CODECS[self.encoding], "surrogatepass")) // _BYTES[self.encoding]
