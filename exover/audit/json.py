"""An audit as JSON; what `exover report --audit` shows."""

import json
import math
from typing import Any

from exover.audit.result import Audit, MissionResult, rules_of
from exover.audit.text import last_line, row_text
from exover.audit.trail import ANSWERS, COUNTED, DIVERGENCES, AuditRow, MissionFigures
from exover.model.model import Model
from exover.model.wire import Json, escaped, number


def render(audit: Audit) -> str:
    """Return an audit as one object with a final newline."""
    return escaped(json.dumps(document(audit), ensure_ascii=False, indent=1)) + "\n"


def document(audit: Audit) -> Json:
    """Return the object."""
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
