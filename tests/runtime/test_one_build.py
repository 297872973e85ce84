"""One build for a Cortex-M4: what is linked of it takes 4.5 KiB, and a step 300 instructions, counted in QEMU.

Left out where the cross compiler or QEMU is missing.
"""

import re
import subprocess
from bisect import bisect_right
from pathlib import Path
from shutil import which

import pytest

from benchmarks.families import mutexes
from benchmarks.runtime import MIXES, stream
from exover.emit import c
from exover.model.event import Ask
from exover.model.model import Model
from exover.ocrd.tables import Tables
from exover.pipeline import build
from tests.runtime.compiling import compile_c, model_of

ARM, QEMU, NM = "arm-none-eabi-gcc", "qemu-system-arm", "arm-none-eabi-nm"
M4 = ("-std=gnu99", "-mcpu=cortex-m4", "-mthumb", "-O2", "-ffunction-sections", "-fdata-sections")
MACHINE = ("-M", "mps2-an386", "-display", "none", "-serial", "none", "-monitor", "none")
BYTES, INSTRUCTIONS = 4608, 300
EVENTS = 400
HOST = """
#include "one_tables.h"
static exover r2c;
static uint64_t memory[ONE_MEMORY_BYTES / 8 + 1];
static const unsigned char events[][2] = {%s};
int main(void)
{
    int wrong = exover_load(&r2c, &one_tables, memory, sizeof memory) != EXOVER_READY;
    for (unsigned i = 0; i < sizeof events / 2; i++) {
        size_t count = events[i][0] ? exover_ask(&r2c, events[i][1], 0, 0)
                                    : exover_report(&r2c, events[i][1], 0, EXOVER_OK, -1, 0, 0);
        wrong += count > 1;
    }
    wrong += exover_verify(&r2c, 0) != 0 && exover_abort(&r2c, 1, 0) == 0;
    return wrong + (exover_fault(&r2c) == EXOVER_NOT_LOADED);
}
"""
needed = pytest.mark.skipif(any(which(tool) is None for tool in (ARM, QEMU)), reason=f"no {ARM} or {QEMU}")
Ranges = list[tuple[int, int, str]]


@pytest.fixture(scope="module")
def model() -> Model:
    return model_of(mutexes(50))


def linked(model: Model, tables: Tables, share: float, folder: Path) -> tuple[Path, Ranges, int]:
    """Return the program of a host, where its functions stand, and how many bytes of it are the runtime."""
    number = {request.name: index for index, request in enumerate(model.requests)}
    events = stream(model, tables, share)[:EVENTS]
    pairs = ", ".join(f"{{{int(isinstance(event, Ask))}, {number[event.request]}}}" for event in events)  # type: ignore[union-attr]
    for artefact in c.emit_tables(model, tables, "one"):
        (folder / artefact.name).write_bytes(artefact.content)
    (folder / "host.c").write_text(HOST % pairs)
    objects = []
    for name in ("host", "exover", "one_tables"):
        objects.append(folder / f"{name}.o")
        compile_c(ARM, [*M4, "-c"], [folder / f"{name}.c"], objects[-1])
    script = str(Path(__file__).parent / "cortex.ld")
    flags = [*M4, "--specs=rdimon.specs", "-T", script, "-Wl,--gc-sections", f"-Wl,-Map={folder / 'map'}"]
    compile_c(ARM, flags, objects, folder / "host.elf")
    placed = re.findall(
        r"^ \.(?:text|rodata)\S*\s+0x[0-9a-f]+\s+0x([0-9a-f]+)\s+\S*/exover\.o$",
        (folder / "map").read_text().split("Linker script and memory map")[1],
        re.MULTILINE,
    )
    listed = subprocess.run([NM, "-nS", folder / "host.elf"], capture_output=True, text=True, check=True).stdout
    symbols = [line.split() for line in listed.splitlines()]
    code = [(int(s[0], 16) & ~1, int(s[1], 16), s[3]) for s in symbols if len(s) == 4 and s[2] in "tT"]
    return folder / "host.elf", code, sum(int(size, 16) for size in placed)


def steps(program: Path, code: Ranges, folder: Path) -> float:
    """Return the instructions between the calls and returns of exover_ask and exover_report, for each event."""
    log = folder / "log"
    trace = ["-singlestep", "-d", "exec,nochain", "-D", str(log), "-semihosting-config", "enable=on,target=native"]
    assert subprocess.run([QEMU, *MACHINE, *trace, "-kernel", program], check=False, timeout=120).returncode == 0
    starts, inside, found = [start for start, _, _ in code], False, 0
    with log.open() as lines:
        for line in lines:
            at = re.search(r"\[[0-9a-f]+/([0-9a-f]+)/", line)
            if at is None:
                continue
            place = bisect_right(starts, int(at[1], 16)) - 1
            name = code[place][2] if place >= 0 else ""
            if name == "main":
                inside = False
            elif name.startswith(("exover_ask", "exover_report")):
                inside = True
            found += inside
    return found / EVENTS


@needed
@pytest.mark.parametrize("share", MIXES)
def test_one_build_is_small_and_fast(share: float, model: Model, tmp_path: Path) -> None:
    program, code, size = linked(model, build(model).tables, share, tmp_path)
    assert 3000 < size <= BYTES
    assert 200 < steps(program, code, tmp_path) <= INSTRUCTIONS
