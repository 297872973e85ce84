"""One bit of tables or state changes while a checker of any rules runs: no launch that the rules forbid, in C and Rust.

`make faults` flips every bit of six specs that use every feature, each at six moments; here a sample. An optimizer
could take out what is kept twice, so all is optimized there, and here the spec with most features; the rest is not, for
that takes ten times as long to compile in C, and twice as long in Rust.
"""

import os
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest

from exover.emit import c
from exover.engines.compiler import compile_in
from exover.ocrd.packing import SECTIONS, is_checked
from exover.pipeline import Build
from exover.run import rust
from tests.runtime.compiling import COMPILERS, QUICK, ROOT, RUNTIME, WARNINGS, built, compile_c
from tests.runtime.resuming import FAST, FAST_CRATE, lines_of, needs_rustc

HERE = Path(__file__).parent
ALL = bool(os.environ.get("EXOVER_ALL_FAULTS"))
SPECS = ("corners", "corners2", "mixed1", "mixed5", "mixed6", "rover")
EVENTS = 6 * 60


@dataclass(frozen=True)
class Flips:
    """What came of flips: how many, how many nobody found, unsafe launches, answers that differed otherwise."""

    flips: int
    missed: int
    unsafe: int
    differ: int


def spec_of(name: str) -> Build:
    return built(ROOT / "tests/vectors" / f"{name}.exo")


def run(program: Path, found: Build) -> dict[str, Flips]:
    command, lines = [program, str(stride(found))], lines_of(found, EVENTS, seed=7)
    done = subprocess.run(command, input=lines, capture_output=True, text=True, check=False)
    assert done.returncode == 0, (done.returncode, done.stderr)
    return {place: Flips(*map(int, rest)) for place, *rest in map(str.split, done.stdout.splitlines())}


def optimized(found: Build) -> bool:
    """Return whether the checker of a spec is compiled as for a robot."""
    return ALL or found is spec_of(SPECS[0])


def stride(found: Build) -> int:
    """Return which of so many bits are flipped: more where a flip is quick."""
    return 1 if ALL else 41 if optimized(found) else 397


def of_c(found: Build, folder: Path) -> dict[str, Flips]:
    for artefact in c.emit_tables(found.model, found.tables, "native"):
        (folder / artefact.name).write_bytes(artefact.content)
    runner = (RUNTIME / "runner.c").read_text().replace("int main(", "int runner_main(int, char **);\nint runner_main(")
    (folder / "beside.c").write_text(runner + (HERE / "beside.c").read_text())
    sources = [folder / name for name in ("beside.c", "native_tables.c", "exover.c")]
    compiler, level = (COMPILERS[0], "-O2") if optimized(found) else (QUICK, "-O0")
    compile_c(compiler, [*WARNINGS, "-Wno-conversion", level, f"-I{folder}"], sources, folder / "beside")
    return run(folder / "beside", found)


def of_rust(found: Build, folder: Path) -> dict[str, Flips]:
    flags, crate = (FAST, FAST_CRATE) if optimized(found) else (rust.FLAGS, rust.FLAGS)
    rust.build_crate(found.model, found.tables, "native", folder, crate)
    runner = re.sub(r"^//!.*\n|^#!\[.*\n", "", (RUNTIME / "runner.rs").read_text(), flags=re.MULTILINE)
    head = "#![allow(dead_code, unreachable_code)]\n"
    source = head + runner.replace("fn main()", "fn runner_main()") + (HERE / "beside.rs").read_text()
    (folder / "beside.rs").write_text(source)
    command = [*rust.find_rustc(), rust.EDITION, *flags, "--extern=native=libnative.rlib", "beside.rs"]
    compile_in(folder, command, "beside", "Rust")
    return run(folder / "beside", found)


def test_the_specs_use_every_feature() -> None:
    tables = [spec_of(name).tables for name in SPECS]
    assert all(map(is_checked, tables))
    for name, _ in SECTIONS:
        assert any(getattr(each, name) for each in tables), name
    requests = [row for each in tables for row in each.requests]
    assert any(row.instances > 1 for row in requests) and any(row.interrupts_self for row in requests)


@pytest.mark.parametrize("name", SPECS)
def test_no_flipped_bit_launches_against_a_rule(name: str, tmp_path: Path) -> None:
    places = of_c(spec_of(name), tmp_path)
    assert all((flips.unsafe, flips.differ) == (0, 0) for flips in places.values()), places
    assert all(places[place].missed == 0 for place in ("head", "reals", "words", "values", "cells")), places
    assert places["words"].flips > 6 * 16 * 700 // stride(spec_of(name))


@needs_rustc
@pytest.mark.parametrize("name", SPECS)
def test_no_flipped_bit_launches_against_a_rule_in_rust(name: str, tmp_path: Path) -> None:
    places = of_rust(spec_of(name), tmp_path)
    assert all((flips.unsafe, flips.differ) == (0, 0) for flips in places.values()), places
