"""The files of a spec as one text: each part once, where it is first included (docs/language.md section 10)."""

import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import islice
from pathlib import PureWindowsPath
from typing import NamedTuple

from exover.diagnostics import MAX_REPORTS, Diagnostic, capped, quote
from exover.source import Source, Span
from exover.syntax.decode import MAX_BYTES, decode
from exover.syntax.lex import CONTROL, END, tokens
from exover.syntax.parse import parse, parse_file
from exover.syntax.tree import Include, Item, Part, Spec

MAX_NESTED = 64
"""The most files of which each includes the next."""

ReadPart = Callable[[str, int], bytes]
"""Returns the content of a file, at most so many bytes of it; raises `OSError` if it cannot be read."""

JoinPath = Callable[[str, str], str]
"""Returns the name of a file by the name of the file that includes it and the path there."""

ParseSpec = Callable[[Source], tuple[Spec | None, tuple[Diagnostic, ...]]]


class Gathered(NamedTuple):
    """A spec as one text.

    `source` is its text with those of its parts, `spec` the tree of all of it, None iff there are `mistakes`. `order`:
    the spans whose concatenation is the one text.
    """

    source: Source
    spec: Spec | None
    mistakes: tuple[Diagnostic, ...]
    order: tuple[Span, ...]


def gather(source: Source, read: ReadPart | None, parse: ParseSpec = parse, join: JoinPath | None = None) -> Gathered:
    """Return a spec with all that it includes. Paths in a file are relative to the folder of that file.

    Without `read` the text stands in no folder, and any include is a mistake. `parse` parses the text of the spec.
    `join` names the parts (default: `joined`, for files of this system).
    """
    tree, mistakes = parse(source)
    if tree is None or not any(isinstance(item, Include) for item in tree.items):
        return Gathered(source, tree, mistakes, (source.span,))
    reader = _Reader(source, read, join or joined)
    items = tuple(reader.items(source, tree, (source.name,), source.base))
    found = sorted(reader.mistakes, key=lambda mistake: mistake.span.start if mistake.span else 0)
    whole = Source(source.name, source.text, source.base, tuple(reader.parts))
    spec = None if found else Spec(tree.name, items, tree.span)
    return Gathered(whole, spec, capped(found, len(found) > MAX_REPORTS), tuple(reader.order))


def parts_of(source: Source) -> ReadPart:
    """Return a reader of the parts of a gathered text, which returns their texts from memory."""
    texts = {part.name: part.text for part in source.parts}
    return lambda path, most: texts[path].encode("utf-8", "surrogatepass")[:most]


def one_text(gathered: Gathered) -> str:
    """Return the one text: the text of each span of `order`, followed by a newline."""
    return "".join(gathered.source.slice(span) + "\n" for span in gathered.order)


def original(gathered: Gathered, offset: int) -> int:
    """Return the offset in the files that an offset of the one text stands for."""
    for span in gathered.order:
        length = span.end - span.start
        if offset <= length:
            return span.start + offset
        offset -= length + 1
    return gathered.source.end


class _Reader:
    """Reads the parts; it holds those read so far. `order` as in `Gathered`."""

    def __init__(self, root: Source, read: ReadPart | None, join: JoinPath) -> None:
        self.parts: list[Source] = []
        self.mistakes: list[Diagnostic] = []
        self.order: list[Span] = []
        self._read, self._join = read, join
        self._known = {os.path.realpath(root.name)}
        self._room = MAX_BYTES - len(root.text.encode("utf-8", "surrogatepass"))
        self._tokens = sum(token.kind != END for token in tokens(root.text, []))
        self._end = root.end

    def items(self, file: Source, tree: Spec | Part, chain: tuple[str, ...], start: int) -> Iterator[Item]:
        """Yield the items of a file, with those of its parts in the place of the includes.

        `chain`: the files from the spec to this one; `start`: the offset where its text begins, after the head.
        """
        for item in tree.items:
            if isinstance(item, Include):
                self.order.append(Span(start, item.span.start))
                yield from self._included(file, item, chain)
                start = item.span.end
            else:
                yield item
        self.order.append(Span(start, file.end))

    def _included(self, file: Source, include: Include, chain: tuple[str, ...]) -> Iterator[Item]:
        name = self._name(file, include, chain)
        part = name and self._part(name, include)
        if not part:
            return
        self.parts.append(part)
        self._end = part.end
        tree, mistakes, self._tokens = parse_file(part, self._tokens)
        self.mistakes += map(_of_part, mistakes)
        if isinstance(tree, Spec):
            message = f"{quote(include.path)} is a spec, and only a part can be included"
            self._refuse("E006", message, include, f"begin it with `part {tree.name.text};`")
        elif tree:
            yield from self.items(part, tree, (*chain, part.name), _behind_head(part))

    def _name(self, file: Source, include: Include, chain: tuple[str, ...]) -> str:
        """Return the name of an included file; "" if it was included before, or cannot be included (noted)."""
        fault = _fault(include.path)
        if fault:
            self._refuse("E008", f"{quote(include.path)} {fault}", include)
            return ""
        name = self._join(file.name, include.path)
        real = os.path.realpath(name)
        leading = [os.path.realpath(each) for each in chain]
        if self._read is None:
            message = f"{quote(include.path)} cannot be included: this text stands in no folder"
            self._refuse("E005", message, include, "keep it in a file, and name that")
        elif real in leading:
            circle = [*chain[leading.index(real) :], name]
            self._refuse("E007", f"{quote(name)} includes itself", include, label=" -> ".join(circle))
        elif len(chain) > MAX_NESTED:
            hint = "let one file include the parts side by side, not each part the next"
            self._refuse("E007", f"includes are nested more than {MAX_NESTED} deep", include, hint)
        elif real not in self._known:
            self._known.add(real)
            return name
        return ""

    def _part(self, name: str, include: Include) -> Source | None:
        """Return the text of an included file; None, with a mistake noted, if it cannot be read."""
        assert self._read
        try:
            data = self._read(name, max(self._room, 0) + 1)
        except (OSError, ValueError) as error:
            self._refuse("E005", f"cannot read {quote(name)}: {_reason(error)}", include)
            return None
        if len(data) > self._room:
            message = f"with {quote(name)} the spec is too large: more than {MAX_BYTES // (1024 * 1024)} MiB"
            self._refuse("E003", message, include)
            return None
        self._room -= len(data)
        source = decode(name, data)
        if isinstance(source, Diagnostic) or "\0" in source.text:
            reason = source.message if isinstance(source, Diagnostic) else "it is no text"
            self._refuse("E005", f"cannot read {quote(name)}: {reason}", include, "save that file as UTF-8 text")
            return None
        return Source(name, source.text, self._end + 1)

    def _refuse(self, code: str, message: str, include: Include, hint: str = "", label: str = "") -> None:
        self.mistakes.append(Diagnostic(code, message, include.span, label, hint))


def _of_part(mistake: Diagnostic) -> Diagnostic:
    """Return a mistake of an included text, worded for a part."""
    if mistake.code == "E004":
        return replace(mistake, message="the file holds no part", help="begin it with `part NAME;`")
    message, help = (text.replace("`spec NAME;`", "`part NAME;`") for text in (mistake.message, mistake.help))
    return replace(mistake, message=message, help=help)


def _reason(error: OSError | ValueError) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error)


def _fault(path: str) -> str:
    """Return why a path is not allowed in an include, "" if it is."""
    if not path or path.endswith("/"):
        return "names no file"
    if path.startswith("/") or PureWindowsPath(path).drive:
        return "is an absolute path: a path is relative to the folder of this file"
    if "\\" in path:
        return "has a `\\`: folders are parted by `/` on every system"
    return "has a control character" if CONTROL.search(path) else ""


def joined(name: str, path: str) -> str:
    """Return the name of a file by its path from another file; `..` is removed unless a symbolic link forbids it."""
    joined = os.path.join(os.path.dirname(name), *path.split("/"))
    plain = os.path.normpath(joined)
    return plain if os.path.realpath(plain) == os.path.realpath(joined) else joined


def _behind_head(part: Source) -> int:
    """Return the offset after `part NAME;`."""
    return list(islice(tokens(part.text, [], base=part.base), 3))[-1].end
