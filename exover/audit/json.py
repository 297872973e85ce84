"""Renders an audit as JSON, and reads it again for `exover report --audit`."""

import json
import math
from typing import Any

from exover.audit.result import Audit, MissionResult, rules_of
from exover.audit.text import last_line, row_text
from exover.audit.trail import ANSWERS, COUNTED, DIVERGENCES, AuditRow, MissionFigures
from exover.model.model import Model
from exover.model.wire import Json, indented, number


def render(audit: Audit) -> str:
    """Return an audit as text: one JSON object with a final newline."""
    return indented(document(audit))


def document(audit: Audit) -> Json:
    """Return an audit as the object that is rendered."""
    from exover.model.canonical import digest

    return {
        "tool": "exover",
        "version": audit.version,
        "audit": audit.model.name,
        "file": audit.file,
        "sha256": digest(audit.model).hex(),
        "outcome": last_line(audit),
        "missions": [_mission(audit.model, mission) for mission in audit.missions],
        "total": _figures(audit.model, audit.total),
    }


def _mission(model: Model, mission: MissionResult) -> Json:
    if mission.error:
        return {"mission": mission.name, "error": mission.error}
    return {
        "mission": mission.name,
        **_figures(model, mission.figures),
        "divergences": [_row(model, row) for row in mission.rows],
        "mistakes": [{"line": each.line, "text": each.text} for each in mission.mistakes],
        "mistake_count": mission.mistake_count,
        "notes": list(mission.notes),
    }


def _figures(model: Model, figures: MissionFigures) -> Json:
    asks: dict[str, dict[str, int]] = {}
    for request in model.requests:
        counts: dict[str, int] = {answer: figures.asks[request.name, answer] for answer in ANSWERS[:4]}
        if any(counts.values()):
            asks[request.name] = counts
    return {
        **{name: getattr(figures, name) for name in COUNTED},
        "diverged": {kind: figures.diverged[kind] for kind in DIVERGENCES},
        "asks": asks,
        "rules": {rule: figures.used[rule] for rule in rules_of(model)},
    }


def _row(model: Model, row: AuditRow) -> Json:
    found: dict[str, Any] = {"line": row.line}
    if not math.isnan(row.time):
        found["time"] = number(row.time)
    found |= {"kind": row.kind, "request": row.request}
    if row.instance is not None:
        found["instance"] = row.instance
    if row.answer != "none":
        found["answer"] = row.answer
    return found | ({"rule": row.rule} if row.rule else {}) | {"text": row_text(model, row)}


# ---- read again ----

_FIGURES = {"asks": {"*": dict.fromkeys(ANSWERS[:4], int)}, "rules": {"*": int}}
_MISSION = {
    "mission": str,
    "events": int,
    **_FIGURES,
    "diverged": {"*": int},
    "divergences": [{"line": int, "text": str}],
    "mistakes": [{"line": int, "text": str}],
    "mistake_count": int,
    "notes": [str],
}
_MISSED = {"mission": str, "error": str}
_AUDIT = {
    "tool": str,
    "audit": str,
    "sha256": str,
    "outcome": str,
    "missions": [],
    "total": _FIGURES,
}
"""The shape of what a page reads: objects by key (`*`: any key), lists by their element, `int` for a count."""
_MOST = 1 << 64


class NoAudit(Exception):
    """The text is no rendered audit."""


def read(text: str) -> Json:
    """Return what a page shows of a rendered audit; raises `ValueError` if it is no JSON, `NoAudit` if no audit."""
    try:
        found = json.loads(text, parse_constant=_finite, parse_float=_finite, parse_int=_count)
    except RecursionError as error:
        raise NoAudit from error
    audit: Json = _part(found, _AUDIT)
    if audit["tool"] != "exover":
        raise NoAudit
    return audit | {"missions": [_mission_of(each) for each in audit["missions"]]}


def _mission_of(found: object) -> Json:
    missed = isinstance(found, dict) and found.get("error")
    mission: Json = _part(found, _MISSED if missed else _MISSION)
    return mission


def _finite(text: str) -> float:
    if not math.isfinite(float(text)):
        raise ValueError(f"{text} is no number")
    return float(text)


def _count(digits: str) -> int:
    return int(digits) if len(digits) <= len(str(_MOST)) else _MOST


def _part(found: object, shape: object) -> Any:
    """Return the parts of a value that the shape names; raises `NoAudit` if it has another shape."""
    match shape:
        case dict() if isinstance(found, dict):
            if "*" in shape:
                return {key: _part(each, shape["*"]) for key, each in found.items()}
            if shape.keys() <= found.keys():
                return {key: _part(found[key], each) for key, each in shape.items()}
        case list() if isinstance(found, list):
            return [_part(each, shape[0]) if shape else each for each in found]
        case type() if type(found) is shape and (not isinstance(found, int) or 0 <= found < _MOST):
            return found
        case _:
            pass
    raise NoAudit
