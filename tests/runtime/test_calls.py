"""Calls with what no host should give are refused, each for its own reason, and nothing comes of them."""

import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

from exover.emit import c
from exover.pipeline import build
from exover.run.codec import FAULTY
from tests.runtime.compiling import (
    BAD_CHECKSUM,
    BAD_COUNTS,
    COMPILERS,
    FAULT_CHECKER,
    LIVE,
    MISALIGNED,
    NO_TABLES,
    NOT_LOADED,
    READY,
    SANITIZERS,
    WARNINGS,
    compile_c,
    model_of,
)

HERE = Path(__file__).parent
SPEC = """spec calls; module m { request a(v: real in 0 .. 2) fails (lost) { check v < 1.5; } request b(); }
mutex m.a, m.b;"""
UNKNOWN_REQUEST, MISSING_ARGUMENT, OUT_OF_RANGE, UNKNOWN_STATUS = 2, 5, 6, 7
RUNNING, UNKNOWN = 1, 5


def lines_of(folder: Path, flags: Sequence[str] = (), unchecked: bool = False) -> list[list[int]]:
    model = model_of(SPEC)
    for artefact in c.emit_tables(model, build(model, unchecked).tables, "calls"):
        (folder / artefact.name).write_bytes(artefact.content)
    sources = [HERE / "calls.c", folder / "calls_tables.c", folder / "exover.c"]
    compile_c(COMPILERS[0], [*WARNINGS, *SANITIZERS, *flags, f"-I{folder}"], sources, folder / "calls")
    done = subprocess.run([folder / "calls"], capture_output=True, text=True, check=True)
    return [list(map(int, line.split())) for line in done.stdout.splitlines()]


@pytest.fixture(scope="module", params=[(), ("-DEXOVER_WIDTH=2",)], ids=["emitted", "any tables"])
def lines(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> list[list[int]]:
    return lines_of(tmp_path_factory.mktemp("calls"), request.param)


def test_what_no_host_should_give_is_refused(lines: list[list[int]]) -> None:
    loads, started, events, copied, *_ = lines
    pointers, sizes = loads[:8], loads[8:]
    assert pointers == [NO_TABLES, 0, NO_TABLES, NO_TABLES, NO_TABLES, NO_TABLES, MISALIGNED, MISALIGNED]
    assert sizes == [BAD_CHECKSUM, *[BAD_COUNTS] * 6]
    assert started == [NOT_LOADED, 1, READY, 0]
    *reasons, outside, nothing, running, fault = events
    assert reasons == [MISSING_ARGUMENT, 1, UNKNOWN_STATUS, UNKNOWN_REQUEST, OUT_OF_RANGE]
    assert (outside, nothing, running, fault) == (UNKNOWN, UNKNOWN, RUNNING, READY)
    assert copied == [FAULT_CHECKER, FAULT_CHECKER, 1, FAULT_CHECKER, 1, 0, READY, READY]


def test_bits_that_have_changed_between_calls_are_not_believed(lines: list[list[int]]) -> None:
    """Of what says that a checker is live; of the number and of the place of answers; of a phase and its complement."""
    live, changed = lines[4:]
    assert live == [1, LIVE, READY]
    (told, *denied, lost, moved), (phase, sound), aborts = changed[:5], changed[5:7], changed[7:]
    assert (told, denied, lost, moved) == (1, [1, FAULTY], 1, 1)
    assert (phase, sound, aborts) == (UNKNOWN, READY, [UNKNOWN_REQUEST, UNKNOWN_REQUEST])


def test_tables_tell_that_they_are_unchecked(tmp_path: Path) -> None:
    assert lines_of(tmp_path, ["-DEXOVER_WIDTH=2"], unchecked=True)[1] == [NOT_LOADED, 1, READY, 1]
