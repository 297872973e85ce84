"""`exover.toml`: reads waivers and a choice of checks from its text, or diagnostics."""

from collections.abc import Iterator, Mapping
from datetime import date, datetime
from typing import Any

from exover.checks.questions.choice import ALL, CheckSelection, unknown
from exover.dataclass import dataclass
from exover.diagnostics import Diagnostic, Severity, did_you_mean, quote
from exover.model.model import Location
from exover.report.policy import WAIVABLE_ERRORS, Waiver, waivable
from exover.source import Source
from exover.toml import KeyPath, read_toml
from exover.toml_schema import BOOL, TABLE, TEXT, AllowedValue, MistakeList, list_of

WAIVER, CHOICE = "waiver", "check"
LISTS = ("only", "skip")
ERRORS_ONLY = "errors-only"

TABLES: AllowedValue = list_of(TABLE[0]), f"an array of tables, each below a line [[{WAIVER}]]"
NAMES: AllowedValue = list_of(TEXT[0]), 'a list of names, as ["safety"]'
DATE: AllowedValue = (
    (lambda value: isinstance(value, date) and not isinstance(value, datetime)),
    "a date, as 2027-01-31 without quotes",
)

FILE: Mapping[str, AllowedValue] = {CHOICE: TABLE, WAIVER: TABLES}
OF_CHOICE: Mapping[str, AllowedValue] = {**dict.fromkeys(LISTS, NAMES), ERRORS_ONLY: BOOL}
OF_WAIVER: Mapping[str, AllowedValue] = {"check": TEXT, "subject": TEXT, "reason": TEXT, "expires": DATE, "spec": TEXT}
REQUIRED = ("check", "subject", "reason", "expires")

Checks = Mapping[str, Severity]
"""All checks by name, with their severities."""


@dataclass(frozen=True, slots=True)
class Config:
    """The waivers in the order of the file, and the choice of checks, which counts unless the command line has one."""

    waivers: tuple[Waiver, ...] = ()
    choice: CheckSelection = ALL


NO_CONFIG = Config()


def read_config(source: Source, checks: Checks) -> tuple[Config | None, tuple[Diagnostic, ...]]:
    """Return a configuration, None if it has a mistake; and its mistakes in the order of the text."""
    read = read_toml(source)
    if isinstance(read, Diagnostic):
        return None, (read,)
    content, places = read
    mistakes = MistakeList(places)
    reader = _Reader(source, checks, mistakes)
    tables = mistakes.table((), content, FILE, "a configuration")
    waivers = tuple(reader.waivers(tables.get(WAIVER, [])))
    config = Config(waivers, reader.choice(tables.get(CHOICE, {})))
    told = mistakes.sorted()
    return (None if told else config), told


@dataclass(frozen=True, slots=True)
class _Reader:
    """Reads the tables of one file and notes every mistake."""

    source: Source
    checks: Checks
    mistakes: MistakeList

    def waivers(self, tables: list[Any]) -> Iterator[Waiver]:
        """Yield the waivers that have all that is required."""
        for number, table in enumerate(tables):
            path = (WAIVER, number)
            known = self.mistakes.table(path, table, OF_WAIVER, "a waiver")
            for key in REQUIRED:
                if self.mistakes.missing(path, known, key):
                    self.mistakes.say("E604", f"a waiver has no {quote(key)}", path)
            if "check" in known:
                self._note_unwaivable(known["check"], (*path, "check"))
            if known.keys() >= set(REQUIRED):
                yield Waiver(**{"spec": None, **known}, location=self._location(path))

    def _note_unwaivable(self, name: str, path: KeyPath) -> None:
        if name not in self.checks:
            self.mistakes.say("E605", f"there is no check {quote(name)}", path, did_you_mean(name, self.checks))
        elif not waivable(name, self.checks[name]):
            names = ", ".join(check for check in self.checks if check in WAIVABLE_ERRORS)
            advice = f"of the errors only {names} may be waived; the others are what a checked spec guarantees"
            self.mistakes.say("E606", f"an error of {quote(name)} cannot be waived", path, advice)

    def _location(self, path: KeyPath) -> Location:
        span = self.mistakes.places.of(*path)
        return Location(self.source.name, *(self.source.position(span.start) if span else (1, 1)))

    def choice(self, table: dict[str, Any]) -> CheckSelection:
        """Return the choice of checks, as far as it has no mistakes."""
        known = self.mistakes.table((CHOICE,), table, OF_CHOICE, f"[{CHOICE}]")
        for key in LISTS:
            for what, advice in unknown(known.get(key, ()), self.checks):
                self.mistakes.say("E605", what, (CHOICE, key), advice)
        if known.get("only") == []:
            self.mistakes.say("E603", "`only` names no check", (CHOICE, "only"), "leave it out for all")
        only, skip = (tuple(known.get(key, ())) for key in LISTS)
        return CheckSelection(only, skip, known.get(ERRORS_ONLY, False))
