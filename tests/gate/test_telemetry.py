"""Decisions as spans and counters, with the SDK of OpenTelemetry where it is installed."""

import json

import pytest

pytest.importorskip("opentelemetry.sdk")
from opentelemetry import metrics, trace
from opentelemetry.sdk.metrics import MeterProvider
from opentelemetry.sdk.metrics.export import InMemoryMetricReader
from opentelemetry.sdk.trace import TracerProvider
from opentelemetry.sdk.trace.export import SimpleSpanProcessor
from opentelemetry.sdk.trace.export.in_memory_span_exporter import InMemorySpanExporter

from exover.gate.journal import no_journal
from exover.gate.telemetry import with_telemetry


def test_decisions_are_spans_and_counted() -> None:
    spans, reader = InMemorySpanExporter(), InMemoryMetricReader()
    tracers = TracerProvider()
    tracers.add_span_processor(SimpleSpanProcessor(spans))
    trace.set_tracer_provider(tracers)
    metrics.set_meter_provider(MeterProvider([reader]))
    journal = with_telemetry(no_journal)
    actions = [{"kill": "m.go", "instance": 0, "rule": "r"}, {"wait": "m.halt", "rule": "r"}]
    journal(json.dumps({"event": {"ask": "m.halt", "args": {}}, "actions": actions}))
    journal('{"refused": "m.go", "rule": "starting"}')
    journal('{"alarm": "stray", "request": "m.go", "instance": 0}')
    (span,) = spans.get_finished_spans()
    assert dict(span.attributes or {}) == {"exover.event": "ask", "exover.subject": "m.halt"}
    assert [event.name for event in span.events] == ["kill", "wait"]
    data = reader.get_metrics_data()
    assert data is not None
    found = {
        each.name: sum(point.value for point in each.data.data_points)  # type: ignore[union-attr]
        for each in data.resource_metrics[0].scope_metrics[0].metrics
    }
    assert found == {"exover.gate.actions": 2, "exover.gate.refusals": 1, "exover.gate.alarms": 1}
