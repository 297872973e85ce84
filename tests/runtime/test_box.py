"""The black box: it holds what happened, before it is answered, and `exover replay` tells and answers it again."""

import json
import os
import struct
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from pathlib import Path
from shutil import which

import pytest

from exover.emit import c
from exover.emit.artefact import runtime_file
from exover.engines.compiler import compile_in
from exover.model.event import Invalid
from exover.model.model import Model
from exover.model.wire_reading import read_event
from exover.pipeline import Build, build, engine
from exover.run import box
from exover.run.box import HEADER, LINE, BoxStep, NotABox, read_box
from exover.run.codec import INVALID
from exover.run.native import NativeEngine
from exover.run.replay import replay
from exover.run.rust import EDITION, FLAGS, build_crate, find_rustc
from exover.run.simulate import simulate
from tests.docs.pages import ROOT
from tests.runtime.boxed import SPEC
from tests.runtime.compiling import COMPILERS, QUICK, SANITIZERS, WARNINGS, built, compile_c, model_of
from tests.support.command import Ended, Run
from tests.support.constructs import seldom

HERE = Path(__file__).parent
VECTORS = [ROOT / "tests" / "vectors" / f"{name}.exo" for name in ("corners", "corners2", "mixed4", "rover")]
IN_RUST = VECTORS[:3]
"""Those that have every construct of all: to compile one takes a second."""
EVENTS = [
    {"ask": "nd.goto", "args": {"x": 0.25, "slow": True}},
    {"ask": "arm.move", "args": {"mode": "wild"}},
    {"observe": "battery", "value": 12},
    {"ask": "nd.stop"},
    {"report": "nd.goto", "instance": 0, "outcome": "ok", "results": {"left": 3}},
    {"observe": "fuel", "value": 4},
    {"observe": "height", "value": 1e300},
    {"abort": "nd.stop"},
    {"report": "nd.goto", "instance": 1, "outcome": "failed", "status": "stuck"},
]


@dataclass(frozen=True)
class Boxed:
    """A program with a black box of so many lines in a file, and what it is for."""

    program: Path
    spec: Build
    folder: Path
    count: int

    @property
    def file(self) -> Path:
        return self.folder / "box.bin"

    def run(self, events: Sequence[str], **changes: str) -> bytes:
        """Return the box after these lines of the protocol; what was there before is kept."""
        lines = "".join(f"{line}\n" for line in events)
        environment = {**os.environ, "BOX": str(self.file), "LINES": str(self.count), **changes}
        done = subprocess.run([self.program], input=lines, env=environment, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, "")
        return self.file.read_bytes()

    def lines(self, events: Sequence[dict[str, object]]) -> list[str]:
        """Return events as lines of the protocol."""
        engine = NativeEngine(self.spec.model, self.spec.tables)
        read = [read_event(self.spec.model, json.dumps(event)) for event in events]
        return [engine.line(event) for event in read if not isinstance(event, Invalid)]


Boxing = Callable[[int], Boxed]


def compiled(spec: Build, folder: Path, source: Path, flags: Sequence[str] = ()) -> Path:
    """Return a program of these tables, whose box alone is compiled with the flags."""
    for artefact in c.emit(spec.model, spec.tables, "native"):
        (folder / artefact.name).write_bytes(artefact.content)
    (folder / "runner.c").write_bytes(runtime_file("runner.c"))
    compiler = COMPILERS[0] if flags else QUICK
    compile_c(compiler, [*WARNINGS, *flags, "-c", f"-I{folder}"], [folder / "exover_box.c"], folder / "box.o")
    sources = [source, folder / "box.o", folder / "exover.c", folder / "native_tables.c"]
    compile_c(compiler, ["-std=c99", "-Wall", "-Wextra", "-Werror", *flags, f"-I{folder}"], sources, folder / "boxed")
    return folder / "boxed"


@pytest.fixture(scope="module")
def small() -> Build:
    return build(model_of(SPEC))


@pytest.fixture(scope="module")
def program(small: Build, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return compiled(small, tmp_path_factory.mktemp("boxed"), HERE / "boxed.c", SANITIZERS)


@pytest.fixture
def boxing(small: Build, program: Path, tmp_path: Path) -> Boxing:
    return lambda count: Boxed(program, small, tmp_path, count)


@pytest.fixture(scope="module", params=VECTORS, ids=lambda path: path.stem)
def vector(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Return the file of a spec with a stream of events, and the program of its tables."""
    return request.param, compiled(built(request.param), tmp_path_factory.mktemp("vector"), HERE / "boxed.c")


def test_what_is_recorded_is_what_the_reference_answers(vector: tuple[Path, Path], tmp_path: Path) -> None:
    path, program = vector
    boxed = Boxed(program, built(path), tmp_path, 20_000)
    text = path.with_suffix(".events.jsonl").read_text().splitlines()
    read = [(line, read_event(boxed.spec.model, line)) for line in text if line.strip()]
    known = [line for line, event in read if not isinstance(event, Invalid)]
    (run,) = read_box(boxed.run(boxed.lines([json.loads(line) for line in known]))).runs
    steps = replay(boxed.spec.model, run)
    assert [step.number for step in steps] == list(range(1, len(known) + 1))
    assert all(step.agrees for step in steps)
    assert sum(len(step.recorded or ()) for step in steps) > 20
    told = list(simulate(boxed.spec.model, engine("reference", boxed.spec.model).__enter__(), known))
    again = [json.dumps(step.event) for step in steps]
    assert list(simulate(boxed.spec.model, engine("reference", boxed.spec.model).__enter__(), again)) == told


def test_the_bytes_are_those_of_the_page(boxing: Boxing, small: Build) -> None:
    """In one small case, byte by byte: the header, the opening, an ask with its two arguments, the launch, the end."""
    data = boxing(5).run(["a 0 2 3fd0000000000000 0000000000000001"])
    assert len(data) == 64 + 5 * 32
    magic, version, lines, crc, digest, _ = HEADER.unpack_from(data)
    assert (magic, version, lines) == (b"EXBX", 1, 5)
    assert (struct.pack("<I", crc), digest) == (small.data[12:16], small.data[20:52])
    bodies = [LINE.unpack_from(data, 64 + 32 * place)[:7] for place in range(5)]
    assert bodies == [
        (1, 0, 1, 0, 0, 0, 0),
        (2, 1, 2 | 2 << 8, 0, 0, 0, 0),
        (3, 1, 8 | 2 << 8, 0, 0x3FD00000, 1, 0),
        (4, 1, 9 | 0x1E76 << 8, 0, 0, 0xFFFFFFFF, 0xFFFFFFFF),
        (5, 1, 10, 1, 0, 0, 0),
    ]


def test_the_oldest_is_overwritten_and_the_rest_needs_what_came_before(boxing: Boxing, small: Build) -> None:
    boxed = boxing(20)
    lines = boxed.lines(EVENTS)
    (run,) = read_box(boxed.run(lines)).runs
    missing = run[0].number - 1
    assert 0 < missing < len(EVENTS)
    assert [step.number for step in run] == list(range(missing + 1, len(EVENTS) + 1))
    assert {step.expected for step in replay(small.model, run)} == {None}
    before = [json.dumps(event).encode() for event in EVENTS]
    assert all(step.agrees and step.expected is not None for step in replay(small.model, run, before))


def test_a_restart_keeps_what_the_box_holds_and_begins_a_run(boxing: Boxing, small: Build) -> None:
    boxed = boxing(100)
    lines = boxed.lines(EVENTS)
    boxed.run(lines[:4])
    first, second = read_box(boxed.run(lines[:2])).runs
    assert ([step.number for step in first], [step.number for step in second]) == ([1, 2, 3, 4], [1, 2])


def test_other_tables_wipe_it(boxing: Boxing, tmp_path: Path) -> None:
    boxed = boxing(100)
    data = boxed.run(boxed.lines(EVENTS))
    assert any(data[200:])
    other = build(model_of("spec other; module m { request a(); }"))
    (tmp_path / "other").mkdir()
    wiped = Boxed(compiled(other, tmp_path / "other", HERE / "boxed.c"), other, tmp_path, 100).run([])
    assert wiped[16:48] == other.data[20:52] != data[16:48]
    assert not any(wiped[64 + 32 :])


def test_no_changed_byte_is_believed(boxing: Boxing, small: Build) -> None:
    """Any changed byte costs its line and what stands before it, and never tells another story."""
    boxed = boxing(60)
    data = boxed.run(boxed.lines(EVENTS))
    (whole,) = read_box(data).runs
    for place in range(len(data)):
        changed = bytearray(data)
        changed[place] ^= 1 << place % 8
        if place < HEADER.size:
            with pytest.raises(NotABox):
                read_box(bytes(changed))
            continue
        found = read_box(bytes(changed))
        held = [step for run in found.runs for step in run]
        used = any(data[HEADER.size + (place - HEADER.size) // 32 * 32 :][:32])
        assert found.damaged == 1 and (not used or held != list(whole) or place < HEADER.size + 32)
        assert all(step == whole[step.number - 1] for step in held[:-1])
        assert not held or held[-1] == whole[held[-1].number - 1] or held[-1].fault is None


def checked(words: Sequence[int]) -> bytes:
    """Return a line with the check that belongs to its words."""
    check = reduce(lambda total, word: (total ^ word) * 16777619 & 0xFFFFFFFF, words, 2166136261)
    return LINE.pack(*words, check)


def is_well(model: Model, data: bytes, before: Sequence[bytes]) -> bool:
    """Return whether all that a box holds, and all that it held, is compared and as the reference answers."""
    found = read_box(data)
    steps = [step for run in found.runs for step in replay(model, run, before)]
    return not found.lost and all(step.agrees and step.expected is not None for step in steps)


def test_what_no_checker_writes_is_not_believed_though_its_check_is_right(boxing: Boxing, small: Build) -> None:
    """One word at a time, but what an event says itself (another may be answered alike) and the code of `invalid`."""
    data = boxing(60).run(boxing(60).lines(EVENTS))
    before = [json.dumps(event).encode() for event in EVENTS]
    assert is_well(small.model, data, before)
    for at in range(HEADER.size, len(data), LINE.size):
        *words, _ = LINE.unpack_from(data, at)
        what = words[2] & 255
        other_kind = [*words[:2], words[2] & ~255 | (box.OPENED if what in box.EVENTS else box.END + 1), *words[3:]]
        own = {box.OPENED: {1}, box.REPORT: {2, 3, 4, 5, 6}, box.VALUES: {3, 4, 5, 6}, box.ABORT: {3, 4}}
        mine = {5} if words[2] >> 8 & 0xFFFF == INVALID else {3} if what in box.EVENTS else set()
        others = set(range(7)) - own.get(what, mine)
        flips = [(word, bit) for word in others for bit in (0, 9, 31) if (word, bit) != (2, 0)]
        changed = [[*words[:word], words[word] ^ 1 << bit, *words[word + 1 :]] for word, bit in flips]
        for each in [*changed, other_kind] if any(words) else ():
            assert not is_well(small.model, data[:at] + checked(each) + data[at + LINE.size :], before), (words, each)


@pytest.mark.parametrize("back", [1, 2, 9])
def test_a_line_of_a_round_before_is_a_loss(back: int, boxing: Boxing, small: Build) -> None:
    """It stands where a line was never written, so its check is right."""
    boxed = boxing(20)
    lines = boxed.lines(EVENTS)
    data = boxed.run(lines)
    newest = max(LINE.unpack_from(data, HEADER.size + place * LINE.size)[0] for place in range(20))
    at = HEADER.size + (newest - 1 - back) % 20 * LINE.size
    number, *rest, _ = LINE.unpack_from(data, at)
    stale = data[:at] + checked([number - 20, *rest]) + data[at + LINE.size :]
    before = [json.dumps(event).encode() for event in EVENTS]
    assert is_well(small.model, data, before) and not is_well(small.model, stale, before)
    assert read_box(stale).lost == 1


def test_an_origin_that_the_spec_does_not_have_is_no_answer(small: Build) -> None:
    for origin, agrees in ((-1, True), (-2, False), (99, False)):
        (asked,) = replay(small.model, [BoxStep(1, box.ASK, (1,), 0, (), ((0x1E76, 1, 0, -1, origin),), 0)])
        assert asked.agrees == agrees


@pytest.mark.parametrize(
    ("answer", "agrees"),
    [((-1, -1, 2, -1), True), ((-1, -1, 0, -1), False), ((-1, -1, 10, -1), False), ((0, -1, 2, -1), False)],
)
def test_invalid_is_an_answer_with_one_of_its_codes(answer: tuple[int, ...], agrees: bool, small: Build) -> None:
    (asked,) = replay(small.model, [BoxStep(1, box.ASK, (99,), 0, (), ((0x1369, *answer),), 0)])
    assert asked.agrees == agrees


def test_a_step_that_was_not_answered_stands_in_the_box(small: Build, program: Path) -> None:
    """The event is written before the checker sees it: a program that is stopped in the step leaves it behind."""
    stopped = """
#include "exover_box.h"
#include <stdio.h>
#include <stdlib.h>
#include "native_tables.h"
static uint8_t record[EXOVER_BOX_BYTES(20)];
static uint64_t memory[NATIVE_MEMORY_BYTES / 8 + 1];
static exover r2c;
static exover_box box;
int main(void)
{
    const exover_value args[] = {{.real = 1}, {.integer = 0}};
    exover_load(&r2c, &native_tables, memory, sizeof memory);
    exover_box_open(&box, &r2c, record, sizeof record);
    exover_box_ask(&box, &r2c, 0, args, 2);
    exover_box_abort(&box, &r2c, 0, 0);
    return 1;
}
/* What the linker puts in the place of the runtime's own abort. */
size_t stop_in_the_step(exover *checker, int32_t request, int32_t slot);
size_t stop_in_the_step(exover *checker, int32_t request, int32_t slot)
{
    (void)checker, (void)request, (void)slot;
    fwrite(record, 1, sizeof record, stdout);
    fflush(stdout);
    _Exit(0);
}
"""
    folder = program.parent
    (folder / "stopped.c").write_text(stopped)
    (folder / "hooked.c").write_text(
        '#include "exover_box.h"\n#undef exover_abort\n#define exover_abort stop_in_the_step\n'
        "size_t stop_in_the_step(exover *checker, int32_t request, int32_t slot);\n"
        '#include "exover_box.c"\n'
    )
    compile_c(COMPILERS[0], [*WARNINGS, "-O1", "-c", f"-I{folder}"], [folder / "hooked.c"], folder / "hooked.o")
    sources = [folder / name for name in ("stopped.c", "hooked.o", "exover.c", "native_tables.c")]
    compile_c(QUICK, [*WARNINGS, f"-I{folder}"], sources, folder / "stopped")
    data = subprocess.run([folder / "stopped"], capture_output=True, check=True).stdout
    (run,) = read_box(data).runs
    assert [(step.number, step.fault) for step in run] == [(1, 0), (2, None)]
    asked, aborted = replay(small.model, run)
    assert asked.agrees and not aborted.agrees and aborted.recorded is None


@pytest.mark.parametrize("reopened", [True, False])
def test_a_resumed_checker_begins_a_run_that_needs_what_came_before(
    reopened: bool, small: Build, program: Path
) -> None:
    """It begins in the state of a record, so the reference does not begin anew in its place."""
    host = """
#include "exover_box.h"
#include <stdio.h>
#include "native_tables.h"
static uint8_t box_memory[EXOVER_BOX_BYTES(40)], record[NATIVE_RECORD_BYTES];
static uint64_t memory[2][NATIVE_MEMORY_BYTES / 8 + 1];
static exover r2c[2];
static exover_box box;
int main(void)
{
    const exover_value args[] = {{.real = 1}, {.integer = 0}};
    if (exover_load(&r2c[0], &native_tables, memory[0], sizeof memory[0]) != EXOVER_READY)
        return 1;
    exover_box_open(&box, &r2c[0], box_memory, sizeof box_memory);
    exover_box_ask(&box, &r2c[0], 0, args, 2);
    exover_box_ask(&box, &r2c[0], 2, NULL, 0);
    const size_t bytes = exover_export(&r2c[0], record, sizeof record);
    exover_box_ask(&box, &r2c[0], 2, NULL, 0);
    exover_box_ask(&box, &r2c[0], 2, NULL, 0);
    if (exover_resume(&r2c[1], &native_tables, memory[1], sizeof memory[1], record, bytes) != EXOVER_READY)
        return 2;
    REOPEN
    exover_box_abort(&box, &r2c[1], 0, 0);
    fwrite(box_memory, 1, sizeof box_memory, stdout);
    return 0;
}
"""
    folder = program.parent
    again = "exover_box_open(&box, &r2c[1], box_memory, sizeof box_memory);" if reopened else ""
    (folder / "resumed.c").write_text(host.replace("REOPEN", again))
    sources = [folder / name for name in ("resumed.c", "exover_box.c", "exover.c", "native_tables.c")]
    compile_c(QUICK, [*WARNINGS, f"-I{folder}"], sources, folder / "resumed")
    data = subprocess.run([folder / "resumed"], capture_output=True, check=True).stdout
    first, second = read_box(data).runs
    assert [step.number for step in first] == [1, 2, 3, 4] and [step.number for step in second] == [3]
    assert replay(small.model, second)[0].expected is None
    before = [json.dumps(step.event).encode() for step in replay(small.model, first)]
    (aborted,) = replay(small.model, second, before)
    assert aborted.agrees and [said.verb for said in aborted.recorded or ()] == ["kill"]


def test_what_is_no_event_is_recorded_and_told(boxing: Boxing, small: Build) -> None:
    lines = [
        "a 99 0", "a -1 0", "a 0 0", "a 0 3 0 0 0", "a 0 2 7ff8000000000000 0", "a 0 2 0 2", "a 1 0", "a 2 1 7",
        "o 0 7fffffffffffffff", "o 99 0", "o 1 fff0000000000000", "l 0 b", "l 9 0", "k 7 0", "k 0 9", "w 9", "w 0",
        "r 0 0 9 0 0", "r 0 0 1 -1 0", "r 0 1 2 5 0", "r 1 0 1 -1 1 0",
        "r 1 0 1 0 0", "r 1 0 3 0 0",
    ]  # fmt: skip
    (run,) = read_box(boxing(200).run(lines)).runs
    steps = replay(small.model, run)
    assert len(steps) == len(lines)
    assert [step.number for step in steps if not step.agrees] == []
    assert sum(isinstance(step.read, Invalid) for step in steps) >= len(lines) - 4


def test_a_bool_that_is_neither_of_its_numbers_is_taken_as_its_else() -> None:
    """JSON has no value for it; the C takes the `else` as for every reading that is out of range."""
    model = model_of(
        "spec s; poster near: bool = false else true; module m { request a() { fail close: when near; } request b(); }"
    )
    run = [
        BoxStep(1, box.ASK, (0,), 0, (), ((0x1E76, 0, 0, -1, -1),), 0),
        BoxStep(2, box.OBSERVE, (0,), 1, (2,), ((0x1369, -1, -1, 6, -1), (0x2F5B, 0, 0, 1, -1)), 0),
        BoxStep(3, box.OBSERVE, (0,), 1, (0,), (), 0),
        BoxStep(4, box.ASK, (0,), 0, (), ((0x1E76, 0, 0, -1, -1),), 0),
    ]
    steps = replay(model, run)
    assert [said.verb for said in steps[1].recorded or ()] == ["invalid", "kill"]
    assert [step.agrees for step in steps] == [True, True, True, False], "the killed slot is not reported yet"
    assert steps[1].event == {"observe": "near", "value": True}


def test_a_box_that_has_lost_its_place_changes_no_answer(boxing: Boxing, program: Path) -> None:
    boxed = boxing(40)
    lines = "".join(f"{line}\n" for line in boxed.lines(EVENTS))
    told = []
    for field in ("", "memory", "lines", "seal"):
        changes = {"BOX": str(boxed.file), "LINES": "40", "FIELD": field}
        done = subprocess.run(
            [program], input=lines, env={**os.environ, **changes}, capture_output=True, text=True, check=True
        )
        told.append(done.stdout)
        assert len(read_box(boxed.file.read_bytes()).runs) == (field == "")
        boxed.file.unlink()
    assert told == [told[0]] * 4 and told[0].count("\n") == len(EVENTS) + 1


TYPED = """
#include "boxed_api.h"
#include <stdio.h>
static boxed_checker r2c;
static uint8_t record[EXOVER_BOX_BYTES(30)];
int main(void)
{
    boxed_answer answer;
    if (boxed_start(&r2c) != EXOVER_READY)
        return 1;
    boxed_ask_nd_stop(&r2c, &answer); /* not recorded yet */
    boxed_report_nd_stop_ok(&r2c, &answer);
    if (boxed_start_stopped(&r2c) != EXOVER_READY || !boxed_record(&r2c, record, sizeof record))
        return 2;
    if (boxed_start(&r2c) != EXOVER_LIVE) /* goes on, and is recorded */
        return 3;
    boxed_ask_nd_goto(&r2c, 0.25, true, &answer);
    boxed_abort_nd_goto(&r2c, 0, &answer);
    boxed_observe_battery(&r2c, 12, &answer);
    fwrite(record, 1, sizeof record, stdout);
    return 0;
}
"""


def test_the_typed_api_records(small: Build, tmp_path: Path) -> None:
    for artefact in c.emit(small.model, small.tables, "boxed"):
        (tmp_path / artefact.name).write_bytes(artefact.content)
    (tmp_path / "host.c").write_text(TYPED)
    flags = [*WARNINGS, f"-I{tmp_path}", "-DEXOVER_BOX"]
    sources = [tmp_path / name for name in ("host.c", "boxed_api.c", "boxed_tables.c", "exover_box.c", "exover.c")]
    compile_c(COMPILERS[0], flags, sources, tmp_path / "host")
    data = subprocess.run([tmp_path / "host"], capture_output=True, check=True).stdout
    (run,) = read_box(data).runs
    steps = replay(small.model, run)
    assert [next(iter(step.event)) for step in steps] == ["ask", "abort", "observe"]
    assert all(step.agrees for step in steps)
    compile_c(COMPILERS[0], [*flags, "-c"], sources[:1], tmp_path / "host.o")
    with pytest.raises(AssertionError, match="boxed_start_recorded"):
        compile_c(COMPILERS[0], flags[:-1], [tmp_path / "host.o", *sources[1:]], tmp_path / "host")


OPEN = """    start(checker);
    let mut own = Checker::new(&TABLES);
    start(&mut own);
    let mut copied = std::fs::read(std::env::var("BOX").unwrap_or_default()).unwrap_or(vec![0_u8; 64 + 32 * 300]);
    assert!(own.record(&mut copied));
    answer_all(&mut own, &mut words)?;
    copied.iter().for_each(|byte| eprint!("{byte:02x}"));
    return Ok(());
    #[allow(unreachable_code)]
"""


def test_what_is_compiled_in_rust_has_every_construct() -> None:
    few, many = ([(built(path).model,) for path in paths] for paths in (IN_RUST, VECTORS))
    assert not seldom(few, many, 1)


@pytest.mark.skipif(which("rustc") is None, reason="rustc is not installed")
@pytest.mark.parametrize("vector", IN_RUST, indirect=True, ids=lambda path: path.stem)
def test_rust_writes_the_bytes_that_c_writes(vector: tuple[Path, Path], tmp_path: Path) -> None:
    """Also of an ask with more values than a line can count, and behind a line that stands in the place of another."""
    path, program = vector
    spec = built(path)
    text = path.with_suffix(".events.jsonl").read_text().splitlines()
    boxed = Boxed(program, spec, tmp_path, 300)
    lines = boxed.lines([json.loads(line) for line in text if line.startswith("{")])
    lines.insert(-5, f"a 0 65537{' 0' * 65537}")
    folder = tmp_path / "rust"
    folder.mkdir()
    flags = (*FLAGS, "-Dwarnings")
    build_crate(spec.model, spec.tables, "native", folder, (*flags, '--cfg=feature="black-box"'))
    runner = runtime_file("runner.rs").decode()
    recorded = runner.replace("    start(checker);\n    match", OPEN + "    match")
    assert recorded != runner
    (folder / "runner.rs").write_text(recorded)
    compile_in(
        folder, [*find_rustc(), EDITION, *flags, "--extern=native=libnative.rlib", "runner.rs"], "runner", "Rust"
    )

    def told(lines: Sequence[str], held: Path) -> bytes:
        given, environment = "".join(f"{line}\n" for line in lines), {**os.environ, "BOX": str(held)}
        done = subprocess.run(
            [folder / "runner"], input=given, env=environment, capture_output=True, text=True, check=True
        )
        return bytes.fromhex(done.stderr)

    data = boxed.run(lines)
    assert told(lines, tmp_path / "none") == data
    strayed = data[: HEADER.size] + checked([9_000_000, 1, box.OPENED, 0, 0, 0, 0]) + data[HEADER.size + LINE.size :]
    (tmp_path / "strayed").write_bytes(strayed)
    boxed.file.write_bytes(strayed)
    assert told(lines[:3], tmp_path / "strayed") == boxed.run(lines[:3])


# ---- exover replay ----


def command(folder: Path, *arguments: object) -> Ended:
    return Run(folder)("replay", *arguments)


def test_replay_tells_the_run_and_writes_its_events(boxing: Boxing, small: Build) -> None:
    boxed = boxing(100)
    boxed.run(boxed.lines(EVENTS))
    folder = boxed.folder
    (folder / "spec").mkdir()
    (folder / "spec" / "boxed.exo").write_text(SPEC)
    done = command(folder, "box.bin", "--events", "again.jsonl")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines()[:6] == [
        "run 1: steps 1 to 9, all as the reference answers",
        "1. ask nd.goto(x = 0.25, slow = true)",
        "     launch nd.goto[0]",
        "2. ask arm.move(mode = wild)",
        "     launch arm.move",
        "3. observe battery = 12",
    ]
    written = [json.loads(line) for line in (folder / "again.jsonl").read_text().splitlines()]
    plain = [event | {"args": event.get("args", {})} if "ask" in event else event for event in EVENTS]
    assert written == [{"abort": "nd.stop", "instance": 0} if "abort" in event else event for event in plain]


def test_replay_says_where_an_answer_is_not_that_of_the_reference(boxing: Boxing, small: Build) -> None:
    """The spec says something else than the tables that wrote the box: its bytes claim the same digest."""
    boxed = boxing(100)
    data = boxed.run(boxed.lines(EVENTS[:2]))
    (run,) = read_box(data).runs
    other = model_of(SPEC.replace("battery < 15", "battery < 101"))
    first, second = replay(other, run)
    assert first.agrees and not second.agrees


def test_the_spec_is_found_beside_what_is_none(boxing: Boxing, small: Build) -> None:
    boxed = boxing(100)
    boxed.run(boxed.lines(EVENTS))
    for name, content in (("a", b"\xff"), ("b", b"spec b"), ("c", b"spec c; include 'no.exo';"), ("z", SPEC.encode())):
        (boxed.folder / f"{name}.exo").write_bytes(content)
    (boxed.folder / "d.exo").symlink_to("nowhere")
    (boxed.folder / "e.exo").mkdir()
    done = command(boxed.folder, "box.bin")
    assert (done.returncode, done.stderr) == (0, "")


def flipped(data: bytes, place: int) -> bytes:
    """Return a box with one bit of the line at a place changed."""
    changed = bytearray(data)
    changed[HEADER.size + LINE.size * place + 20] ^= 1
    return bytes(changed)


def answered_wrongly(data: bytes) -> tuple[bytes, int]:
    """Return a box whose first launch has another slot, and the place of that line."""
    changed = bytearray(data)
    for place in range((len(data) - HEADER.size) // LINE.size):
        words = list(LINE.unpack_from(data, HEADER.size + LINE.size * place))
        if words[2] & 255 == box.ANSWER:
            words[4] += 1
            words[7] = reduce(lambda total, word: (total ^ word) * 16777619 & 0xFFFFFFFF, words[:7], 2166136261)
            LINE.pack_into(changed, HEADER.size + LINE.size * place, *words)
            return bytes(changed), place
    raise AssertionError("there is an answer")


def test_a_line_that_has_changed_hides_no_wrong_answer_of_another_step(boxing: Boxing, small: Build) -> None:
    boxed = boxing(100)
    boxed.run(boxed.lines(EVENTS))
    data, wrong = answered_wrongly(boxed.run(boxed.lines(EVENTS)))  # two runs
    (boxed.folder / "boxed.exo").write_text(SPEC)
    newest = max(line[0] for line in struct.iter_unpack("<8I", data[HEADER.size :]))
    for place in range(wrong + 3, newest - 1):
        boxed.file.write_bytes(flipped(data, place))
        done = command(boxed.folder, "box.bin", "boxed.exo")
        assert done.returncode == 1, place
        assert "1 lines of box.bin are half written or have changed: what they held is not compared" in done.stderr


def test_what_cannot_be_compared_is_never_well(boxing: Boxing, small: Build) -> None:
    boxed = boxing(100)
    boxed.run(boxed.lines(EVENTS))
    data = boxed.run(boxed.lines(EVENTS))
    (boxed.folder / "boxed.exo").write_text(SPEC)
    (boxed.folder / "log.jsonl").write_text("".join(f"{json.dumps(event)}\n" for event in EVENTS))
    newest = max(line[0] for line in struct.iter_unpack("<8I", data[HEADER.size :]))
    for place in range(newest - 1):
        for content in (flipped(data, place), data[: 64 + 32 * place] + bytes(32) + data[96 + 32 * place :]):
            boxed.file.write_bytes(content)
            done = command(boxed.folder, "box.bin", "boxed.exo")
            assert done.returncode == 3, place
    first = read_box(data).runs[0]
    parts = read_box(flipped(data, 12)).runs
    assert [step for part in parts[:2] for step in part] == [step for step in first if step.number != 3]
    boxed.file.write_bytes(flipped(data, 12))
    assert "not compared: the 3 steps before it are lost" in command(boxed.folder, "box.bin", "boxed.exo").stdout
    done = command(boxed.folder, "box.bin", "boxed.exo", "--after", "log.jsonl")
    assert done.returncode == 3
    assert [line.partition(", ")[2] for line in done.stdout.splitlines() if line.startswith("run ")] == [
        "all as the reference answers"
    ] * 3


def test_a_line_that_is_half_written_behind_the_newest_is_no_loss(boxing: Boxing, small: Build) -> None:
    boxed = boxing(100)
    data = boxed.run(boxed.lines(EVENTS))
    (boxed.folder / "boxed.exo").write_text(SPEC)
    newest = max(line[0] for line in struct.iter_unpack("<8I", data[HEADER.size :]))
    boxed.file.write_bytes(flipped(data, newest))
    done = command(boxed.folder, "box.bin", "boxed.exo")
    assert (done.returncode, "1 lines of box.bin" in done.stderr) == (0, True)


def test_replay_of_a_box_that_is_none(tmp_path: Path, small: Build, boxing: Boxing) -> None:
    boxed = boxing(20)
    data = boxed.run(boxed.lines(EVENTS))
    (tmp_path / "boxed.exo").write_text(SPEC)
    (tmp_path / "other.exo").write_text("spec other; module m { request a(); }")
    cases = {
        b"": "no black box: it does not begin as one",
        data[:-1]: "no black box: 704 bytes belong to it, and 703 are there",
        data[:4] + b"\x02" + data[5:]: "no black box: its format is 2",
        data[:20] + b"?" + data[21:]: "no black box: its header has changed",
        data[:64] + bytes(len(data) - 64): "holds no event",
    }
    for content, message in cases.items():
        (tmp_path / "bad.bin").write_bytes(content)
        done = command(tmp_path, "bad.bin")
        assert (done.returncode, done.stdout) == (2, "")
        assert message in done.stderr
    done = command(tmp_path, "box.bin", "other.exo")
    assert (done.returncode, done.stdout) == (2, "")
    assert "written for another spec than other.exo" in done.stderr
    (tmp_path / "boxed.exo").unlink()
    done = command(tmp_path, "box.bin")
    assert done.returncode == 2 and "no spec here has the sha256" in done.stderr


def test_replay_of_a_box_whose_beginning_is_lost(boxing: Boxing, small: Build) -> None:
    boxed = boxing(20)
    boxed.run(boxed.lines(EVENTS))
    folder = boxed.folder
    (folder / "boxed.exo").write_text(SPEC)
    done = command(folder, "box.bin", "boxed.exo", "--events", "held.jsonl")
    assert done.returncode == 3 and "give their events with --after" in done.stdout
    held = (folder / "held.jsonl").read_text().splitlines()
    lost = len(EVENTS) - len(held)
    assert lost and f"held.jsonl begins behind step {lost} of its run" in done.stderr
    log = [json.dumps(event) for event in EVENTS]
    (folder / "log.jsonl").write_text("\n\n".join([*log, ""]))
    done = command(folder, "box.bin", "boxed.exo", "--after", "log.jsonl", "--events", "whole.jsonl")
    assert (done.returncode, done.stderr) == (0, "") and "all as the reference answers" in done.stdout
    assert (folder / "whole.jsonl").read_text().splitlines() == [*log[:lost], *held]


@pytest.mark.parametrize(
    ("anew", "held"),
    [((2**32 - 1, 0), 0), ((2**32 - 1, 0), 2), ((2**29, 1), 2)],
    ids=["from 0", "behind 2^32", "behind 2^29"],
)
def test_steps_that_are_counted_anew_go_on(boxing: Boxing, small: Build, anew: tuple[int, int], held: int) -> None:
    """What is before them is lost, and they are not taken for a run of their own that begins where the checker does."""
    boxed = boxing(20)
    data = bytearray(boxed.run(boxed.lines(EVENTS)))
    first = read_box(bytes(data)).runs[0][0].number
    for place in range(HEADER.size, len(data), LINE.size):
        words = list(LINE.unpack_from(data, place))
        after = words[1] - first - held
        words[1] = anew[1] + after if after >= 0 else anew[0] + after + 1
        words[7] = reduce(lambda total, word: (total ^ word) * 16777619 & 0xFFFFFFFF, words[:7], 2166136261)
        LINE.pack_into(data, place, *words)
    (run,) = read_box(bytes(data)).runs
    assert run[held].number == anew[1]
    boxed.file.write_bytes(data)
    (boxed.folder / "boxed.exo").write_text(SPEC)
    done = command(boxed.folder, "box.bin", "boxed.exo")
    assert (done.returncode, done.stderr) == (3, "")
    assert f"not compared: the {(run[0].number - 1) % 2**32} steps before it are lost" in done.stdout
