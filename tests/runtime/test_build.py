"""The runtime and everything emitted compile without a warning, freestanding, and need no library."""

import subprocess
from pathlib import Path
from shutil import which

import pytest

from benchmarks.families import mutexes
from exover.emit import c
from exover.pipeline import build
from tests.runtime.compiling import COMPILERS, ROOT, RUNTIME, WARNINGS, built, compile_c, model_of, runtime_object

ARM = "arm-none-eabi-gcc"
EVERYTHING = RUNTIME / "exover.c"
ONLY_WARNINGS = ("-fsyntax-only",)
"""What clang warns of it tells before it makes code, unlike gcc, and that takes a fifth of the time."""


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize(
    ("width", "uses"),
    [(2, []), (4, []), (8, []), (2, ["-DEXOVER_USES=0x1c007"])],
    ids=["2-all", "4-all", "8-all", "2-least"],
)
def test_the_runtime_is_freestanding(compiler: str, width: int, uses: list[str], tmp_path: Path) -> None:
    level = "-O2" if width == 2 and compiler == COMPILERS[0] else "-O1" if width == 2 else "-O0"
    flags = [*WARNINGS, level, "-ffreestanding", f"-DEXOVER_WIDTH={width}", *uses]
    if width > 2 and compiler == "clang":
        compile_c(compiler, [*flags, "-c", *ONLY_WARNINGS], [EVERYTHING], tmp_path / "exover.o")
        return
    out = runtime_object(compiler, flags, EVERYTHING, tmp_path / "exover")
    if which("nm") is None:
        pytest.skip("it compiles, but nm is not installed")
    undefined = subprocess.run(["nm", "--undefined-only", out], capture_output=True, text=True, check=True)
    assert undefined.stdout == ""


@pytest.mark.skipif(which(ARM) is None, reason="no cross compiler")
def test_a_spec_of_mutexes_stays_small_on_a_microcontroller(tmp_path: Path) -> None:
    out = tmp_path / "exover.o"
    flags = [*WARNINGS, "-ffreestanding", "-Os", "-mcpu=cortex-m4", "-mthumb", "-DEXOVER_NO_RESUME", "-c"]
    model = model_of(mutexes(50))
    for artefact in c.emit_tables(model, build(model).tables, "small"):
        (tmp_path / artefact.name).write_bytes(artefact.content)
    compile_c(ARM, flags, [tmp_path / "exover.c"], out)
    sizes = subprocess.run(["arm-none-eabi-size", out], capture_output=True, text=True, check=True).stdout
    assert int(sizes.splitlines()[1].split()[0]) <= 4352


@pytest.mark.parametrize("compiler", COMPILERS)
def test_what_is_emitted_compiles(compiler: str, tmp_path: Path) -> None:
    found = built(ROOT / "tests" / "vectors" / "corners.exo")
    for artefact in c.emit(found.model, found.tables, "native"):
        (tmp_path / artefact.name).write_bytes(artefact.content)
    flags = [*WARNINGS, "-O2", *(ONLY_WARNINGS if compiler == "clang" else ())]
    for source in ("native_tables.c", "native_api.c", "native_names.c"):
        compile_c(compiler, [*flags, "-c"], [tmp_path / source], tmp_path / "out.o")
    if compiler == "clang":
        compile_c(compiler, [*flags, "-c"], [tmp_path / "exover.c"], tmp_path / "out.o")
    else:
        runtime_object(compiler, flags, tmp_path / "exover.c", tmp_path / "out")


ODD = r"""
spec _x;
enum kind { int, void }
module a_b { request c(k: kind) fails (EOF, errno) {
    check k == int because "??/ ??= \"quoted\" \\ %s é 漢"; }
    request C(); }
module a { request b_c(); poster tables: bool = false; }
poster LONG_MAX: kind = int;
mutex NULL: a_b.c, a.b_c because "LONG";
""".replace('LONG"', "long " * 1500 + '"')


PRINTER = r"""
#include "odd_names.h"
#include <stdio.h>
int main(void)
{
    for (int i = 0; odd_reason_names[i]; i++)
        printf("%s=%s\n", odd_reason_names[i], odd_reason_because[i] ? odd_reason_because[i] : "-");
    for (int i = 0; odd_request_names[i]; i++)
        printf("%s\n", odd_request_names[i]);
    printf("%s %s\n", odd_param_names[0], odd_param_values[0][1]);
    printf("%s %d\n", odd_status_names[0][1], odd_status_names[1][0] == 0);
    return 0;
}
"""


def test_odd_names_and_texts_survive(tmp_path: Path) -> None:
    model = model_of(ODD)
    for artefact in c.emit(model, build(model).tables, "odd"):
        (tmp_path / artefact.name).write_bytes(artefact.content)
    (tmp_path / "main.c").write_text(PRINTER)
    sources = [tmp_path / name for name in ("main.c", "odd_names.c", "odd_tables.c", "exover.c")]
    compile_c(COMPILERS[0], [*WARNINGS, "-O0"], sources, tmp_path / "main")
    printed = subprocess.run([tmp_path / "main"], capture_output=True, check=True).stdout.decode()
    expected = [
        "busy=-",
        'a_b.c.check.1=??/ ??= "quoted" \\ %s é 漢',
        "NULL=" + "long " * 1500,
        "a_b.c",
        "a_b.C",
        "a.b_c",
        "k void",
        "errno 1",
    ]
    assert printed.splitlines() == expected
