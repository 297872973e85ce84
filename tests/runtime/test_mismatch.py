"""A host and a runtime of different builds do not come together, and neither meets the names of POSIX."""

import subprocess
from pathlib import Path

import pytest

from exover import __version__
from exover.emit import c
from exover.pipeline import build
from tests.runtime.compiling import COMPILERS, OTHER_BUILD, QUICK, READY, WARNINGS, compile_c, model_of

MODEL = model_of("spec host; module m { request a(); request b(); } mutex m.a, m.b;")
HOST = r"""
#include "host_tables.h"
#include <stdio.h>
#include <string.h>
static uint64_t memory[HOST_MEMORY_BYTES / 8 + 64];
static struct { exover checker; unsigned char behind[256]; } room;
static int loaded(size_t bytes, uint32_t build)
{
    const exover_home home = {&host_tables, memory, sizeof memory, bytes, build};
    return (int)exover_load_built(&room.checker, &home, false);
}
int main(void)
{
    memset(&room, 0xa5, sizeof room);
    int found[] = {
        loaded(sizeof(exover) - 8, EXOVER_BUILD), loaded(sizeof(exover) + 8, EXOVER_BUILD),
        loaded(sizeof(exover), EXOVER_BUILD ^ 1u << 10),
    };
    int changed = 0;
    for (size_t i = 0; i < sizeof room; i++)
        changed += ((unsigned char *)&room)[i] != 0xa5;
    printf("%d %d %d %d ", found[0], found[1], found[2], changed);
    printf("%d ", (int)exover_load(&room.checker, &host_tables, memory, sizeof memory));
    for (size_t i = 0; i < sizeof room.behind; i++)
        changed += room.behind[i] != 0xa5;
    printf("%d %s ", changed, EXOVER_VERSION);
    printf("%d.%d.%d\n", EXOVER_VERSION_MAJOR, EXOVER_VERSION_MINOR, EXOVER_VERSION_PATCH);
    return 0;
}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for artefact in c.emit(MODEL, build(MODEL).tables, "host"):
        (tmp_path / artefact.name).write_bytes(artefact.content)
    (tmp_path / "host.c").write_text(HOST)
    return tmp_path


def test_another_size_or_build_is_refused_and_nothing_written(folder: Path) -> None:
    sources = [folder / name for name in ("host.c", "host_tables.c", "exover.c")]
    compile_c(COMPILERS[0], [*WARNINGS, "-O1"], sources, folder / "host")
    done = subprocess.run([folder / "host"], capture_output=True, text=True, check=True)
    *statuses, version, numbers = done.stdout.split()
    assert list(map(int, statuses)) == [OTHER_BUILD, OTHER_BUILD, OTHER_BUILD, 0, READY, 0]
    assert version == numbers == __version__


@pytest.mark.parametrize(
    ("host", "runtime"),
    [
        ((), ("-DEXOVER_DEBUG",)),
        (("-DEXOVER_DEBUG",), ()),
        ((), ("-DEXOVER_WIDTH=2",)),
        (("-DEXOVER_WIDTH=2",), ("-DEXOVER_WIDTH=4",)),
        (("-DEXOVER_WIDTH=2",), ("-DEXOVER_WIDTH=2", "-DEXOVER_STATE=8")),
    ],
    ids=lambda flags: " ".join(flags) or "emitted",
)
def test_builds_that_differ_do_not_link(host: tuple[str, ...], runtime: tuple[str, ...], folder: Path) -> None:
    compile_c(QUICK, [*host, "-c"], [folder / "host.c"], folder / "host.o")
    compile_c(QUICK, [*host, "-c"], [folder / "host_tables.c"], folder / "tables.o")
    compile_c(QUICK, [*runtime, "-c"], [folder / "exover.c"], folder / "exover.o")
    objects = [folder / name for name in ("host.o", "tables.o", "exover.o")]
    done = subprocess.run([QUICK, *objects, "-o", folder / "host"], capture_output=True, text=True, check=False)
    assert done.returncode != 0 and "exover_load_built_" in done.stderr


@pytest.mark.parametrize("compiler", COMPILERS)
def test_names_do_not_clash_with_those_of_posix(compiler: str, folder: Path) -> None:
    headers = (
        "unistd",
        "signal",
        "stdlib",
        "stdio",
        "string",
        "math",
        "time",
        "fcntl",
        "pthread",
        "setjmp",
        "sys/socket",
    )
    included = [flag for header in headers for flag in ("-include", f"{header}.h")]
    flags = [*WARNINGS, "-D_GNU_SOURCE", *included, "-c"]
    compile_c(compiler, flags, [folder / "exover.c"], folder / "exover.o")
