"""The findings as one JSON object (docs/checks.md), and the first step of reading one."""

import json
from collections.abc import Iterable
from dataclasses import asdict
from typing import Any, assert_never

from exover.checks.finding import Baselined, Excuse, Finding, Waived
from exover.model.event import Action, Event
from exover.model.model import Model
from exover.model.wire import action_json, event_json, indented
from exover.report.summary import BoundFigures, ModelFigures, Summary, TableFigures


def render(summary: Summary, timings: bool = False) -> str:
    """Return the object as text with a final newline."""
    return indented(document(summary, timings))


def document(summary: Summary, timings: bool) -> dict[str, Any]:
    """Return the object, its keys in the order of docs/checks.md.

    It has seconds, which differ from run to run, only with `timings`; without them equal input gives equal text. It has
    `baseline` and `excuse` only where there is a baseline or an excuse, `states` only if they were counted, `bounds`
    only if they were asked for, `skipped` only if some check was not asked, `properties` only if the summary has them.
    """
    figures, tables = summary.figures, summary.tables
    return {
        "tool": "exover",
        "version": summary.version,
        "spec": summary.model.name,
        "file": summary.file,
        **({"properties": summary.properties.file} if summary.properties else {}),
        "verdict": summary.verdict,
        "findings": [_finding(summary.model, finding, timings) for finding in summary.findings],
        **({"skipped": list(summary.skipped)} if summary.skipped else {}),
        "model": _model(figures),
        "tables": tables and _tables(tables),
    }


def _model(figures: ModelFigures) -> dict[str, Any]:
    return {
        "requests": figures.requests,
        "rules": figures.rules,
        "state_bits": figures.state_bits,
        **({"states": figures.states.number} if figures.states else {}),
    }


def _tables(tables: TableFigures) -> dict[str, Any]:
    return {
        "nodes": tables.nodes,
        "depth": tables.depth,
        "bytes": tables.bytes,
        "ram_bytes": tables.ram_bytes,
        "sha256": tables.sha256,
        **({"bounds": _bounds(tables.bounds)} if tables.bounds else {}),
    }


def _bounds(bounds: BoundFigures) -> dict[str, Any]:
    """Return the worst-case bounds over all events, of the stack, and of each event."""
    return {
        "tests": bounds.worst("tests")[0],
        "answers": bounds.worst("answers")[0],
        "passes": bounds.worst("passes")[0],
        "stack_bytes": bounds.stack_bytes,
        "stack_target": bounds.stack_target,
        "events": [asdict(event) for event in bounds.events],
        "method": bounds.method,
    }


def _finding(model: Model, finding: Finding, timings: bool) -> dict[str, Any]:
    trace, location = finding.trace, finding.location
    moments = trace and steps_json(model, [(moment.event, moment.actions) for moment in trace.moments])
    return {
        "check": finding.check,
        "subject": finding.subject,
        "severity": finding.severity,
        "verdict": finding.verdict,
        "engine": finding.engine,
        "method": finding.method,
        **({"seconds": round(finding.seconds, 6)} if timings else {}),
        "message": finding.message,
        "location": {"file": location.file, "line": location.line, "column": location.column},
        "trace": moments,
        "loop_start": trace.loop_start if trace else None,
        **({"baseline": finding.standing} if finding.standing else {}),
        **({"excuse": _excuse(finding.excuse)} if finding.excuse else {}),
    }


def steps_json(model: Model, steps: Iterable[tuple[Event, tuple[Action, ...]]]) -> list[dict[str, Any]]:
    """Return the steps of a run, events with their answers, as docs/checks.md writes them."""
    return [
        {"event": event_json(model, event), "actions": [action_json(model, action) for action in actions]}
        for event, actions in steps
    ]


def _excuse(excuse: Excuse) -> dict[str, str]:
    match excuse:
        case Waived(reason, expires):
            return {"kind": "waiver", "reason": reason, "expires": expires.isoformat()}
        case Baselined():
            return {"kind": "baseline"}
        case _:
            assert_never(excuse)


# ---- reading ----


class UnreadableReport(Exception):
    """A text is no report, or none that can be used so; the message tells the user why."""


def loaded(text: str) -> Any:
    """Return the JSON value that a text is; raises `UnreadableReport` if it is none."""
    try:
        return json.loads(text)
    except RecursionError as error:
        raise UnreadableReport("it is nested too deep") from error
    except ValueError as error:  # not JSON, or an integer of thousands of digits
        raise UnreadableReport(f"it is not JSON: {error}") from error
