"""Other processors and other judges: sizes on a Cortex-M4, the same answers under QEMU, and what cppcheck says.

Each test needs a tool that is not everywhere, and is left out without it.
"""

import json
import os
import re
import subprocess
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from shutil import which

import pytest

from benchmarks.families import mutexes
from exover.bounds.sizes import stack_bytes
from exover.emit import c
from exover.emit.artefact import runtime_file
from exover.model.event import Invalid
from exover.model.model import Model
from exover.model.wire_reading import read_event
from exover.ocrd.tables import Tables
from exover.pipeline import build
from exover.run.native import NativeEngine
from exover.run.native import build as build_native
from tests.runtime.compiling import COMPILERS, ROOT, RUNTIME, SPECS, WARNINGS, built, compile_c, model_of

ARM, RISCV, AARCH = "arm-none-eabi-gcc", "riscv64-unknown-elf-gcc", "aarch64-linux-gnu-gcc"
S390X = "s390x-linux-gnu-gcc"
M4 = ("-mcpu=cortex-m4", "-mthumb", "-Os")
INTTYPES = ('-DPRIx64="llx"', '-DSCNx64="llx"', '-DPRId32="ld"')
"""What newlib has, and hides."""
CODE, STACK = 8448, 528
ANY_CODE, ANY_STACK = 16_896, 1320
"""Bytes on a Cortex-M4, for a spec of requests and mutexes, and for any tables."""
JUDGED = (
    "-DEXOVER_WIDTH=2",
    "-DEXOVER_WIDTH=4 -DEXOVER_DEBUG -D__GNUC__ -D__OPTIMIZE__ -D__clang__",
    "-DEXOVER_WIDTH=8",
    "-DEXOVER_DEBUG -D__GNUC__",
)
"""Every line of the runtime belongs to one of these, tables of any shape before those of the shape that is emitted.

Where nothing is said cppcheck makes nine by itself, and four of them are equal but for a few lines.
"""

RULES = tuple(product(range(1, 23), range(1, 25)))
RULE = "Rule {0}.{1} Required\nNot kept: {0}.{1}\n"
"""What the addon reads of a rule: its class, then its text."""


def needs(*tools: str) -> pytest.MarkDecorator:
    missing = [tool for tool in tools if which(tool) is None]
    return pytest.mark.skipif(bool(missing), reason=f"no {', '.join(missing)}")


def write(model: Model, tables: Tables, folder: Path) -> None:
    for artefact in c.emit_tables(model, tables, "native"):
        (folder / artefact.name).write_bytes(artefact.content)
    (folder / "runner.c").write_bytes(runtime_file("runner.c"))


def text_bytes(object_file: Path) -> int:
    sizes = subprocess.run(["arm-none-eabi-size", object_file], capture_output=True, text=True, check=True).stdout
    return int(sizes.splitlines()[1].split()[0])


def deepest(object_file: Path) -> dict[str, int]:
    """Return for every function the bytes of stack that it and what it calls take; a circle of calls fails.

    A jump to another function leaves nothing behind: the frame is gone by then.
    """
    own = {}
    for line in object_file.with_suffix(".su").read_text().splitlines():
        place, size, kind = line.split("\t")
        assert kind == "static", line
        own[place.split(":")[-1].split(".")[0]] = int(size)
    linked = object_file.with_suffix(".elf")
    compile_c(ARM, ["-mcpu=cortex-m4", "-mthumb", "-nostdlib", "-Wl,-e,0"], [object_file, Path("-lgcc")], linked)
    listing = subprocess.run(["arm-none-eabi-objdump", "-d", linked], capture_output=True, text=True, check=True)
    calls: dict[str, set[tuple[str, int]]] = {}
    caller = ""
    for line in listing.stdout.splitlines():
        if start := re.match(r"[0-9a-f]+ <([^.>]+).*>:", line):
            caller = start.group(1)
        elif jump := re.search(r"\t(b[a-z.]*)\t[0-9a-f]+ <([^.+>]+)[^+]*>", line):
            called, callee = jump.group(1) == "bl", jump.group(2)
            if callee in own and (called or callee != caller):
                calls.setdefault(caller, set()).add((callee, own[caller] if called else 0))

    def depth(name: str, above: tuple[str, ...] = ()) -> int:
        assert name not in above, f"{name} calls itself"
        below = [frame + depth(callee, (*above, name)) for callee, frame in calls.get(name, ())]
        return max(own.get(name, 0), max(below, default=0))

    return {name: depth(name) for name in own}


@needs(ARM)
def test_code_and_stack_on_a_microcontroller(tmp_path: Path) -> None:
    model = model_of(mutexes(50))
    tables = build(model).tables
    write(model, tables, tmp_path)
    out = tmp_path / "exover.o"
    flags = [*WARNINGS, "-ffreestanding", *M4, "-fstack-usage", "-c"]
    compile_c(ARM, flags, [tmp_path / "exover.c"], out)
    assert text_bytes(out) <= CODE
    depths = deepest(tmp_path / "exover.o")
    assert len(depths) > 20 and max(depths.values()) <= STACK == stack_bytes(tables), depths


@needs(ARM)
@pytest.mark.parametrize("name", ["diligent", "rover", "corners"])
def test_the_stack_is_not_more_than_what_is_emitted(name: str, tmp_path: Path) -> None:
    (path,) = {path.stem: path for path in SPECS if path.stem == name}.values()
    found = built(path)
    write(found.model, found.tables, tmp_path)
    flags = [*WARNINGS, "-ffreestanding", *M4, "-fstack-usage", "-c"]
    compile_c(ARM, flags, [tmp_path / "exover.c"], tmp_path / "exover.o")
    most = stack_bytes(found.tables)
    assert most // 2 < max(deepest(tmp_path / "exover.o").values()) <= most


@needs(ARM)
def test_code_and_stack_of_requests_with_several_slots(tmp_path: Path) -> None:
    several = "module m { request a() instances 3; request b(); request c(); } mutex m.c over m.a, m.b;"
    model = model_of(f"spec s; {several} mutex m.a, m.b;")
    tables = build(model).tables
    write(model, tables, tmp_path)
    flags = [*WARNINGS, "-ffreestanding", *M4, "-fstack-usage", "-c"]
    compile_c(ARM, flags, [tmp_path / "exover.c"], tmp_path / "exover.o")
    assert text_bytes(tmp_path / "exover.o") <= CODE
    assert STACK < max(deepest(tmp_path / "exover.o").values()) <= stack_bytes(tables)


@needs(ARM)
def test_code_and_stack_for_any_tables(tmp_path: Path) -> None:
    flags = [*WARNINGS, "-ffreestanding", *M4, "-fstack-usage", "-c", "-DEXOVER_WIDTH=2"]
    compile_c(ARM, flags, [RUNTIME / "exover.c"], tmp_path / "exover.o")
    assert text_bytes(tmp_path / "exover.o") <= ANY_CODE
    assert max(deepest(tmp_path / "exover.o").values()) <= ANY_STACK


@needs(RISCV)
@pytest.mark.parametrize("width", [2, 4, 8])
def test_it_compiles_for_risc_v(width: int, tmp_path: Path) -> None:
    flags = [*WARNINGS, "-ffreestanding", "-Os", "-march=rv32imac", "-mabi=ilp32", "-c", f"-DEXOVER_WIDTH={width}"]
    compile_c(RISCV, flags, [RUNTIME / "exover.c"], tmp_path / "exover.o")


def events_of(name: str, engine: NativeEngine, model: Model) -> str:
    """Return recorded events as lines of the runner's protocol."""
    read = [read_event(model, line) for line in (ROOT / f"tests/vectors/{name}.events.jsonl").read_bytes().splitlines()]
    return "\n".join([*(engine.line(event) for event in read if not isinstance(event, Invalid)), "f\n"])


def answers(command: Sequence[str | Path], lines: str) -> list[str]:
    done = subprocess.run(command, input=lines, capture_output=True, text=True, check=True, timeout=120)
    return done.stdout.splitlines()


def assert_same_answers(name: str, compiler: str, flags: Sequence[str], run: Sequence[str], folder: Path) -> None:
    found = built(ROOT / "tests" / "vectors" / f"{name}.exo")
    lines = events_of(name, NativeEngine(found.model, found.tables), found.model)
    here = folder / "here"
    here.mkdir()
    expected = answers([build_native(found.model, found.tables, here)], lines)
    write(found.model, found.tables, folder)
    sources = [folder / file for file in ("runner.c", "exover.c", "native_tables.c")]
    compile_c(compiler, flags, sources, folder / "there")
    assert answers([*run, folder / "there"], lines) == expected and len(expected) > 30


@needs(ARM, "qemu-system-arm")
@pytest.mark.parametrize("name", ["rover", "corners", "mixed1"])
def test_the_same_answers_on_a_cortex_m4(name: str, tmp_path: Path) -> None:
    script = str(Path(__file__).parent / "cortex.ld")
    flags = ["-std=gnu99", *M4, *INTTYPES, "--specs=rdimon.specs", "-T", script]
    machine = ["-M", "mps2-an386", "-display", "none", "-serial", "none", "-monitor", "none"]
    run = ["qemu-system-arm", *machine, "-semihosting-config", "enable=on,target=native", "-kernel"]
    assert_same_answers(name, ARM, flags, run, tmp_path)


@needs(AARCH, "qemu-aarch64")
@pytest.mark.parametrize("name", ["rover", "corners", "mixed1"])
def test_the_same_answers_on_aarch64(name: str, tmp_path: Path) -> None:
    assert_same_answers(name, AARCH, ["-std=c99", "-O2", "-static"], ["qemu-aarch64"], tmp_path)


@needs(S390X, "qemu-s390x")
@pytest.mark.parametrize("name", ["rover", "corners", "corners2", "mixed1", "mixed4"])
def test_the_same_answers_on_a_big_endian_processor(name: str, tmp_path: Path) -> None:
    assert_same_answers(name, S390X, ["-std=c99", "-O2", "-static"], ["qemu-s390x"], tmp_path)


@needs(S390X, "qemu-s390x")
def test_a_black_box_has_the_same_bytes_on_a_big_endian_processor(tmp_path: Path) -> None:
    vector = ROOT / "tests" / "vectors" / "corners.exo"
    spec, engine = built(vector), NativeEngine(built(vector).model, built(vector).tables)
    events = [read_event(spec.model, line) for line in vector.with_suffix(".events.jsonl").read_text().splitlines()]
    lines = "".join(f"{engine.line(event)}\n" for event in events if not isinstance(event, Invalid))
    write(spec.model, spec.tables, tmp_path)
    for file in c.BOX:
        (tmp_path / file).write_bytes(runtime_file(file))
    sources = [ROOT / "tests" / "runtime" / "boxed.c"]
    sources += [tmp_path / file for file in ("exover.c", "exover_box.c", "native_tables.c")]
    written = []
    for compiler, run in ((S390X, ["qemu-s390x"]), (COMPILERS[0], [])):
        program, box = tmp_path / compiler, tmp_path / f"{compiler}.bin"
        compile_c(compiler, ["-std=c99", "-O1", "-static", f"-I{tmp_path}"], sources, program)
        environment = {**os.environ, "BOX": str(box), "LINES": "200"}
        subprocess.run([*run, program], input=lines, text=True, env=environment, capture_output=True, check=True)
        written.append(box.read_bytes())
    assert written[0] == written[1] and len(written[0]) == 64 + 32 * 200


@needs("cppcheck")
def test_cppcheck_finds_what_is_explained_and_nothing_else(tmp_path: Path) -> None:
    """A rule is explained at the beginning, or the line above the one that breaks it tells which and why.

    Of findings in one line that have equal texts cppcheck tells one: each rule is given a text of its own.
    """
    source = (RUNTIME / "exover.c").read_text()
    everywhere = source[source.index("MISRA C:2012") : source.index("#define NONE")]
    explained = {(rule, "") for rule in re.findall(r"(?<= )\d+\.\d+(?= )", everywhere)}
    for name in ("exover.c", "exover.h", "exover_form.h", "exover_resume.h"):
        for number, line in enumerate((RUNTIME / name).read_text().splitlines(), 1):
            if said := re.search(r"/\* cppcheck-suppress (.+) ; \w.* \*/$", line):
                rules = re.findall(r"misra-c2012-(\d+\.\d+)", said.group(1))
                explained |= {(rule, f"{name}:{number + 1}") for rule in rules}
    found: set[tuple[str, str]] = set()
    model = model_of(mutexes(8))
    write(model, build(model).tables, tmp_path)
    texts, addon = tmp_path / "texts", tmp_path / "addon.json"
    texts.write_text("Appendix A Summary of guidelines\n" + "".join(RULE.format(*rule) for rule in RULES))
    addon.write_text(json.dumps({"script": "misra.py", "args": [f"--rule-texts={texts}"]}))
    for flags in JUDGED:
        command = ["cppcheck", f"--addon={addon}", "--std=c99", "--enable=warning,performance,portability", "--quiet"]
        ignored = ["--suppress=missingIncludeSystem", "--template={id} {file}:{line} {message}"]
        command += [*flags.split(), *ignored, "exover.c"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
        for finding in done.stderr.splitlines():
            rule, line, message = finding.removeprefix("misra-c2012-").split(" ", 2)
            assert message == f"Not kept: {rule}", "the rule has no text of its own"
            there = rule, Path(line).name
            found.add(there if there in explained or (rule, "") not in explained else (rule, ""))
    assert found == explained
