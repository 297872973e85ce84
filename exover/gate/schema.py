"""The keys of the tables of a binding, with the types of their values (docs/binding.md)."""

import math
from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Any

from exover.dataclass import dataclass
from exover.diagnostics import Diagnostic, Severity, did_you_mean, quote
from exover.source import Span
from exover.toml import KeyPath, Places

DEPTH = 100
"""The most levels of tables and lists in what is sent: how many Python writes as JSON differs with its version."""

Allowed = tuple[Callable[[Any], bool], str]
"""A predicate that says whether a value is allowed, and what it should be, as text for a message."""


def _seconds(value: Any) -> bool:
    return _number(value) and value > 0


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _text(value: Any) -> bool:
    return isinstance(value, str) and bool(value.strip())


def _scalar(value: Any) -> bool:
    return isinstance(value, str | bool) or _number(value)


def _list(of: Callable[[Any], bool]) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, list) and all(map(of, value))


def _table(of: Callable[[Any], bool] = lambda value: True) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, dict) and all(map(of, value.values()))


def _of_json(value: Any, levels: int = DEPTH) -> bool:
    """Return whether a value can be written as JSON: no date, no NaN, no infinity, nothing nested too deep."""
    if not isinstance(value, dict | list):
        return _scalar(value)
    parts = value.values() if isinstance(value, dict) else value
    return levels > 0 and all(_of_json(part, levels - 1) for part in parts)


def one_of(*words: str) -> Allowed:
    """Return the type of values that are one of these words."""
    return words.__contains__, " or ".join(f'"{word}"' for word in words)


TEXT: Allowed = _text, "a text that is not empty"
BOOL: Allowed = (lambda value: isinstance(value, bool)), "true or false"
SECONDS: Allowed = _seconds, "a number of seconds above 0"
NUMBER: Allowed = _number, "a finite number"
SCALE: Allowed = (lambda value: _number(value) and value != 0), "a finite number that is not 0"
BYTES: Allowed = (
    (lambda value: isinstance(value, int) and not isinstance(value, bool) and value >= 1024),
    "at least 1024",
)
TEXTS: Allowed = _list(_text), 'a list of texts, as ["get_*"]'
STATUSES: Allowed = _list(_scalar), 'a list of statuses, as ["arrived", 4]'
TABLE: Allowed = _table(), "a table"
SENT: Allowed = (
    (lambda value: isinstance(value, dict) and _of_json(value)),
    "a table of what JSON has, without dates, NaN and infinities",
)
SCALARS: Allowed = _table(_scalar), 'a table of texts, numbers or bools, as { command = "move" }'
LISTS: Allowed = _table(_list(_scalar)), 'a table of lists of statuses, as { blocked = ["bumper"] }'
ANY: Allowed = (lambda value: True), "anything"

FILE: Mapping[str, Allowed] = {"gate": TABLE, "request": TABLE, "watch": TABLE, "poster": TABLE}
GATE: Mapping[str, Allowed] = {
    "spec": TEXT,
    "unbound": one_of("deny", "pass"),
    "pass": TEXTS,
    "hide": BOOL,
    "methods": one_of("pass", "deny"),
    "max-line": BYTES,
    "client-death": one_of("abort", "leave"),
    "start": one_of("idle"),
    "wait": SECONDS,
    "answer": SECONDS,
    "stop": SECONDS,
}
REQUEST: Mapping[str, Allowed] = {
    "tool": TEXT,
    "action": TEXT,
    "service": TEXT,
    "type": TEXT,
    "inner": TEXT,
    "when": SCALARS,
    "arguments": TABLE,
    "constants": SCALARS,
    "wait": SECONDS,
    "answer": SECONDS,
    "stop": SECONDS,
    "cancel": TABLE,
    "started": BOOL,
    "start": one_of("idle"),
    "report": TABLE,
    "refused": SCALARS,
}
CANCEL: Mapping[str, Allowed] = {"tool": TEXT, "arguments": SENT, "ends": BOOL}
REPORT: Mapping[str, Allowed] = {
    "watch": TEXT,
    "status": TEXT,
    "running": STATUSES,
    "ok": STATUSES,
    "interrupted": STATUSES,
    "failed": STATUSES,
    "fails": LISTS,
    "results": TABLE,
}
WATCH: Mapping[str, Allowed] = {
    "tool": TEXT,
    "notification": TEXT,
    "topic": TEXT,
    "type": TEXT,
    "arguments": SENT,
    "every": SECONDS,
    "stale": SECONDS,
    "latched": BOOL,
}
FIELD: Mapping[str, Allowed] = {
    "field": TEXT,
    "scale": SCALE,
    "offset": NUMBER,
    "values": SCALARS,
    "default": ANY,
}
POSTER: Mapping[str, Allowed] = {"watch": TEXT, **{key: FIELD[key] for key in ("field", "scale", "offset", "values")}}


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

    def table(self, path: KeyPath, found: Any, keys: Mapping[str, Allowed], what: str) -> dict[str, Any]:
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
