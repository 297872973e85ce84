"""One bit of the tables or of the state changes while the checker runs: nothing unsafe is launched, and it is found.

The spec has 50 requests and 150 mutexes; what is unsafe is read from the rules. `make faults` flips every bit in every
build; here a sample of them, a larger one in the build that is emitted, a smaller one under sanitizers.
"""

import os
import struct
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

from benchmarks.families import mutexes
from exover.bounds.sizes import scrub_steps
from exover.emit import c
from exover.model.model import Model
from exover.ocrd.packing import pack
from exover.pipeline import build
from tests.runtime.compiling import COMPILERS, SANITIZERS, WARNINGS, compile_c, model_of

ALL = bool(os.environ.get("EXOVER_ALL_FAULTS"))
SILENT = ("answers", "step")
"""What nobody reads before it is written again: a flip there is harmless, and nobody finds it."""


def excluded(model: Model) -> list[list[int]]:
    """Return 1 for every two requests that a mutex names."""
    number = {request.name: index for index, request in enumerate(model.requests)}
    rows = [[0] * len(number) for _ in number]
    for rule in model.rules:
        first, second = (number[part.request] for part in rule.condition.parts)  # type: ignore[union-attr]
        rows[first][second] = rows[second][first] = 1
    return rows


def flipped(tmp_path: Path, flags: Sequence[str], stride: int, fixed: bool) -> dict[str, tuple[int, int, int]]:
    """Return by place: bits flipped, those that were not found, launches that were unsafe."""
    model = model_of(mutexes(50))
    tables = build(model).tables
    for artefact in c.emit(model, tables, "mutexes"):
        (tmp_path / artefact.name).write_bytes(artefact.content)
    which = [] if fixed else ["-ffreestanding", "-DEXOVER_WIDTH=2"]
    sources = [Path(__file__).parent / "flips.c", tmp_path / "exover.c"]
    compile_c(COMPILERS[0], [*WARNINGS, *flags, *which, f"-I{tmp_path}"], sources, tmp_path / "flips")
    data = pack(tables)
    rows = [cell for row in excluded(model) for cell in row]
    head = [len(model.requests), *rows, scrub_steps(tables), len(data)]
    command = [tmp_path / "flips", str(stride)]
    done = subprocess.run(command, input=struct.pack(f"={len(head)}I", *head) + data, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()
    lines = [line.split() for line in done.stdout.decode().splitlines()]
    return {place: (int(flips), int(missed), int(unsafe)) for place, flips, missed, unsafe in lines}


@pytest.mark.parametrize(
    ("flags", "stride", "fixed"),
    [(("-O2",), 1 if ALL else 13, True), (("-O2",), 1 if ALL else 61, False), (SANITIZERS, 7 if ALL else 211, False)],
    ids=["emitted", "any tables", "with sanitizers"],
)
def test_no_flipped_bit_lets_anything_unsafe_pass(
    flags: Sequence[str], stride: int, fixed: bool, tmp_path: Path
) -> None:
    found = flipped(tmp_path, flags, stride, fixed)
    assert found.pop("sound") == (200, 0, 0)
    assert all(unsafe == 0 for _, _, unsafe in found.values()), found
    assert all(missed == 0 for place, (_, missed, _) in found.items() if place not in SILENT), found
    assert found["words"][0] > 68_000 // stride and found["state"][0] > 12_000 // stride
