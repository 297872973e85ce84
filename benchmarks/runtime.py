"""A whole step of the runtimes on random mutexes, in instructions and in time, beside what one would write by hand.

Instructions are those inside of `exover_ask` and `exover_report`, in Rust `ask` and `report`, counted by callgrind;
they do not depend on what else runs. Times are of whole runs of the runner, its loop included. Events are asks of any
request and reports of a request that is active, in two mixes: the limits are held against both.
"""

import re
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from random import Random
from shutil import which

from benchmarks import families
from benchmarks.measure import ROOT, Row
from benchmarks.robot import nanoseconds
from exover.engines.compiler import find_compiler
from exover.model.event import Ask, Event, Launched, Report
from exover.model.model import Model
from exover.ocrd.conflicts import conflicts
from exover.ocrd.machine import Machine
from exover.ocrd.tables import Tables
from exover.pipeline import build, load
from exover.run import native, rust
from exover.source import Source

FLAGS = ("-std=c99", "-O2", "-g")
RUST_FLAGS = ("-Copt-level=3", "-Cpanic=abort")
EVENTS = 3000
MIXES = (1 / 3, 0.45)
"""How many of the events are reports while anything is active: the more, the more launches and the fewer rejections."""
WHOLE, PLAIN, CHECK, BY_HAND, IN_RUST = "whole", "without scrubbing", "a check by hand", "a step by hand", "in Rust"
STEP = ("exover_ask*", "exover_report*")


@dataclass(frozen=True, slots=True)
class Program:
    """A compiled checker, the events that it reads, and the functions that are its steps."""

    path: Path
    lines: tuple[str, ...]
    steps: tuple[str, ...]

    def instructions(self) -> float | None:
        """Return the instructions of one step on average; nothing where there is no valgrind."""
        if which("valgrind") is None:
            return None
        toggles = [f"--toggle-collect={name}" for name in self.steps]
        command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", "--demangle=no", *toggles]
        command += [str(self.path), "1"]
        text = "\n".join(self.lines) + "\n"
        done = subprocess.run(command, input=text, capture_output=True, text=True, check=True)
        found = re.search(r"Collected : (\d+)", done.stderr)
        assert found is not None, done.stderr
        return int(found.group(1)) / len(self.lines)

    def nanoseconds(self, rounds: int) -> float:
        """Return the time of one step."""
        return nanoseconds(self.path, self.lines, rounds)


def steps(rounds: int) -> Iterator[Row]:
    """Yield instructions and times of one step at 50 and at 1 000 requests."""
    for size, limit in ((50, 300), (1000, 600)):
        with tempfile.TemporaryDirectory(prefix="exover-") as folder:
            yield from _of_size(Path(folder), size, limit, rounds)


def _of_size(folder: Path, size: int, limit: int, rounds: int) -> Iterator[Row]:
    loaded = load(Source("mutexes.exo", families.mutexes(size)))
    assert loaded.model is not None
    model, tables = loaded.model, build(loaded.model).tables
    programs: dict[str, tuple[Path, tuple[str, ...]]] = {
        WHOLE: (_compiled(folder, model, tables, ()), STEP),
        PLAIN: (_compiled(folder, model, tables, ("-DEXOVER_SCRUB=0",)), STEP),
        CHECK: (_by_hand(folder, model, ()), ("hand_ask", "hand_report")),
        BY_HAND: (_by_hand(folder, model, ("-DWHOLE",)), ("step_ask", "step_report")),
    }
    if which("rustc") and which("nm"):
        programs[IN_RUST] = _in_rust(folder, model, tables)
    engine = native.NativeEngine(model, tables)
    for share in MIXES:
        title = f"C, one step, {size} requests in {families.DEGREE * size} mutexes, {100 * share:.0f} % reports"
        lines = tuple(map(engine.line, stream(model, tables, share)))
        ready = {name: Program(path, lines, functions) for name, (path, functions) in programs.items()}
        yield from _rows(title, limit, "instr", {name: each.instructions() for name, each in ready.items()})
        times = {name: each.nanoseconds(rounds) for name, each in ready.items()}
        yield from _rows(title, 100 if size == 50 else None, "ns", times)


def _rows(title: str, limit: float | None, unit: str, figures: Mapping[str, float | None]) -> Iterator[Row]:
    """Yield what a step takes in each program, if all are known."""
    known = {name: figure for name, figure in figures.items() if figure is not None}
    if len(known) < len(figures):
        return
    check, step = known[CHECK], known[BY_HAND]
    yield Row(title, known[WHOLE], unit, limit)
    yield Row("  without scrubbing", known[PLAIN], unit)
    yield Row("  times a bare check of the masks by hand", known[WHOLE] / check, "", 3, f"{check:.3g} {unit}")
    yield Row("  times a step with masks by hand", known[WHOLE] / step, "", None, f"{step:.3g} {unit}")
    if IN_RUST in known:
        yield Row("  the same in Rust", known[IN_RUST], unit)


def _in_rust(folder: Path, model: Model, tables: Tables) -> tuple[Path, tuple[str, ...]]:
    """Return the runner in Rust, and what the functions that are its steps are called."""
    program = rust.build(model, tables, folder, RUST_FLAGS)
    symbols = subprocess.run(["nm", program], capture_output=True, text=True, check=True).stdout.split()
    return program, tuple(name for name in symbols if re.search(r"Checker.*(3ask|6report)17h", name))


def stream(model: Model, tables: Tables, share: float) -> list[Event]:
    """Return random events that end in the initial state; so many of them are reports while anything is active."""
    lot, machine = Random(1), Machine(model, tables)
    names = [request.name for request in model.requests]
    active: list[str] = []
    events: list[Event] = []
    while len(events) < EVENTS or active:
        ending = len(events) >= EVENTS or (active and lot.random() < share)
        event = Report(active.pop(lot.randrange(len(active))), 0, "ok") if ending else Ask(lot.choice(names))
        active += [action.request for action in machine.step(event) if isinstance(action, Launched)]
        events.append(event)
    return events


def _compiled(folder: Path, model: Model, tables: Tables, flags: Sequence[str]) -> Path:
    own = folder / f"exover{len(flags)}"
    own.mkdir()
    return native.build(model, tables, own, (*FLAGS, *flags))


def _by_hand(folder: Path, model: Model, flags: Sequence[str]) -> Path:
    size = len(model.requests)
    words = (size + 63) // 64
    masks = [sum(1 << other for other in row) for row in conflicts(model)]
    rows = [[mask >> 64 * word & (1 << 64) - 1 for word in range(words)] for mask in masks]
    text = ",\n".join("{" + ", ".join(f"UINT64_C({mask:#x})" for mask in row) + "}" for row in rows)
    head = f"#include <stdint.h>\nenum {{ REQUESTS = {size}, WORDS = {words} }};\n"
    (folder / "rows.h").write_text(f"{head}static const uint64_t rows[REQUESTS][WORDS] = {{\n{text}\n}};\n")
    source, program = ROOT / "benchmarks" / "handwritten.c", folder / f"handwritten{len(flags)}"
    command = [*find_compiler(), *FLAGS, *flags, f"-I{folder}", str(source), "-o", str(program)]
    subprocess.run(command, check=True)
    return program
