"""Collects the mistakes of one spec, without duplicates, in the order of the text."""

from collections.abc import Callable, Iterable
from dataclasses import field, replace

from exover.dataclass import dataclass
from exover.diagnostics import Diagnostic, capped, did_you_mean, quote
from exover.source import Source, Span

MAX_HINTS = 50
"""The most unknown names for which near known names are looked for; further ones get no advice."""
MAX_KNOWN = 6
"""The most known names that a message lists if none is near."""
MAX_LINES = 5
"""The most further uses of one unknown name that a message lists."""

Candidates = Callable[[], Iterable[str]]


@dataclass(slots=True)
class Mistakes:
    """The mistakes found so far in `source`."""

    source: Source
    _found: dict[tuple[str, Span], Diagnostic] = field(default_factory=dict)
    _unknown: dict[tuple[str, str, str], list[Diagnostic]] = field(default_factory=dict)
    _consequences: list[Diagnostic] = field(default_factory=list)

    def add(self, code: str, message: str, span: Span, *, label: str = "", hint: str = "") -> None:
        """Note a mistake, unless one of the same code at the same place is noted."""
        self._found.setdefault((code, span), Diagnostic(code, message, span, label, hint))

    def unknown(
        self, code: str, message: str, name: str, span: Span, candidates: Candidates, hint: str = "", scope: str = ""
    ) -> None:
        """Note that `name` is not known in `scope`, once for all its uses.

        Without a `hint` the advice is the nearest candidate, or all of them if they are few.
        """
        uses = self._unknown.setdefault((code, scope, name), [])
        if not uses and not hint and len(self._unknown) <= MAX_HINTS:
            hint = did_you_mean(name, known := list(candidates())) or known_here(known)
        uses.append(Diagnostic(code, message, span, help=hint or (uses[0].help if uses else "")))

    def again(self, name: str, what: str, span: Span, first: Span) -> None:
        """Note that a name is declared a second time in its scope."""
        label = f"first declared {self.on_line(first, span)}"
        self.add("E210", f"{what} {quote(name)} is declared twice", span, label=label)

    def on_line(self, span: Span, here: Span) -> str:
        """Return in words where `span` begins: its line, and its file if that is not the file of `here`."""
        file, line, column = self.source.place(span.start)
        return f"on line {line}" if file == self.source.at(here.start).name else f"at {file}:{line}:{column}"

    def unless_others(self, code: str, message: str, span: Span, hint: str) -> None:
        """Note a mistake that may be a consequence of another one: it is returned only if there are no others."""
        self._consequences.append(Diagnostic(code, message, span, help=hint))

    def in_order(self) -> tuple[Diagnostic, ...]:
        """Return the mistakes in the order of the text, at most MAX_REPORTS and one that counts the rest."""
        found = [*self._found.values(), *(self._first(uses) for uses in self._unknown.values())] or self._consequences
        return capped(sorted(found, key=lambda mistake: (mistake.span.start if mistake.span else 0, mistake.code)))

    def _first(self, uses: list[Diagnostic]) -> Diagnostic:
        """Return the diagnostic of the first use in the text, with the lines of the others as its label."""
        ordered = sorted({use.span.start: use for use in uses if use.span}.items())
        first = ordered[0][1]
        here = self.source.at(ordered[0][0]).name
        places = [self.source.place(start) for start, _ in ordered[1:]]
        lines = list(dict.fromkeys(f"{'' if file == here else f'{file}:'}{line}" for file, line, _ in places))
        if not lines:
            return first
        listed = ", ".join(lines[:MAX_LINES])
        more = " and more" if len(lines) > MAX_LINES else ""
        return replace(first, label=f"used again on line{'s' if len(lines) > 1 else ''} {listed}{more}")


def known_here(names: list[str]) -> str:
    """Return the known names in words if they are at most MAX_KNOWN, else ""."""
    return f"known here: {', '.join(map(quote, names))}" if 0 < len(names) <= MAX_KNOWN else ""


def same_name(taken: dict[str, Span], name: str, span: Span) -> Span | None:
    """Return the span of an earlier declaration of the name, or record this one and return None."""
    first = taken.setdefault(name, span)
    return None if first is span else first
