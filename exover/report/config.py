"""`exover.toml`: reads waivers and a choice of checks from its text, or diagnostics."""

from collections.abc import Iterator, Mapping, Sequence
from datetime import date, datetime
from typing import Any

from exover.checks.questions.choice import ALL, CheckSelection, unknown
from exover.dataclass import dataclass
from exover.diagnostics import Diagnostic, Severity, did_you_mean, quote
from exover.model.model import Location
from exover.report.policy import WAIVABLE_ERRORS, Waiver, waivable
from exover.source import Source, Span
from exover.toml import Places, read_toml

TABLE = "waiver"
CHOICE = "check"
LISTS = ("only", "skip")
ERRORS_ONLY = "errors-only"
KEYS = ("check", "subject", "reason", "expires", "spec")
OPTIONAL = ("spec",)

Checks = Mapping[str, Severity]
"""All checks by name, with their severities."""


@dataclass(frozen=True, slots=True)
class Config:
    """The waivers in the order of the file, and the choice of checks, which counts unless the command line has one."""

    waivers: tuple[Waiver, ...] = ()
    choice: CheckSelection = ALL


NO_CONFIG = Config()


def read_config(source: Source, checks: Checks) -> tuple[Config, tuple[Diagnostic, ...]]:
    """Return a configuration, without the tables that have mistakes, and the mistakes in the order of the text."""
    read = read_toml(source)
    if isinstance(read, Diagnostic):
        return NO_CONFIG, (read,)
    content, places = read
    reader = _Reader(source, places, checks)
    found: list[tuple[Span | None, Sequence[Diagnostic]]] = []
    for name in content:
        if name not in (TABLE, CHOICE):
            advice = did_you_mean(name, [TABLE, CHOICE]) or f"a configuration holds [{CHOICE}] and [[{TABLE}]]"
            span = places.of(name)
            found.append((span, [Diagnostic("E602", f"unknown key {quote(name)}", span, help=advice)]))
    tables = content.get(TABLE, [])
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        advice, span = f"begin each waiver with a line `[[{TABLE}]]`", places.of(TABLE)
        found.append((span, [Diagnostic("E603", f"{quote(TABLE)} is no array of tables", span, help=advice)]))
        tables = []
    waivers: list[Waiver] = []
    for number, table in enumerate(tables):
        mistakes = list(reader.mistakes(number, table))
        found.append((places.of(TABLE, number), mistakes))
        if not mistakes:
            waivers.append(reader.waiver(number, table))
    chosen = content.get(CHOICE, {})
    mistakes = list(reader.choice_mistakes(chosen))
    choice = ALL if mistakes else reader.choice(chosen)
    found.append((places.of(CHOICE), mistakes))
    found.sort(key=lambda each: each[0] or Span(0, 0))
    return Config(tuple(waivers), choice), tuple(mistake for _, each in found for mistake in each)


@dataclass(frozen=True, slots=True)
class _Reader:
    source: Source
    places: Places
    checks: Checks

    def mistakes(self, number: int, table: dict[str, Any]) -> Iterator[Diagnostic]:
        """Yield the mistakes in a waiver."""
        for key, value in table.items():
            span = self.places.of(TABLE, number, key)
            if key not in KEYS:
                yield Diagnostic("E602", f"a waiver has no key {quote(key)}", span, help=did_you_mean(key, KEYS))
            elif key == "expires":
                if not isinstance(value, date) or isinstance(value, datetime):
                    yield Diagnostic("E603", "`expires` is no date", span, help="write it as 2027-01-31, unquoted")
            elif not isinstance(value, str):
                yield Diagnostic("E603", f"{quote(key)} is no text", span)
            elif not value.strip():
                yield Diagnostic("E603", f"{quote(key)} is empty", span, help="say it in words")
        for key in KEYS:
            if key not in table and key not in OPTIONAL:
                yield Diagnostic("E604", f"a waiver has no {quote(key)}", self.places.of(TABLE, number))
        if isinstance(table.get("check"), str):
            yield from self._check(table["check"], self.places.of(TABLE, number, "check"))

    def _check(self, name: str, span: Span | None) -> Iterator[Diagnostic]:
        if name not in self.checks:
            yield Diagnostic("E605", f"there is no check {quote(name)}", span, help=did_you_mean(name, self.checks))
        elif not waivable(name, self.checks[name]):
            names = ", ".join(check for check in self.checks if check in WAIVABLE_ERRORS)
            advice = f"of the errors only {names} may be waived; the others are what a checked spec guarantees"
            yield Diagnostic("E606", f"an error of {quote(name)} cannot be waived", span, help=advice)

    def choice_mistakes(self, table: Any) -> Iterator[Diagnostic]:
        """Yield the mistakes in the choice of checks."""
        if not isinstance(table, dict):
            advice = f"begin it with a line `[{CHOICE}]`"
            yield Diagnostic("E603", f"{quote(CHOICE)} is no table", self.places.of(CHOICE), help=advice)
            return
        for key, value in table.items():
            span = self.places.of(CHOICE, key)
            if key == ERRORS_ONLY:
                if not isinstance(value, bool):
                    yield Diagnostic(
                        "E603", f"{quote(key)} is neither true nor false", span, help="write one, unquoted"
                    )
            elif key not in LISTS:
                advice = did_you_mean(key, (*LISTS, ERRORS_ONLY))
                yield Diagnostic("E602", f"[{CHOICE}] has no key {quote(key)}", span, help=advice)
            elif not isinstance(value, list) or not all(isinstance(name, str) for name in value):
                yield Diagnostic("E603", f"{quote(key)} is no list of names", span, help=f'write {key} = ["safety"]')
            else:
                yield from (Diagnostic("E605", what, span, help=advice) for what, advice in unknown(value, self.checks))
        if isinstance(table.get("only"), list) and not table["only"]:
            span = self.places.of(CHOICE, "only")
            yield Diagnostic("E603", "`only` names no check", span, help="leave it out for all")

    def choice(self, table: dict[str, Any]) -> CheckSelection:
        """Return the choice of checks from a table without mistakes."""
        only, skip = (tuple(table.get(key, ())) for key in LISTS)
        return CheckSelection(only, skip, table.get(ERRORS_ONLY, False))

    def waiver(self, number: int, table: dict[str, Any]) -> Waiver:
        """Return the waiver from a table without mistakes."""
        span = self.places.of(TABLE, number)
        line, column = self.source.position(span.start) if span else (1, 1)
        spec = table.get("spec")
        here = Location(self.source.name, line, column)
        return Waiver(table["check"], table["subject"], table["reason"], table["expires"], spec, here)
