"""Audits of recorded missions, end to end: a file is read, the emitted C is asked, divergences are gathered.

Seconds are those of the processor, in one process; compiling the checker, which is done once, is not in them.
"""

import json
import resource
import statistics
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from benchmarks import families
from benchmarks.measure import ROOT, Row
from benchmarks.runtime import stream
from exover.audit.auditor import Job, MissionAuditor
from exover.audit.binary import MissionWriter
from exover.audit.native import compile_library
from exover.model.event import Event
from exover.model.model import Model
from exover.model.wire import action_json, event_json
from exover.ocrd.machine import Machine
from exover.ocrd.tables import Tables
from exover.pipeline import build, load
from exover.run.simulate import lines_of
from exover.source import Source

EVENTS = 600_000
LINES, RECORDS = 2000, 200
"""Nanoseconds an event at most: 5e5 and 5e6 events a second."""


def missions(rounds: int) -> Iterator[Row]:
    """Yield what an event of a mission costs, from JSON lines and from records, and the memory that it takes."""
    loaded = load(Source("mutexes.exo", families.mutexes(50)))
    assert loaded.model is not None
    tables = build(loaded.model).tables
    events = stream(loaded.model, tables, 0.45)
    yield from _rows("50 requests in 150 mutexes", loaded.model, tables, events, rounds)
    spec = ROOT / "specs" / "diligent.exo"
    model = load(Source(spec.name, spec.read_text(encoding="utf-8"))).model
    assert model is not None
    yield from _rows("DILIGENT, its mission", model, build(model).tables, _recorded(model), rounds)


def _recorded(model: Model) -> list[Event]:
    from exover.model.event import Invalid
    from exover.model.wire_reading import read_event

    with (ROOT / "specs" / "diligent.mission.jsonl").open("rb") as file:
        read = [read_event(model, line) for line in lines_of(file) if line.strip()]
    return [event for event in read if not isinstance(event, Invalid)]


def _rows(title: str, model: Model, tables: Tables, events: list[Event], rounds: int) -> Iterator[Row]:
    repeats = EVENTS // len(events)
    with tempfile.TemporaryDirectory(prefix="exover-") as folder:
        lines, records, log = (Path(folder) / name for name in ("m.jsonl", "m.exor", "m.log"))
        log.write_text("".join(_decisions(model, tables, events)) * repeats)
        lines.write_text("".join(f"{json.dumps(event_json(model, event))}\n" for event in events) * repeats)
        with records.open("wb") as file:
            writer = MissionWriter(model, file)
            for _ in range(repeats):
                for event in events:
                    writer.write(event)
        auditor = MissionAuditor(Job(model, tables, compile_library(model, tables)))
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        for what, path, limit in (
            ("JSON lines", lines, LINES),
            ("a gate's log", log, LINES),
            ("records", records, RECORDS),
        ):
            took = statistics.median(_nanoseconds(auditor, path) for _ in range(rounds))
            yield Row(f"audit, {title}, from {what}", took, "ns", limit, "", f"{1e9 / took:.2g} events/s")
        grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
        yield Row("  memory that it took besides", grown, "MiB", None, "", f"{repeats * len(events)} events")
        auditor.close()


def _decisions(model: Model, tables: Tables, events: list[Event]) -> Iterator[str]:
    """Yield the lines of the log of a gate by the same rules."""
    machine = Machine(model, tables)
    for number, event in enumerate(events):
        actions = [action_json(model, action) for action in machine.step(event)]
        line = {"time": 1700000000 + number / 100, "event": event_json(model, event), "actions": actions}
        yield f"{json.dumps(line)}\n"


def _nanoseconds(auditor: MissionAuditor, path: Path) -> float:
    """Return the time of the processor for one event of a mission."""
    begin = time.process_time_ns()
    found = auditor.audit(str(path), path.name)
    took = time.process_time_ns() - begin
    assert not found.error and not found.mistakes, found
    return took / found.figures.events
