"""Artefacts: the same input gives the same bytes, and every form says the same."""

import json
import re
import struct
import subprocess
from pathlib import Path
from shutil import which

import pytest

from exover.emit import binary, c, dot
from exover.emit import json as emit_json
from exover.emit.describe import Description
from exover.emit.identifiers import constants, prefix
from exover.ocrd.packing import HEADER, SECTIONS, counts, decode, pack, words
from exover.pipeline import Build, build
from tests.runtime.compiling import COMPILERS, ROOT, SPECS, WARNINGS, built, compile_c, model_of

DUMP = """
#include "dump_tables.h"
#include <stdio.h>
static void put(unsigned long long value, int bytes)
{
    for (; bytes > 0; bytes--, value >>= 8)
        putchar((int)(value & 0xff));
}
int main(void)
{
    const exover_tables *t = &dump_tables;
    for (int i = 0; i < EXOVER_HEAD_WORDS; i++)
        put(t->head[i], 4);
    for (size_t i = 0; i < t->real_count; i++)
        put(t->reals[i].bits, 8);
    for (size_t i = 0; i < t->word_count; i++)
        put((unsigned long long)t->words[i], EXOVER_WIDTH);
    return 0;
}
"""
WIDE = """
spec wide;
poster a: int in -{0} .. {0} = 0;
poster b: int in -{0} .. {0} = 0;
module m {{ request r(x: int in -{0} .. {0}) {{ check x + a - b <= 7 because "far"; check x > -{0}; }} }}
"""


def dumped(found: Build, folder: Path) -> bytes:
    """Return the bytes of the tables that the emitted C holds."""
    for artefact in c.emit(found.model, found.tables, "dump"):
        (folder / artefact.name).write_bytes(artefact.content)
    (folder / "main.c").write_text(DUMP)
    compile_c(COMPILERS[0], [*WARNINGS, "-O0"], [folder / "main.c", folder / "dump_tables.c"], folder / "dump")
    return subprocess.run([folder / "dump"], capture_output=True, check=True).stdout


@pytest.mark.parametrize("path", SPECS[:4], ids=lambda path: path.stem)
def test_the_bytes_of_c_are_those_of_bin(path: Path, tmp_path: Path) -> None:
    found = built(path)
    (artefact,) = binary.emit(found.model, found.tables)
    assert artefact.name == f"{found.model.name}.bin"
    assert dumped(found, tmp_path) == artefact.content == pack(found.tables)


@pytest.mark.parametrize("bound", [100, 20_000, 2_000_000_000, 2**62, 2**63 - 1])
def test_numbers_of_every_width(bound: int, tmp_path: Path) -> None:
    found = build(model_of(WIDE.format(min(bound, 2**61))))
    assert dumped(found, tmp_path) == pack(found.tables)


def test_the_same_input_gives_the_same_bytes() -> None:
    path = ROOT / "specs" / "rover.exo"
    one, two = (build(model_of(path.read_text(encoding="utf-8"))) for _ in range(2))
    assert c.emit(one.model, one.tables, "rover") == c.emit(two.model, two.tables, "rover")
    for emit in (emit_json.emit, dot.emit):
        assert emit(one.model, one.tables) == emit(two.model, two.tables)


def test_files_are_named_after_the_spec() -> None:
    found = built(ROOT / "specs" / "rover.exo")
    names = [artefact.name for artefact in c.emit(found.model, found.tables, "rover")]
    built_by = ["CMakeLists.txt", "exover_rover.pc"]
    own = ["rover_tables.h", "rover_tables.c", "exover_config.h", "exover.h", "exover.c"]
    own += ["exover_form.h", "exover_resume.h", "rover_api.h", "rover_api.c", "exover_box.h", "exover_box.c"]
    assert names == [*own, "rover_names.h", "rover_names.c", *built_by]


@pytest.mark.parametrize("path", SPECS, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_json_holds_every_number(path: Path) -> None:
    found = built(path)
    (artefact,) = emit_json.emit(found.model, found.tables)
    read = json.loads(artefact.content)
    sections = [read[f"section_{name}"] for name, _ in SECTIONS]
    assert [len(section) for section in sections] == counts(found.tables)[:-2]
    flat = [number for section in [*sections, read["section_sums"]] for record in section for number in record]
    assert flat + read["section_lists"] == words(found.tables)
    assert tuple(map(float, read["section_reals"])) == found.tables.reals
    assert read["sha256"] == found.tables.digest.hex()
    assert [entry["is"] for entry in read["entries"] if entry["is"].startswith("v[")] == []


@pytest.mark.parametrize("path", SPECS, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_the_drawing_has_every_node(path: Path) -> None:
    found = built(path)
    (artefact,) = dot.emit(found.model, found.tables)
    text = artefact.content.decode()
    assert len(re.findall(r"^    n\d+ \[", text, re.MULTILINE)) == len(found.tables.nodes)
    if which("dot"):
        subprocess.run(["dot", "-Tplain"], input=artefact.content, capture_output=True, check=True)


def test_words_for_tests_and_actions() -> None:
    found = built(ROOT / "specs" / "rover.exo")
    words = Description(found.model, found.tables)
    tests = {words.test(node) for node in found.tables.nodes if node.code >= 0}
    actions = {words.action(node) for node in found.tables.nodes if node.code < 0}
    assert {"active(nd.goto) <= 0", "nd.speed <= 0.2", "v <= 0.5", "arm.tool == none", "battery <= 14"} <= tests
    assert "4 * active(nd.goto) + 3 * active(arm.move) <= 3" in tests
    assert {"kill nd.goto[0] (nd.goto.low_battery)", "reject (busy)", "launch", "clear (drive)"} <= actions


def test_unchecked_is_told() -> None:
    model = model_of("spec s; module m { request r(); }")
    tables = build(model, unchecked=True).tables
    (artefact,) = emit_json.emit(model, tables)
    assert json.loads(artefact.content)["unchecked"] is True
    assert struct.unpack_from("<I", pack(tables), 8) == (1,)
    assert decode(pack(tables)) == tables
    assert HEADER.size == 52


@pytest.mark.parametrize(
    ("name", "expected"),
    [("rover", "rover"), ("_x", "spec_x"), ("__", "spec_"), ("exover", "spec_exover"), ("Exover", "spec_Exover")],
)
def test_prefixes(name: str, expected: str) -> None:
    assert prefix(name) == expected


def test_identifiers_are_legal_and_each_once() -> None:
    model = model_of(
        "spec s; module a_b { request c(); request C(); } module a { request b_c(); }"
        "module memory { request bytes(); } module poster { request a(); } poster a: bool = false;"
        "module tables { request h(); } mutex a_b.c, a.b_c; mutex A: a_b.C, a.b_c; mutex a: a_b.C, poster.a;"
    )
    found = constants(model, "s")
    names = [name for kind in (found.requests, found.posters, found.reasons) for name, _ in kind]
    assert len(set(names)) == len(names)
    assert all(re.fullmatch(r"S_[A-Z0-9_]+", name) for name in names)
    assert "S_MEMORY_BYTES_2" in names and "S_TABLES_H_2" in names
