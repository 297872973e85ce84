"""The keys that the tables of a TOML file may have, the types of their values, and the mistakes in a file."""

from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Any

from exover.dataclass import dataclass
from exover.diagnostics import Diagnostic, Severity, did_you_mean, quote
from exover.source import Span
from exover.toml import KeyPath, Places

AllowedValue = tuple[Callable[[Any], bool], str]
"""A predicate that says whether a value is allowed, and what it should be, as text for a message."""


def list_of(allowed: Callable[[Any], bool]) -> Callable[[Any], bool]:
    """Return whether a value is a list of allowed values, as a function of it."""
    return lambda value: isinstance(value, list) and all(map(allowed, value))


def table_of(allowed: Callable[[Any], bool]) -> Callable[[Any], bool]:
    """Return whether a value is a table whose values are allowed, as a function of it."""
    return lambda value: isinstance(value, dict) and all(map(allowed, value.values()))


TEXT: AllowedValue = (lambda value: isinstance(value, str) and bool(value.strip())), "a text that is not empty"
BOOL: AllowedValue = (lambda value: isinstance(value, bool)), "true or false"
TABLE: AllowedValue = (lambda value: isinstance(value, dict)), "a table"


@dataclass
class MistakeList:
    """Collects the mistakes of a file, with their places."""

    places: Places
    diagnostics: list[Diagnostic] = field(default_factory=list)
    spoilt: set[KeyPath] = field(default_factory=set)
    """Keys whose values have the wrong type; since they are there, they are not reported as missing as well."""

    def say(self, code: str, message: str, path: KeyPath, help: str = "", severity: Severity = "error") -> None:
        """Note a mistake at the place of a key, or of the nearest table around it."""
        self.diagnostics.append(Diagnostic(code, message, self.places.of(*path), help=help, severity=severity))

    def table(self, path: KeyPath, found: Any, keys: Mapping[str, AllowedValue], what: str) -> dict[str, Any]:
        """Return the entries of a table that have a known key and an allowed value; note each other one."""
        good: dict[str, Any] = {}
        if not isinstance(found, dict):
            self.say("E603", f"{what} is no table", path)
            return good
        for key, value in found.items():
            if key not in keys:
                advice = did_you_mean(key, keys) or f"there are {', '.join(f'`{each}`' for each in keys)}"
                self.say("E602", f"{what} has no key {quote(key)}", (*path, key), advice)
            elif not keys[key][0](value):
                self.say("E603", f"{quote(key)} is not {keys[key][1]}", (*path, key), f"write {keys[key][1]}")
                self.spoilt.add((*path, key))
            else:
                good[key] = value
        return good

    def missing(self, path: KeyPath, table: Mapping[str, Any], key: str) -> bool:
        """Return whether a key is neither in `table`, the good entries, nor present with a value of the wrong type."""
        whole = (*path, key)
        return key not in table and not any(whole[:length] in self.spoilt for length in range(1, len(whole) + 1))

    def sorted(self) -> tuple[Diagnostic, ...]:
        """Return the mistakes in the order of the text."""
        return tuple(sorted(self.diagnostics, key=lambda each: each.span or Span(0, 0)))
