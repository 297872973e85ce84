"""The paper's robot: how long its check takes, how large its tables are, and how fast they decide."""

import statistics
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.measure import ROOT, Row, command, median_seconds
from exover import pipeline
from exover.bounds.sizes import sizes
from exover.model.event import Ask, Invalid
from exover.model.model import Model
from exover.model.wire_reading import read_event
from exover.run.native import NativeEngine, build
from exover.source import Source

SPEC = ROOT / "specs" / "diligent.exo"
MISSION = ROOT / "specs" / "diligent.mission.jsonl"
EVENTS = 1_000_000
FLAGS = ("-std=c99", "-O2")


def robot() -> Model:
    """Return the model of the robot Diligent."""
    model = pipeline.load(Source(SPEC.name, SPEC.read_text(encoding="utf-8"))).model
    assert model is not None
    return model


def processes(rounds: int) -> Iterator[Row]:
    """Yield whole processes, as the user waits for them."""
    for what, arguments, limit in (("--help", ["--help"], 0.06), ("check specs/diligent.exo", ["check", str(SPEC)], 1)):
        seconds, status = command(arguments, rounds)
        note = f"exit status {status}" if status else ""
        yield Row(f"exover {what}", 1000 * seconds, "ms", 1000 * limit, note=note)


def tables(rounds: int) -> Iterator[Row]:
    """Yield the figures of the tables that the paper gives too."""
    from exover.model.canonical import digest
    from exover.ocrd.compile import compile_model

    model = robot()
    figures = compile_model(model, digest(model)).figures
    yield Row("Diligent: nodes", figures.nodes, "", 100, "552")
    yield Row("Diligent: depth", figures.depth, "", 8, "17")
    yield Row("Diligent: tests before the first action", figures.tests, "", None, "13")
    seconds = median_seconds(lambda: compile_model(model, digest(model)), rounds)
    yield Row("Diligent: compile the model", 1000 * seconds, "ms", 100, "67 s")


def runtime(rounds: int) -> Iterator[Row]:
    """Yield the mean time of the C runtime for one event: of the recorded mission, and of its asks alone.

    Without reports everything that is asked for stays taken: the asks are refused or wait, and are decided again.
    """
    model = robot()
    built = pipeline.build(model)
    read = [read_event(model, line) for line in MISSION.read_bytes().splitlines()]
    mission = [event for event in read if not isinstance(event, Invalid)]
    asks = [event for event in mission if isinstance(event, Ask)]
    bound = f"at most {sizes(built.tables).tests} tests an event, {built.tables.limits[0].tests} a walk"
    with NativeEngine(model, built.tables) as engine, tempfile.TemporaryDirectory() as folder:
        program = build(model, built.tables, Path(folder), FLAGS)
        of_mission = nanoseconds(program, [engine.line(event) for event in mission], rounds)
        yield Row("C runtime: event of the recorded mission", of_mission, "ns", 100, "50 µs", bound)
        of_asks = nanoseconds(program, [engine.line(event) for event in asks], rounds)
        note = "several decisions a step: whatever waits is decided again"
        yield Row("C runtime: ask, with everything taken", of_asks, "ns", None, "", note)


def nanoseconds(program: Path, lines: Sequence[str], rounds: int) -> float:
    """Return the median of the mean processor times for one of the events, taken over some `EVENTS` of them."""
    repeats = EVENTS // len(lines) + 1
    text = "\n".join(lines)
    found = []
    for _ in range(rounds):
        done = subprocess.run([program, str(repeats)], input=text, capture_output=True, text=True, check=True)
        seconds = float(done.stdout.split()[0])
        found.append(1e9 * seconds / (repeats * len(lines)))
    return statistics.median(found)
