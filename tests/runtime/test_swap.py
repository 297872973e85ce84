"""From the tables of one spec to those of another while requests run: the C does what `exover swap` has proved."""

import subprocess
from functools import cache
from pathlib import Path

import pytest

from exover.bounds.sizes import sizes
from exover.emit import c
from exover.emit.config import needs
from exover.ocrd.packing import pack
from exover.pipeline import Build, build, swap
from exover.run.codec import LAUNCH, REJECT
from exover.swap.bytes import packed
from exover.swap.carry import Carry
from exover.swap.prove import SwapAnswer
from tests.runtime.compiling import (
    COMPILERS,
    LIVE,
    NO_MEMORY,
    OTHER_TABLES,
    READY,
    ROOT,
    SANITIZERS,
    STALE,
    STILL_ACTIVE,
    WARNINGS,
    built,
    compile_c,
    model_of,
)
from tests.runtime.resuming import host_of, lines_of, needs_rustc, rust_host_of
from tests.support.proving import proved

OLD = """spec old; poster speed: real in 0 .. 2 = 0;
    module m { request a(); request b(v: int in 0 .. 3); request c(); request gone();
               request w() { wait until not active(m.a); } }
    mutex ab: m.a, m.b; forbid fast: active(m.c) and speed > 1 by kill m.c;"""
NEW = """spec new; poster speed: real in 0 .. 2 = 0;
    module m { request x(); request c(); request b(v: int in 0 .. 5); request a(); request w(); }
    mutex ab: m.a, m.b; mutex bc: m.b, m.c; forbid fast: active(m.c) and speed > 1 by kill m.c;"""
RUNNING = 1


@cache
def of(text: str) -> Build:
    return build(model_of(text))


def test_the_c_goes_on_by_what_was_proved_and_refuses_the_rest(tmp_path: Path) -> None:
    content, answer = swap(of(OLD), of(NEW), proved(of(OLD)))
    assert answer.ended == {"m.gone": (), "m.b": ("bc",)}
    (tmp_path / "map").write_bytes(content)
    beside: tuple[Build, ...] = ()
    for name, found in (("old", of(OLD)), ("new", of(NEW))):
        served = tuple(
            needs(each.tables, before, sizes(each.tables)) for before, each in zip(("old",), beside, strict=False)
        )
        for artefact in c.emit_tables(found.model, found.tables, name, served):
            (tmp_path / artefact.name).write_bytes(artefact.content)
        beside = (found,)
    sources = [
        Path(__file__).parent / "swap.c",
        *(tmp_path / f"{name}.c" for name in ("old_tables", "new_tables", "exover")),
    ]
    flags = [*WARNINGS, "-Wno-conversion", *SANITIZERS, f"-I{tmp_path}"]
    compile_c(COMPILERS[0], flags, sources, tmp_path / "swap")
    done = subprocess.run([tmp_path / "swap", tmp_path / "map"], capture_output=True, text=True, check=True)
    going, ending, again = done.stdout.splitlines()
    assert going.split() == [f"{READY}:launch4", f"{RUNNING}2", "reject2", "reject2", "launch2"]
    assert ending.split() == [
        *(f"{status}:" for status in (STILL_ACTIVE, STALE, STILL_ACTIVE)),
        *map(str, (LIVE, NO_MEMORY, OTHER_TABLES)),
        *("launch0", "reject1", "0", f"{READY}:", "reject2"),
    ]
    assert again.split() == [f"{READY}:", "reject2", str(LIVE)]


@pytest.mark.parametrize("name", ["corners2", "mixed5", "rover"])
def test_going_to_the_very_same_tables_changes_no_answer(name: str, tmp_path: Path) -> None:
    found = build(built(ROOT / "tests/vectors" / f"{name}.exo").model, unchecked=True)
    host = host_of(found, tmp_path, fixed=name == "rover")
    carry = Carry(found.compiled, found.compiled)
    (tmp_path / "map").write_bytes(packed(carry, ()))
    length, refused, differ, told = map(
        int, host.run("swaps", str(tmp_path / "map"), lines=lines_of(found, 100))[0].split()
    )
    assert (length, refused, differ) == (100, 0, 0) and (told == 0 or found.tables.launches)


@needs_rustc
def test_rust_takes_over_from_a_record_of_c(tmp_path: Path) -> None:
    """m.a and m.c run, m.w waits for m.a and starts at once; then as in C."""
    for language in ("c", "rust"):
        (tmp_path / language).mkdir()
    old, new = host_of(of(OLD), tmp_path / "c"), rust_host_of(of(NEW), tmp_path / "rust")
    content, _ = swap(of(OLD), of(NEW), proved(of(OLD)))
    (tmp_path / "map").write_bytes(content)
    two = "1 0000000000000002"
    (tmp_path / "record").write_bytes(old.record(3, "a 2 0\na 0 0\na 4 0\n"))
    lines = f"a 2 {two}\nr 3 0 1 -1 0\na 2 {two}\nr 1 0 1 -1 0\na 2 {two}\n"
    done = new.run("swap", str(tmp_path / "record"), str(tmp_path / "map"), lines=lines)
    kinds = [(int(line.split()[0]), int(line.split()[1])) for line in done[1:-1] if line]
    assert done[0] == "0 1" and done[-1] == f"Some({LIVE})"
    assert kinds == [(LAUNCH, 4), (REJECT, 2), (REJECT, 2), (LAUNCH, 2)]
    (tmp_path / "record").write_bytes(old.record(1, "a 3 0\n"))
    assert new.run("swap", str(tmp_path / "record"), str(tmp_path / "map")) == [str(STILL_ACTIVE)]


def test_the_map_names_both_tables() -> None:
    content, answer = swap(of(OLD), of(NEW), proved(of(OLD)))
    assert isinstance(answer, SwapAnswer)
    assert content[16:48] == of(OLD).tables.digest and content[52:84] == of(NEW).tables.digest
    assert content[48:52] == pack(of(OLD).tables)[12:16] and content[84:88] == pack(of(NEW).tables)[12:16]
