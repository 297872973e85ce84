"""Calls with what no host should give are refused, each for its own reason, and nothing comes of them."""

import subprocess
from pathlib import Path

from exover.emit import c
from exover.pipeline import build
from tests.runtime.compiling import (
    COMPILERS,
    FAULT_CHECKER,
    MISALIGNED,
    READY,
    SANITIZERS,
    WARNINGS,
    compile_c,
    model_of,
)

HERE = Path(__file__).parent
SPEC = """spec calls; module m { request a(v: real in 0 .. 2) fails (lost) { check v < 1.5; } request b(); }
mutex m.a, m.b;"""
NO_TABLES = 2
UNKNOWN_REQUEST, MISSING_ARGUMENT, OUT_OF_RANGE, UNKNOWN_STATUS = 2, 5, 6, 7
RUNNING, UNKNOWN = 1, 5


def lines_of(folder: Path, unchecked: bool) -> list[list[int]]:
    model = model_of(SPEC)
    for artefact in c.emit_tables(model, build(model, unchecked).tables, "calls"):
        (folder / artefact.name).write_bytes(artefact.content)
    sources = [HERE / "calls.c", folder / "calls_tables.c", folder / "exover.c"]
    compile_c(COMPILERS[0], [*WARNINGS, *SANITIZERS, f"-I{folder}"], sources, folder / "calls")
    done = subprocess.run([folder / "calls"], capture_output=True, text=True, check=True)
    return [list(map(int, line.split())) for line in done.stdout.splitlines()]


def test_what_no_host_should_give_is_refused(tmp_path: Path) -> None:
    loads, started, events, copied = lines_of(tmp_path, unchecked=False)
    assert loads == [NO_TABLES, 0, NO_TABLES, NO_TABLES, NO_TABLES, NO_TABLES, MISALIGNED, MISALIGNED]
    assert started == [1, READY, 0]
    *reasons, outside, nothing, running, fault = events
    assert reasons == [MISSING_ARGUMENT, 1, UNKNOWN_STATUS, UNKNOWN_REQUEST, OUT_OF_RANGE]
    assert (outside, nothing, running, fault) == (UNKNOWN, UNKNOWN, RUNNING, READY)
    assert copied == [FAULT_CHECKER, FAULT_CHECKER, 1, FAULT_CHECKER, READY, READY]


def test_tables_tell_that_they_are_unchecked(tmp_path: Path) -> None:
    assert lines_of(tmp_path, unchecked=True)[1] == [1, READY, 1]
