"""Finds the file that an `include` at a place names."""

from itertools import pairwise

from exover.source import Source
from exover.syntax.includes import joined
from exover.syntax.lex import STRING, string_value, tokens


def included_at(document: Source, offset: int) -> str | None:
    """Return the path of the file that the `include` at an offset names; None if no such path stands there.

    The file need not exist. The text may have mistakes.
    """
    for word, path in pairwise(tokens(document.text, [], base=document.base)):
        if path.start > offset:
            return None
        if word.text == "include" and path.kind == STRING and offset <= path.end:
            return joined(document.name, string_value(path.text))
    return None
