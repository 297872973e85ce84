"""Builds the text of an imported part; what the import leaves open becomes comments and remarks."""

import os
from collections.abc import Iterable
from dataclasses import field

from exover.dataclass import dataclass
from exover.escaping import visible
from exover.resolve import resolve
from exover.source import Source
from exover.syntax.layout import formatted
from exover.syntax.lex import RESERVED, string_literal
from exover.syntax.parse import parse_file
from exover.syntax.tree import Spec

TYPE_WORDS = frozenset({"bool", "int", "real"})
"""Names that no enum may have."""
WITHOUT_REQUEST = "E422"
"""The code of the mistake that a spec has no request; a part needs none."""


@dataclass(frozen=True, slots=True)
class Remark:
    """What an import left open, and its place in the imported description (`FILE:LINE`)."""

    place: str
    text: str

    def __str__(self) -> str:
        """Return the remark on one line."""
        return " ".join(f"{self.place}: {self.text}".split())


class UnreadableDescription(Exception):
    """A description cannot be read; `place`: `FILE:LINE:COLUMN`, `FILE:LINE` or `FILE`."""

    def __init__(self, place: str, message: str) -> None:
        super().__init__(f"{place}: {message}")


@dataclass(frozen=True, slots=True)
class Imported:
    """A part in the canonical layout, and remarks on what was left open, which its comments have too."""

    text: str
    remarks: tuple[Remark, ...]


@dataclass(frozen=True, slots=True)
class ImportedField:
    """A parameter, a result or a reading; `kind`: its type in exo, None if exo has no such type."""

    name: str
    kind: str | None
    place: str
    why: str = ""
    """Why it has no type in exo, or what its type in exo loses."""


@dataclass(slots=True)
class PartText:
    """Collects the lines and the remarks of a part."""

    lines: list[str] = field(default_factory=list)
    remarks: list[Remark] = field(default_factory=list)

    def say(self, text: str) -> None:
        """Add a comment."""
        self.lines += [f"// {line}" for line in text.splitlines() if line.strip()]

    def leave_open(self, place: str, text: str) -> None:
        """Add a remark, and the comment for it, unless it is there already."""
        remark = Remark(place, text)
        if remark not in self.remarks:
            self.remarks.append(remark)
            self.say(f"{near(place)}: {' '.join(text.split())}")

    def name(self, name: str, place: str, reserved: frozenset[str] = RESERVED) -> str:
        """Return a name as `spelt` does, with a remark if it is changed."""
        found = spelt(name, reserved)
        if found != name:
            self.leave_open(place, f"`{name}` is a word of exo, and is called `{found}`")
        return found

    def fields(self, fields: Iterable[ImportedField], taken: Iterable[str] = ()) -> str:
        """Return the list of parameters or results of a request, without those in `taken` and those without a type."""
        known = frozenset(map(spelt, taken))
        shown = []
        for each in fields:
            if spelt(each.name) in known:
                self.leave_open(each.place, f"`{spelt(each.name)}` goes in and comes out: what comes out is left out")
                continue
            name = self.name(each.name, each.place)
            if kind := self.kind(name, each):
                shown.append(f"{name}: {kind}")
        return ", ".join(shown)

    def kind(self, name: str, found: ImportedField) -> str | None:
        """Return the type of a field in exo, None if it has none; add a remark if it has none or loses something."""
        if found.why:
            what = "is left out" if found.kind is None else f"is taken for `{found.kind}`"
            self.leave_open(found.place, f"`{name}` {what}: {found.why}")
        return found.kind

    def poster(self, name: str, kind: str, initial: str, place: str) -> None:
        """Add a poster, with a remark that its initial value is a guess."""
        self.leave_open(place, f"`{name}` is taken to be {initial} until it is first observed")
        self.lines.append(f"poster {self.name(name, place)}: {kind} = {initial};")

    def finished(self, name: str, head: str) -> Imported:
        """Return the part, `head` and the lines so far, formatted; `name`: of the file that was imported.

        Raises `UnreadableDescription` if the part has a mistake, as with two services of one name.
        """
        source = Source(name, "\n".join([head, *self.lines]) + "\n")
        text, mistakes = formatted(source)
        found = parse_file(source).tree
        if text is None or found is None:
            raise UnreadableDescription(name, mistakes[0].message)
        _, mistakes = resolve(Spec(found.name, found.items, found.span), source)
        for mistake in mistakes:
            if isinstance(found, Spec) or mistake.code != WITHOUT_REQUEST:
                raise UnreadableDescription(name, mistake.message)
        return Imported(text, tuple(self.remarks))


def spelt(name: str, reserved: frozenset[str] = RESERVED) -> str:
    """Return a name for exo, with `_` appended if it is reserved."""
    return f"{name}_" if name in reserved else name


def module_head(name: str, title: str) -> str:
    """Return the first line of the block of a module."""
    shown = visible(" ".join(title.split()))
    return f"module {name} {string_literal(shown)} {{" if shown else f"module {name} {{"


def near(place: str) -> str:
    """Return a place without the folder of its file, so that the text is the same on every machine."""
    return visible(os.path.basename(place))
