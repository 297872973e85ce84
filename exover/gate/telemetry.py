"""Decisions of a gate as OpenTelemetry spans and counters; needs `opentelemetry-api` (extra `exover[otel]`)."""

import json
from collections.abc import Mapping
from time import time_ns
from typing import Any

from opentelemetry import metrics, trace

from exover import __version__
from exover.gate.gate import Journal

SCOPE = "exover.gate"
VERBS = ("launch", "wait", "reject", "kill", "violation", "invalid")


def with_telemetry(journal: Journal) -> Journal:
    """Return a journal that gives each entry to `journal`, then to the tracer and meter that the program has set up."""
    tracer = trace.get_tracer(SCOPE, __version__)
    meter = metrics.get_meter(SCOPE, __version__)
    actions = meter.create_counter("exover.gate.actions", description="what the tables have answered")
    refusals = meter.create_counter("exover.gate.refusals", description="what the gate has refused itself")
    alarms = meter.create_counter("exover.gate.alarms", description="alarms")

    def take(entry: str) -> None:
        journal(entry)
        said = json.loads(entry)
        if "alarm" in said:
            alarms.add(1, _attributes(kind=said["alarm"], request=said.get("request")))
        elif "refused" in said:
            refusals.add(1, _attributes(request=said["refused"], rule=said["rule"]))
        else:
            told = [_action(action) for action in said["actions"]]
            at = time_ns()
            span = tracer.start_span("exover.gate.decision", attributes=_event(said["event"]), start_time=at)
            for action in told:
                actions.add(1, action)
                span.add_event(str(action["exover.action"]), action, at)
            span.end(at)

    return take


def _event(event: Mapping[str, Any]) -> dict[str, str]:
    kind = next(key for key in ("ask", "report", "observe", "abort") if key in event)
    return _attributes(event=kind, subject=event[kind], outcome=event.get("outcome"))


def _action(action: Mapping[str, Any]) -> dict[str, str]:
    verb = next(verb for verb in VERBS if verb in action)
    return _attributes(action=verb, subject=action[verb], rule=action.get("rule"))


def _attributes(**found: str | None) -> dict[str, str]:
    return {f"exover.{name}": value for name, value in found.items() if value is not None}
