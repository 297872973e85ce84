"""The text of a part: what stands in it for sure, and in comments what was left open."""

import os
from collections.abc import Iterable
from dataclasses import field

from exover.dataclass import dataclass
from exover.resolve import resolve
from exover.source import Source
from exover.syntax.layout import formatted
from exover.syntax.lex import RESERVED, string_literal
from exover.syntax.parse import parse_file
from exover.syntax.tree import Spec

TYPE_WORDS = frozenset({"bool", "int", "real"})
"""What no enum may be called."""
WITHOUT_REQUEST = "E422"
"""What is wrong with a spec without requests, and not with a part."""


@dataclass(frozen=True, slots=True)
class Remark:
    """What was left open: where in what was imported (`FILE:LINE`), and what."""

    place: str
    text: str

    def __str__(self) -> str:
        """Return it on one line."""
        return " ".join(f"{self.place}: {self.text}".split())


class UnreadableDescription(Exception):
    """A text is none of its language; the place is `FILE:LINE:COLUMN`, or less of it."""

    def __init__(self, place: str, message: str) -> None:
        super().__init__(f"{place}: {message}")


@dataclass(frozen=True, slots=True)
class Imported:
    """A part, in the canonical layout, and what was left open in it, which stands in its comments, too."""

    text: str
    remarks: tuple[Remark, ...]


@dataclass(frozen=True, slots=True)
class ImportedField:
    """A parameter, a returned value or a reading; `kind` is its type in exo, None if it has none there."""

    name: str
    kind: str | None
    place: str
    why: str = ""
    """Why it has no type, or what its type does not say."""


@dataclass(slots=True)
class PartText:
    """Collects the lines of a part, and what is left open."""

    lines: list[str] = field(default_factory=list)
    remarks: list[Remark] = field(default_factory=list)

    def say(self, text: str) -> None:
        """Add a comment."""
        self.lines += [f"// {line}" for line in text.splitlines() if line.strip()]

    def leave_open(self, place: str, text: str) -> None:
        """Add what is left open, as a comment and as a remark."""
        remark = Remark(place, text)
        if remark not in self.remarks:
            self.remarks.append(remark)
            self.say(f"{near(place)}: {' '.join(text.split())}")

    def name(self, name: str, place: str, reserved: frozenset[str] = RESERVED) -> str:
        """Return a name as exo can have it."""
        found = spelt(name, reserved)
        if found != name:
            self.leave_open(place, f"`{name}` is a word of exo, and is called `{found}`")
        return found

    def fields(self, fields: Iterable[ImportedField], taken: Iterable[str] = ()) -> str:
        """Return parameters or results as the list of a request has them; those without a type are left out."""
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
        """Return the type of a field of this name, if it has one; what that does not say is left open."""
        if found.why:
            what = "is left out" if found.kind is None else f"is taken for `{found.kind}`"
            self.leave_open(found.place, f"`{name}` {what}: {found.why}")
        return found.kind

    def poster(self, name: str, kind: str, initial: str, place: str) -> None:
        """Add a poster; its first value is a guess."""
        self.leave_open(place, f"`{name}` is taken to be {initial} until it is first observed")
        self.lines.append(f"poster {self.name(name, place)}: {kind} = {initial};")

    def finished(self, name: str, head: str) -> Imported:
        """Return the part: its head, and the lines so far. `name` is that of what was imported.

        Raises `UnreadableDescription` if that declares what cannot stand in one spec, such as two services of one name.
        """
        source = Source(name, "\n".join([head, *self.lines]) + "\n")
        text, mistakes = formatted(source)
        found = parse_file(source).tree
        assert text is not None and found is not None, mistakes
        _, mistakes = resolve(Spec(found.name, found.items, found.span), source)
        for mistake in mistakes:
            if isinstance(found, Spec) or mistake.code != WITHOUT_REQUEST:
                raise UnreadableDescription(name, mistake.message)
        return Imported(text, tuple(self.remarks))


def spelt(name: str, reserved: frozenset[str] = RESERVED) -> str:
    """Return a name as it is called in exo."""
    return f"{name}_" if name in reserved else name


def module_head(name: str, title: str) -> str:
    """Return how the block of a module begins."""
    shown = " ".join(title.split())
    return f"module {name} {string_literal(shown)} {{" if shown else f"module {name} {{"


def near(place: str) -> str:
    """Return a place without the folder of its file, which is another one on another machine."""
    return os.path.basename(place)
