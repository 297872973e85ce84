"""Two specs in one folder: one configuration serves both, or the second is refused and nothing changes."""

import subprocess
from pathlib import Path

import pytest

from exover.bounds.sizes import memory_bytes, ram_bytes, sizes, state_bytes
from exover.emit.config import FILE, config, needs, read
from tests.runtime.compiling import COMPILERS, SPECS, WARNINGS, built, compile_c
from tests.support.command import Run

PLAIN = "spec plain; module m { request a(); request b(); } mutex m.a, m.b;"
SUMS = """spec sums;
poster near: int in -9 .. 9 = 0;
poster far: int in -9 .. 9 = 0;
module m { request r(x: int in -9 .. 9) { check sum: 30000 * near + 30001 * far + 29999 * x <= 7; } }
"""
WIDE = "spec wide; poster p: int in 0 .. 99999 = 0; module m { request r() { check low: p < 70000; } }"
HOST = """
#include "plain_api.h"
#include "sums_api.h"
#include <stdio.h>

static plain_checker plain;
static sums_checker sums;

int main(void)
{
    plain_answer answer;
    sums_answer other;
    int started = plain_start(&plain) == EXOVER_READY && sums_start(&sums) == EXOVER_READY;
    plain_ask_m_a(&plain, &answer);
    plain_ask_m_b(&plain, &answer);
    sums_ask_m_r(&sums, 0, &other);
    printf("%d %d %d\\n", started, answer.actions[0].kind == EXOVER_REJECT, other.actions[0].kind == EXOVER_LAUNCH);
    return 0;
}
"""


def emit(run: Run, folder: Path, text: str, out: str = "out") -> subprocess.CompletedProcess[str]:
    spec = folder / f"{text.split()[1].rstrip(';')}.exo"
    spec.write_text(text)
    return run("emit", spec, "--target", "c", "--out", out, "--unchecked", cwd=folder)


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("order", [(PLAIN, SUMS), (SUMS, PLAIN)], ids=["wider-last", "wider-first"])
def test_both_start_and_answer(compiler: str, order: tuple[str, str], run: Run, tmp_path: Path) -> None:
    first, second = (emit(run, tmp_path, text) for text in order)
    assert (first.returncode, first.stderr, second.returncode) == (0, "", 0)
    assert "exover_config.h serves" in second.stderr and "plain" in second.stderr and "sums" in second.stderr
    folder = tmp_path / "out"
    assert {each.name: each.state for each in read((folder / FILE).read_text())} == {"plain": 4, "sums": 8}
    (folder / "host.c").write_text(HOST)
    names = ("host.c", "plain_api.c", "plain_tables.c", "sums_api.c", "sums_tables.c", "exover.c")
    flags = [*WARNINGS, "-O0", "-DEXOVER_DEBUG", f"-I{folder}"]
    compile_c(compiler, flags, [folder / name for name in names], folder / "host")
    assert subprocess.run([folder / "host"], capture_output=True, text=True, check=True).stdout == "1 1 1\n"


def test_the_order_of_emission_does_not_matter(run: Run, tmp_path: Path) -> None:
    for text, out in ((PLAIN, "one"), (SUMS, "one"), (SUMS, "two"), (PLAIN, "two")):
        assert emit(run, tmp_path, text, out).returncode == 0
    one, two = ({path.name: path.read_bytes() for path in (tmp_path / out).iterdir()} for out in ("one", "two"))
    assert one == two


def test_what_is_no_longer_there_is_forgotten(run: Run, tmp_path: Path) -> None:
    emit(run, tmp_path, PLAIN)
    alone = (tmp_path / "out" / "exover_config.h").read_bytes()
    emit(run, tmp_path, SUMS)
    (tmp_path / "out" / "sums_tables.c").unlink()
    assert emit(run, tmp_path, PLAIN).stderr == ""
    assert (tmp_path / "out" / "exover_config.h").read_bytes() == alone and b"EXOVER_SHAPE" in alone


def kept(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_two_widths_are_refused(run: Run, tmp_path: Path) -> None:
    emit(run, tmp_path, PLAIN)
    before = kept(tmp_path / "out")
    ended = emit(run, tmp_path, WIDE)
    assert ended.returncode == 2 and kept(tmp_path / "out") == before
    assert "one runtime serves one width" in ended.stderr and "folder of its own" in ended.stderr


def test_a_configuration_that_tells_nothing_is_refused(run: Run, tmp_path: Path) -> None:
    emit(run, tmp_path, PLAIN)
    (tmp_path / "out" / "exover_config.h").write_text("#define EXOVER_WIDTH 2\n")
    before = kept(tmp_path / "out")
    ended = emit(run, tmp_path, SUMS)
    assert ended.returncode == 2 and kept(tmp_path / "out") == before
    assert "emit plain there anew first" in ended.stderr
    assert emit(run, tmp_path, PLAIN).returncode == 0 and emit(run, tmp_path, SUMS).returncode == 0


def test_sources_of_others_are_no_tables(run: Run, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "lookup_tables.c").write_bytes("const int sines[] = {0}; /* 90° */\n".encode("latin-1"))
    ended = emit(run, tmp_path, PLAIN)
    assert (ended.returncode, ended.stderr) == (0, "")


@pytest.mark.parametrize("path", SPECS, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_a_configuration_tells_what_it_serves(path: Path) -> None:
    tables = built(path).tables
    own = needs(tables, path.stem, sizes(tables))
    assert read(config(tables, path.stem, (), sizes(tables))) == (own,)
    fixed, by_state = memory_bytes(tables)
    assert fixed + by_state * state_bytes(tables) == ram_bytes(tables)


def test_the_memory_is_right_for_either_state(run: Run, tmp_path: Path) -> None:
    """With EXOVER_WIDTH alone the state may be wider than tables need; their header knows what that takes."""
    assert emit(run, tmp_path, PLAIN).returncode == 0
    folder = tmp_path / "out"
    (folder / "main.c").write_text(
        '#include "plain_api.h"\nint main(void) { static plain_checker r; return (int)plain_start(&r); }\n'
    )
    for state in (4, 8):
        flags = [*WARNINGS, "-DEXOVER_WIDTH=2", f"-DEXOVER_STATE={state}"]
        sources = [folder / name for name in ("main.c", "plain_api.c", "plain_tables.c", "exover.c")]
        compile_c(COMPILERS[0], flags, sources, folder / "main")
        assert subprocess.run([folder / "main"], check=False).returncode == 0
