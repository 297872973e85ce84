"""Finds the file that an `include` at a place names, and the paths that may stand there."""

import os
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import suppress
from itertools import islice

from exover.dataclass import dataclass
from exover.source import Source, Span
from exover.syntax.includes import joined
from exover.syntax.lex import STRING, Token, string_value, tokens
from exover.syntax.parse import MAX_TOKENS

MAX_FOLDERS = 200
"""The most folders in which parts are looked for."""
_REFUSED = frozenset('"\\')
"""What stands in no path that is proposed, and need not be escaped therefore."""


@dataclass(frozen=True, slots=True)
class WrittenPath:
    """The path of an `include` that is being written: what is before the place, and the span of all of it."""

    before: str
    span: Span


def included_at(document: Source, offset: int) -> str | None:
    """Return the path of the file that the `include` at an offset names; None if no such path stands there.

    The file need not exist. The text may have mistakes.
    """
    found = _path_at(document, offset)
    return joined(document.name, string_value(found.text)) if found else None


def written_at(document: Source, offset: int) -> WrittenPath | None:
    """Return the path of the `include` at an offset, which may be half written; None if none stands there."""
    found = _path_at(document, offset)
    if found is None or offset == found.start:
        return None
    before, behind = found.text[1 : offset - found.start], found.text[offset - found.start :]
    if not _REFUSED.isdisjoint(before):
        return None
    rest = behind.partition('"')[0].partition(";")[0].rstrip()
    return WrittenPath(before, Span(found.start + 1, offset + len(rest)))


def _path_at(document: Source, offset: int) -> Token | None:
    """Return the string behind `include` at an offset; None if there is none, or the text before is too large."""
    last: deque[str] = deque(("", ""), 2)
    for token in islice(tokens(document.text, [], base=document.base), MAX_TOKENS):
        if token.start > offset:
            return None
        if token.kind == STRING and last[1] == "include" and last[0] in (";", "}") and offset <= token.end:
            return token
        last.append(token.text)
    return None


def proposed_paths(name: str, before: str, is_part: Callable[[str], bool]) -> list[str]:
    """Return the paths that an `include` in a file may have, of which the text `before` is written.

    They are those of the parts in the folder that is named so far, or below it, and `../`.
    """
    named = before[: before.rfind("/") + 1]
    if not os.path.isabs(name) or named.startswith("/"):
        return []
    mine = os.path.realpath(name)
    found = [
        named + path
        for path in _specs_below(joined(name, named or "."))
        if os.path.realpath(place := joined(name, named + path)) != mine and is_part(place)
    ]
    return [*found, *([f"{named}../"] if set(named.split("/")) <= {"..", ""} else [])]


def _specs_below(folder: str) -> Iterator[str]:
    """Yield the paths of specs and parts in a folder and below, those of the upper folders first.

    Folders and files whose names begin with a point are left out, and folders behind links.
    """
    open_ends = deque([""])
    for _ in range(MAX_FOLDERS):
        if not open_ends:
            return
        here = open_ends.popleft()
        with suppress(OSError):  # it cannot be read
            for entry in sorted(os.scandir(os.path.join(folder, here)), key=lambda each: each.name):
                if entry.name.startswith(".") or not _REFUSED.isdisjoint(entry.name) or not entry.name.isprintable():
                    continue
                if entry.is_dir(follow_symlinks=False):
                    open_ends.append(f"{here}{entry.name}/")
                elif entry.name.endswith(".exo") and entry.is_file():
                    yield here + entry.name
