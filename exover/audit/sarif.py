"""Renders an audit as SARIF 2.1.0: a result for each divergence, located where its request is declared."""

from typing import Any

from exover.audit.result import Audit, MissionResult
from exover.audit.text import row_text
from exover.audit.trail import DIVERGENCES, ERRORS, AuditRow, RowKind
from exover.model.wire import escaped
from exover.report.sarif import FINGERPRINT, fingerprint_of, location_of, uri, written

RULES = {
    "launched": "the robot launched what the tables refuse or let wait",
    "ran": "the robot reports the end of what the tables had not launched",
    "kept": "the robot did not stop what the tables stop",
    "withheld": "the robot did not launch what the tables launch",
    "stopped": "the robot stopped what the tables let run",
    "otherwise": "the robot let wait what the tables reject, or rejected what they let wait",
}


def render(audit: Audit) -> str:
    """Return a SARIF log of one run as text with a final newline."""
    rules = [
        {
            "id": f"exover/audit/{kind}",
            "shortDescription": {"text": RULES[kind]},
            "defaultConfiguration": {"level": _level(kind)},
        }
        for kind in DIVERGENCES
    ]
    notices = [notice for mission in audit.missions for notice in _notices(mission)]
    missed = any(mission.error or mission.mistake_count for mission in audit.missions)
    return written(
        [
            {
                "tool": {"driver": {"name": "exover", "version": audit.version, "rules": rules}},
                "automationDetails": {"id": f"exover/audit/{audit.model.name}/"},
                "invocations": [
                    {"executionSuccessful": not missed, **({"toolExecutionNotifications": notices} if notices else {})}
                ],
                "columnKind": "unicodeCodePoints",
                "results": [_result(audit, mission, row) for mission in audit.missions for row in mission.rows],
                "properties": {"spec": audit.model.name, "missions": len(audit.missions)},
            }
        ]
    )


def _level(kind: RowKind) -> str:
    return "error" if kind in ERRORS else "note"


def _notices(mission: MissionResult) -> list[dict[str, Any]]:
    errors = [(None, mission.error)] if mission.error else []
    found = [*errors, *((each.line, each.text) for each in mission.mistakes)]
    return [
        {"level": "error", "message": {"text": escaped(text)}, "locations": [_at(mission, line)]}
        for line, text in found
    ]


def _at(mission: MissionResult, line: int | None) -> dict[str, Any]:
    region = {} if line is None else {"region": {"startLine": line}}
    return {"physicalLocation": {"artifactLocation": {"uri": uri(mission.name)}, **region}}


def _result(audit: Audit, mission: MissionResult, row: AuditRow) -> dict[str, Any]:
    declared = audit.model.request[row.request].location
    known = audit.model.name, mission.name, str(row.line), row.kind, row.request, str(row.instance)
    return {
        "ruleId": f"exover/audit/{row.kind}",
        "ruleIndex": DIVERGENCES.index(row.kind),
        "kind": "fail",
        "level": _level(row.kind),
        "message": {"text": escaped(f"{mission.name}:{row.line}: {row_text(audit.model, row)}")},
        "locations": [location_of(declared, audit.file)],
        "relatedLocations": [_at(mission, row.line)],
        "partialFingerprints": {FINGERPRINT: fingerprint_of(*known)},
    }
