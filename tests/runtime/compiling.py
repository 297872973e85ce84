"""Specs to compile, and the compilers of this machine."""

import os
import shutil
import struct
import subprocess
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from shutil import which
from tempfile import mkdtemp

from exover.emit import c, config
from exover.emit.artefact import runtime_file
from exover.engines.compiler import NativeUnavailable, compile_in, find_compiler
from exover.model.model import Model
from exover.ocrd.packing import SECTIONS
from exover.ocrd.reasons import reasons
from exover.ocrd.tables import Tables
from exover.pipeline import Build, build, load
from exover.run.native import FLAGS, NativeEngine
from exover.source import Source
from tests.support.compiled import stays_within

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
RUNTIME = ROOT / "exover" / "runtime"
WARNINGS = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Werror")
SANITIZERS = ("-O0", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
"""Nothing is optimized: that would take ten times as long, and what is looked for could be optimized away."""
SANITIZERS += ("-fsanitize-undefined-trap-on-error",)
"""What is undefined ends a program by SIGILL, and does not tell what it was: so a quarter less is compiled."""
COVERAGE = os.environ.get("EXOVER_COVERAGE")
"""The folder for what exover.c is seen to do, if that is measured."""
KNOWN = ("gcc",) if COVERAGE else ("gcc", "clang")
COMPILERS = tuple(name for name in KNOWN if which(name)) or tuple(find_compiler())
QUICK = "clang" if "clang" in COMPILERS else COMPILERS[0]
"""What compiles programs without optimizing in half the time, where it is not about the compiler."""
SPECS = tuple(sorted([*ROOT.glob("tests/vectors/*.exo"), *ROOT.glob("specs/*.exo")]))

READY, NOT_LOADED, NO_TABLES, NO_MAGIC, OTHER_FORMAT, OTHER_WIDTH, OTHER_USES = 0, 1, 2, 3, 4, 5, 6
BAD_COUNTS, BAD_CHECKSUM = 7, 8
BAD_INDEX, BAD_NODE, BAD_SUM, BAD_LIMITS, MISALIGNED, NO_MEMORY = 9, 10, 11, 12, 13, 14
FAULT_PATH, FAULT_ACTIONS, FAULT_PASSES, FAULT_DECISION, FAULT_CHANNELS = 15, 16, 17, 18, 19
FAULT_INDEX, FAULT_STATE, FAULT_TABLES, FAULT_CHECKER, FAULT_REENTRY, FAULT_ANSWERS = 20, 21, 22, 23, 24, 25
OTHER_BUILD = 26
LIVE, BAD_RECORD, OTHER_TABLES, STALE, BAD_VALUE, BROKEN_RULE, BAD_MAP, STILL_ACTIVE = 27, 28, 29, 30, 31, 32, 33, 34


def model_of(text: str) -> Model:
    """Return the model of a spec that has no mistake."""
    loaded = load(Source("test.exo", text))
    assert loaded.model is not None, loaded.diagnostics
    return loaded.model


@cache
def built(path: Path) -> Build:
    """Return the tables of a spec file."""
    return build(model_of(path.read_text(encoding="utf-8")))


def compile_c(compiler: str, flags: Sequence[str], sources: Sequence[Path], out: Path) -> None:
    """Compile; the test fails with what the compiler says. Of equal exover.c one is compiled (`runtime_object`).

    A program of this folder is compiled where its headers are, so that what it reads is known.
    """
    if COVERAGE and compiler == "gcc" and "-c" not in flags:
        from tests.runtime.coverage import measured

        within = [s.name == "exover.c" or b'#include "exover.c"' in s.read_bytes() for s in sources]
        pairs = zip(sources, within, strict=True)
        counting = [measured([compiler, *flags], s, Path(COVERAGE)) if has else s for s, has in pairs]
        flags, sources = [*flags, "--coverage"], counting
    elif "-c" not in flags:
        sources = [runtime_object(compiler, flags, s, out) if s.name == "exover.c" else s for s in sources]
    command = [compiler, *flags, *map(str, sources), "-o", str(out)]
    beside = [shutil.copy(s, out.parent) if s.parent == HERE and f"-I{out.parent}" in flags else s for s in sources]
    words = [word.replace(str(out.parent), ".") for word in (compiler, *flags, *map(str, beside), "-o", str(out))]
    if not COVERAGE and stays_within(words):
        compile_or_fail(out.parent, words)
        return
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stderr}"


def compile_or_fail(folder: Path, command: Sequence[str]) -> None:
    """Run a compiler in a folder; the test fails with what it says."""
    try:
        compile_in(folder, command, None)
    except NativeUnavailable as failed:
        raise AssertionError(f"{' '.join(command)}\n{failed}") from failed


def runtime_object(compiler: str, flags: Sequence[str], source: Path, out: Path) -> Path:
    """Return exover.c compiled for a program, alone in a folder: so `tests.support.compiled` knows all that it reads.

    It reads no configuration where the flags say the width, and is compiled with all warnings whatever they leave out.
    """
    folder, made = Path(mkdtemp(prefix="runtime-", dir=out.parent)), out.with_name(f"{out.name}.exover.o")
    told = any(flag.startswith("-DEXOVER_WIDTH") for flag in flags)
    for name in (*c.RUNTIME, *([] if told else [config.FILE])):
        (folder / name).write_bytes((source.parent / name).read_bytes())
    command = [compiler, *(flag for flag in flags if not flag.startswith(("-I", "-Wno-"))), "-c", "exover.c"]
    compile_or_fail(folder, command)
    return (folder / "exover.o").rename(made)


def runner(model: Model, tables: Tables, folder: Path, flags: Sequence[str] = FLAGS) -> Path:
    """Return what `native.build` does, compiled so that coverage can be measured."""
    for artefact in c.emit_tables(model, tables, "native"):
        (folder / artefact.name).write_bytes(artefact.content)
    (folder / "runner.c").write_bytes(runtime_file("runner.c"))
    sources = [folder / name for name in ("runner.c", "exover.c", "native_tables.c")]
    compile_c(QUICK, flags, sources, folder / "runner")
    return folder / "runner"


class Engine(NativeEngine):
    """A `NativeEngine` whose process ends by itself, and so writes down what of exover.c was run."""

    def __init__(self, model: Model, tables: Tables) -> None:
        super().__init__(model, tables, compiled_by=runner)

    def _end(self) -> None:
        if self._process is not None and self._process.stdin is not None:
            self._process.stdin.close()
            self._process.wait(timeout=60)
        super()._end()


@dataclass(frozen=True)
class Outcome:
    """What the harness found: the status of a load, the least memory, the fault after some events, a sum of answers."""

    status: int
    memory: int
    fault: int
    sum: str


@dataclass(frozen=True)
class Harness:
    """A program that loads packed tables and runs random events on them."""

    program: Path

    def run(self, tables: Sequence[bytes], events: int = 0) -> list[Outcome]:
        """Return the outcomes; a sanitizer's report fails the test."""
        items = [struct.pack("=III", seed, events, len(data)) + data for seed, data in enumerate(tables)]
        done = subprocess.run([self.program], input=b"".join(items), capture_output=True, check=False, timeout=120)
        assert done.returncode == 0, done.stderr.decode()
        outcomes = []
        for line in done.stdout.decode().splitlines():
            status, memory, fault, total = line.split()
            outcomes.append(Outcome(int(status), int(memory), int(fault), total))
        return outcomes


def talk(program: Path, lines: str) -> list[str]:
    """Return the answers of a compiled runner to lines of its protocol, the greeting left out."""
    done = subprocess.run([program], input=lines, capture_output=True, text=True, check=True, timeout=60)
    return done.stdout.splitlines()[1:]


def field_at(tables: Tables, section: str, record: int, name: str) -> int:
    """Return the index of the word of a field among all words of the tables."""
    at = 0
    for title, kind in SECTIONS:
        names = [field.name for field in fields(kind)]
        if title == section:
            return at + record * len(names) + names.index(name)
        at += len(names) * len(getattr(tables, title))
    raise KeyError(section)


def mutex_words(model: Model) -> bytes:
    """Return what a driver reads to decide on mutexes by itself: counts, then two requests and a reason for each."""
    request = {known.name: number for number, known in enumerate(model.requests)}
    reason = {known.rule: number for number, known in enumerate(reasons(model))}
    numbers = [len(model.requests), len(model.rules)]
    for rule in model.rules:
        first, second = (request[part.request] for part in rule.condition.parts)  # type: ignore[union-attr]
        numbers += [first, second, reason[rule.name]]
    return struct.pack(f"={len(numbers)}I", *numbers)


def sealed(data: bytes) -> bytes:
    """Return the bytes of tables with the checksum that belongs to them."""
    clean = data[:12] + bytes(4) + data[16:]
    return clean[:12] + struct.pack("<I", zlib.crc32(clean)) + clean[16:]


FAULTY = """spec faulty;
module m {
    request a(n: int in 0 .. 7, x: real in 0.0 .. 1.0);
    request b() { wait until not active(m.a); }
    request c();
}
poster p: bool = false;
"""
