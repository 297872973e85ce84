"""The keys of the tables of a binding, with the types of their values (docs/binding.md)."""

import math
from collections.abc import Mapping
from typing import Any

from exover.toml_schema import BOOL, TABLE, TEXT, AllowedValue, list_of, table_of

DEPTH = 100
"""The most levels of tables and lists in what is sent: how many Python writes as JSON differs with its version."""


def _seconds(value: Any) -> bool:
    return _number(value) and value > 0


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _scalar(value: Any) -> bool:
    return isinstance(value, str | bool) or _number(value)


def _of_json(value: Any, levels: int = DEPTH) -> bool:
    """Return whether a value can be written as JSON: no date, no NaN, no infinity, nothing nested too deep."""
    if not isinstance(value, dict | list):
        return _scalar(value)
    parts = value.values() if isinstance(value, dict) else value
    return levels > 0 and all(_of_json(part, levels - 1) for part in parts)


def one_of(*words: str) -> AllowedValue:
    """Return the type of values that are one of these words."""
    return words.__contains__, " or ".join(f'"{word}"' for word in words)


SECONDS: AllowedValue = _seconds, "a number of seconds above 0"
NUMBER: AllowedValue = _number, "a finite number"
SCALE: AllowedValue = (lambda value: _number(value) and value != 0), "a finite number that is not 0"
BYTES: AllowedValue = (
    (lambda value: isinstance(value, int) and not isinstance(value, bool) and value >= 1024),
    "at least 1024",
)
TEXTS: AllowedValue = list_of(TEXT[0]), 'a list of texts, as ["get_*"]'
STATUSES: AllowedValue = list_of(_scalar), 'a list of statuses, as ["arrived", 4]'
SENT: AllowedValue = (
    (lambda value: isinstance(value, dict) and _of_json(value)),
    "a table of what JSON has, without dates, NaN and infinities",
)
SCALARS: AllowedValue = table_of(_scalar), 'a table of texts, numbers or bools, as { command = "move" }'
LISTS: AllowedValue = table_of(list_of(_scalar)), 'a table of lists of statuses, as { blocked = ["bumper"] }'
ANY: AllowedValue = (lambda value: True), "anything"

FILE: Mapping[str, AllowedValue] = {"gate": TABLE, "request": TABLE, "watch": TABLE, "poster": TABLE}
GATE: Mapping[str, AllowedValue] = {
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
REQUEST: Mapping[str, AllowedValue] = {
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
CANCEL: Mapping[str, AllowedValue] = {"tool": TEXT, "arguments": SENT, "ends": BOOL}
REPORT: Mapping[str, AllowedValue] = {
    "watch": TEXT,
    "status": TEXT,
    "running": STATUSES,
    "ok": STATUSES,
    "interrupted": STATUSES,
    "failed": STATUSES,
    "fails": LISTS,
    "results": TABLE,
}
WATCH: Mapping[str, AllowedValue] = {
    "tool": TEXT,
    "notification": TEXT,
    "topic": TEXT,
    "type": TEXT,
    "arguments": SENT,
    "every": SECONDS,
    "stale": SECONDS,
    "latched": BOOL,
}
FIELD: Mapping[str, AllowedValue] = {
    "field": TEXT,
    "scale": SCALE,
    "offset": NUMBER,
    "values": SCALARS,
    "default": ANY,
}
POSTER: Mapping[str, AllowedValue] = {
    "watch": TEXT,
    **{key: FIELD[key] for key in ("field", "scale", "offset", "values")},
}
