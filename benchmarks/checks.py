"""How long checks take on large specs, each in a process of its own with a time limit, beside other tools."""

import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from benchmarks import dala, families, nusmv
from benchmarks.measure import ROOT, Row, Run, watched
from exover.engines.smv.program import in_wheel

GUARDED = ((1000, 3000, 100, 10.0), (2500, 9900, 100, 60.0))
"""Requests, mutexes, fail contexts, and the seconds that are allowed."""
MEGABYTES = 1024
PATIENCE = 60.0
"""Seconds after which a row without a limit of its own is given up."""
QUEUES = (16, 24, 32, 48, 64)


def ask(text: str, limit: float, *checks: str) -> Run:
    """Return what it took to ask these checks of a spec, from its text; no check: all error checks."""
    with tempfile.TemporaryDirectory() as folder:
        spec = Path(folder, "family.exo")
        spec.write_text(text)
        return watched([sys.executable, "-m", "benchmarks.ask", str(spec), *checks], limit, ROOT)


def guarded(slow: bool) -> Iterator[Row]:
    """Yield time and memory of all error checks on random mutexes with fail contexts."""
    for size, count, failing, seconds in GUARDED if slow else GUARDED[:1]:
        run = ask(families.guarded(size, count, failing), seconds)
        what = f"error checks: {size} requests, {count} mutexes, {failing} fail contexts"
        yield Row(what, run.seconds, "s", seconds, note=run.said, whole=run.whole)
        yield Row(
            "    its memory", run.megabytes, "MiB", MEGABYTES, note="until it was given up" * run.late, whole=run.whole
        )


def queues(slow: bool) -> Iterator[Row]:
    """Yield the time for mutual exclusion and freedom of deadlocks of requests that wait for each other."""
    program = in_wheel()
    for size in QUEUES:
        seconds = 10.0 if size == max(QUEUES) else PATIENCE
        run = ask(families.queues(size), seconds, "safety", "deadlock")
        limit = seconds if size == max(QUEUES) else None
        what = f"safety, deadlock: {size} requests waiting in a graph"
        yield Row(what, run.seconds, "s", limit, note=run.said, whole=run.whole)
        if program and (slow or size <= 48):
            its, states = nusmv.reachable(program, size, families.conflicts(size), PATIENCE)
            note = f"{states} states" if states else its.said
            yield Row("    NuSMV: reachable set of the same requests", its.seconds, "s", note=note)
    if not program:
        print("NuSMV: not measured, the wheel of pyboolnet is not installed")


def modules() -> Iterator[Row]:
    """Yield the time for all error checks of modules as large as those whose freedom of deadlocks D-Finder proved."""
    for size in dala.SIZES:
        run = ask(dala.spec(size), 5.0)
        what = f"error checks: {size.components} components, {size.locations} locations"
        yield Row(what, run.seconds, "s", 5.0, f"{size.time} {size.name}", run.said, run.whole)
