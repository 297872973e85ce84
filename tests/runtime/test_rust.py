"""The emitted crate: it decides as reference, tables and C do, cannot panic, and fails towards refusal.

Left out where no Rust is installed.
"""

import os
import re
import struct
import subprocess
from dataclasses import dataclass
from pathlib import Path
from shutil import which

import pytest

from benchmarks.families import mutexes
from exover.bounds.sizes import shape, state_bytes
from exover.emit import rust
from exover.emit.rustnames import names
from exover.engines.compiler import NativeUnavailable, compile_in
from exover.model.event import Ask, Launched
from exover.model.model import Model
from exover.ocrd.packing import pack
from exover.ocrd.tables import AGREE, KILL, LAUNCH, NONE, Node, Tables
from exover.pipeline import build
from exover.run.embedded import embedded
from exover.run.rust import build as build_runner
from exover.run.rust import build_crate, engine_of, find_rustc
from tests.docs.pages import blocks
from tests.runtime.compiling import (
    BAD_CHECKSUM,
    BAD_COUNTS,
    FAULT_CHANNELS,
    FAULT_CHECKER,
    FAULT_DECISION,
    FAULT_INDEX,
    FAULT_PATH,
    FAULT_STATE,
    FAULT_TABLES,
    FAULTY,
    NO_MAGIC,
    OTHER_FORMAT,
    OTHER_WIDTH,
    READY,
    ROOT,
    built,
    model_of,
    mutex_words,
    runner,
    talk,
)
from tests.runtime.contradictory import MODEL, TABLES, all_actions, edited
from tests.runtime.resuming import FAST, FAST_CRATE, needs_rustc
from tests.support.constructs import seldom
from tests.support.engines import agree_at_random
from tests.support.fuzz import spec_of
from tests.support.vectors import NAMES
from tests.support.vectors import model_of as vectors_model

needs_cargo = pytest.mark.skipif(which("cargo") is None, reason="cargo is not installed")
CORNERS = ROOT / "tests" / "vectors" / "corners.exo"
ROVER = ROOT / "specs" / "rover.exo"
DECISIONS = int(os.environ.get("EXOVER_DECISIONS", "1000000"))
DECIDED = 50 if "EXOVER_DECISIONS" in os.environ else 10
"""Requests of which many are decided, by the checker whose bits are flipped where that has as many."""
REQUESTS = 50 if os.environ.get("EXOVER_ALL_FAULTS") else 10
MANY = range(200, 212)
FEW = (200, 206)
"""Random specs that have, with those of tests/vectors, every construct of the many: to compile one takes a second.

`make soak` takes all.
"""


@needs_rustc
@pytest.mark.parametrize("seed", MANY if "EXOVER_DECISIONS" in os.environ else FEW)
def test_rust_answers_as_the_others_do(seed: int) -> None:
    agree_at_random(spec_of(seed), seed, 400, native=True, rust=True)


@needs_rustc
def test_a_checker_that_is_larger_than_a_stack_runs() -> None:
    model = model_of("spec many; module m { request a() instances 65535; request b() instances 65535; }")
    with engine_of(model, build(model).tables) as engine:
        assert engine.step(Ask("m.b", ())) == (Launched("m.b", 0, ()),)


def test_few_specs_have_every_construct() -> None:
    few, many = ([(model_of(spec_of(seed)),) for seed in seeds] for seeds in (FEW, MANY))
    vectors = [(vectors_model(name),) for name in NAMES]
    assert not seldom([*few, *vectors], many, 1)


def rustc(source: Path, folder: Path, *arguments: str) -> None:
    """Compile a program, in a folder with all that it reads."""
    (folder / source.name).write_bytes(source.read_bytes())
    command = [*find_rustc(), "--edition=2021", "-Dwarnings", *arguments, source.name]
    compile_in(folder, command, source.stem, "Rust")


def write(model: Model, folder: Path, name: str) -> None:
    """Write the crate of a model into a folder."""
    (folder / "src").mkdir()
    for artefact in rust.emit(model, build(model).tables, name):
        (folder / artefact.name).write_bytes(artefact.content)


@dataclass(frozen=True)
class Watch:
    """A program that watches a checker, and the rules that it reads."""

    program: Path
    rules: bytes

    def run(self, *arguments: str) -> str:
        done = subprocess.run([self.program, *arguments], input=self.rules, capture_output=True, check=False)
        assert done.returncode == 0, done.stderr.decode()
        return done.stdout.decode()


def watch(size: int, folder: Path) -> Watch:
    """Return the program for a checker of so many requests."""
    model = model_of(mutexes(size))
    build_crate(model, build(model).tables, "watched", folder, FAST_CRATE)
    rustc(Path(__file__).parent / "watch.rs", folder, *FAST, "--extern=watched=libwatched.rlib")
    return Watch(folder / "watch", mutex_words(model))


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Watch:
    """Return the program for few requests."""
    return watch(REQUESTS, tmp_path_factory.mktemp("watch"))


@needs_rustc
def test_random_decisions(small: Watch, tmp_path: Path) -> None:
    watched = small if DECIDED == REQUESTS else watch(DECIDED, tmp_path)
    launched, rejected, reported = map(int, watched.run("decisions", str(DECISIONS)).split())
    assert launched + rejected == DECISIONS
    assert min(launched, rejected, reported) > DECISIONS // 10


@needs_rustc
def test_no_flipped_bit_lets_anything_unsafe_pass(small: Watch) -> None:
    """Not found is only what nobody reads before it is written again, and what fills structures up."""
    lines = [line.split(maxsplit=4) for line in small.run("flips").splitlines()]
    found = {title: (int(flips), int(missed), int(unsafe)) for title, flips, missed, unsafe, _ in lines}
    tables = build(model_of(mutexes(REQUESTS))).tables
    *_, cells, _, values, _, _, _ = shape(tables)
    itself = 2 * struct.calcsize("P") + 6 * 4  # where the tables are, fault, agenda, guard; how far the scrubbing is
    remembered = 8 * (cells * 2 * state_bytes(tables) + 16 * values + itself)
    assert [unsafe for _, _, unsafe in found.values()] == [0, 0, 0]
    for title, needed in (("load", 8 * len(pack(tables))), ("tables", 8 * len(pack(tables))), ("checker", remembered)):
        flips, missed, _ = found[title]
        assert missed <= flips - needed
    causes = {title: set(map(int, re.findall(r"\d+", seen))) for title, *_, seen in lines}
    assert causes["load"] == {READY, NO_MAGIC, OTHER_FORMAT, OTHER_WIDTH, BAD_COUNTS, BAD_CHECKSUM}
    assert causes["tables"] >= {FAULT_PATH, FAULT_DECISION, FAULT_CHANNELS, FAULT_INDEX, FAULT_TABLES}
    assert causes["checker"] >= {FAULT_STATE, FAULT_TABLES, FAULT_CHECKER}


@needs_rustc
def test_what_a_faulty_checker_still_does(small: Watch) -> None:
    assert small.run("faults") == ""


@needs_rustc
def test_what_every_single_flip_leads_to(tmp_path: Path) -> None:
    """No argument is handed out that has changed; after a fault aborts kill, who waits is told, nothing is launched."""
    model = model_of(FAULTY)
    tables = build(model).tables
    build_crate(model, tables, "faulty", tmp_path, FAST_CRATE)
    rustc(Path(__file__).parent / "faulty.rs", tmp_path, *FAST, "--extern=faulty=libfaulty.rlib")
    done = subprocess.run([tmp_path / "faulty"], capture_output=True, text=True, check=True)
    faults, *wrong = map(int, done.stdout.split())
    assert faults > 8 * 2 * state_bytes(tables) * len(tables.entries) and wrong == [0, 0, 0, 0]


LAST = max((n for n, node in enumerate(TABLES.nodes) if node.code == -KILL), key=lambda n: TABLES.nodes[n].low == NONE)
FIRST = next(number for number, node in enumerate(TABLES.nodes) if node.code == -LAUNCH)


@needs_rustc
@pytest.mark.parametrize(
    ("broken", "lines"),
    [
        (all_actions(LAUNCH, Node(-AGREE, 0, NONE, 0)), "a 0 0 a 1 0 k 0 0 f"),
        (
            edited({r.decide: Node(TABLES.nodes[r.decide].code, 0, NONE, NONE) for r in TABLES.requests}),
            "a 0 0 a 1 0 f",
        ),
        (
            edited({TABLES.requests[0].decide: Node(0, 0, FIRST, FIRST)}),
            "a 0 0 a 0 0 k 0 0 r 0 0 1 -1 0 r 0 0 1 -1 0 f",
        ),
        (edited({LAST: Node(-AGREE, 0, NONE, 0)}), "a 0 0 a 1 0 a 2 0 f"),
    ],
    ids=["an action that is no decision", "no decision", "no idle slot", "a kill before a fault"],
)
def test_tables_that_contradict_themselves(broken: Tables, lines: str, tmp_path: Path) -> None:
    """What is found wrong in them is answered as in C."""
    for folder in ("c", "rust"):
        (tmp_path / folder).mkdir()
    answers = talk(runner(MODEL, broken, tmp_path / "c"), lines)
    assert any(" -4 -1;" in line for line in answers)
    assert talk(build_runner(MODEL, broken, tmp_path / "rust"), lines) == answers


@needs_rustc
@pytest.mark.skipif(which("nm") is None, reason="nm is not installed")
@pytest.mark.parametrize(
    ("name", "text"),
    [("native", CORNERS.read_text("utf-8")), ("watched", mutexes(REQUESTS)), ("faulty", FAULTY)],
    ids=["all there is", "mutexes alone", "no mutex"],
)
def test_it_cannot_panic(name: str, text: str, tmp_path: Path) -> None:
    """What is compiled refers to nothing that panics, not even where overflows are looked for."""
    model = model_of(text)
    build_crate(model, build(model).tables, name, tmp_path, FAST_CRATE)
    (code,) = tmp_path.glob("*.o")
    defined = subprocess.run(["nm", "--defined-only", code], capture_output=True, text=True, check=True).stdout
    assert "Checker" in defined
    undefined = subprocess.run(["nm", "-u", code], capture_output=True, text=True, check=True).stdout.split()[1::2]
    assert [name for name in undefined if not re.fullmatch(r"mem(cpy|set|move|cmp)", name)] == []


WIDE = """spec wide; enum e { x, y } poster a: int in -1000000000000 .. 1000000000000 = 0; poster b: e = x;
module m { request q(v: int in -1000000000000 .. 1000000000000, k: e) fails (lost) { check v + a <= 4; } }"""


@needs_cargo
@pytest.mark.parametrize(
    ("text", "features"),
    [
        (CORNERS.read_text("utf-8"), []),
        (CORNERS.read_text("utf-8"), ["--features=names"]),
        (WIDE, ["--features=names"]),
    ],
    ids=["all there is", "with names", "wide numbers, few records"],
)
def test_cargo_builds_without_a_network_and_clippy_finds_nothing(
    text: str, features: list[str], tmp_path: Path
) -> None:
    write(model_of(text), tmp_path, "crate")
    lint = which("cargo-clippy") is not None
    command = ["cargo", "clippy" if lint else "build", "--offline", "--quiet", *features]
    command += ["--", "-Dwarnings"] if lint else []
    environment = {**os.environ, "CARGO_TARGET_DIR": str(tmp_path / "target"), "CARGO_INCREMENTAL": "0"}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@needs_rustc
def test_the_example_of_the_manual_runs(tmp_path: Path) -> None:
    page = blocks(ROOT / "docs" / "runtime.md")
    (at,) = [number for number, block in enumerate(page) if block.language == "rust"]
    (tmp_path / "main.rs").write_text(page[at].text, encoding="utf-8")
    found = built(ROVER)
    build_crate(found.model, found.tables, "rover", tmp_path, ("--cfg", 'feature="names"'))
    rustc(tmp_path / "main.rs", tmp_path, "--extern=rover=librover.rlib")
    done = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=True)
    assert done.stdout == page[at + 1].text


@needs_rustc
@pytest.mark.parametrize("path", [ROVER, CORNERS], ids=["rover", "corners"])
def test_its_tables_are_read_back(path: Path, tmp_path: Path) -> None:
    found = built(path)
    write(found.model, tmp_path, "crate")
    source = tmp_path / "src" / "tables.rs"
    assert embedded(source) == pack(build(found.model).tables)
    text = source.read_text(encoding="utf-8")
    source.write_text(text.replace("NodeRow([", "NodeRow([1 + ", 1), encoding="utf-8")
    assert embedded(source) != pack(build(found.model).tables)
    source.write_text(text.replace("pub static TABLES", "pub static OTHERS"), encoding="utf-8")
    with pytest.raises(NativeUnavailable, match="TABLES"):
        embedded(source)


def test_no_rust(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("RUSTC", "no-such-compiler -O")
    found = built(ROVER)
    with pytest.raises(NativeUnavailable, match="no-such-compiler"), engine_of(found.model, found.tables):
        pass
    (tmp_path / "tables.rs").touch()
    with pytest.raises(NativeUnavailable, match="no-such-compiler"):
        embedded(tmp_path / "tables.rs")


# ---- names, which need no Rust ----


def test_names_are_made_legal_and_each_once() -> None:
    requests = "module m { request a_b(); request a__b(); request aB(); } module _ { request _(); }"
    text = names(model_of(f"spec s; {requests} poster Self: bool = false;"))
    for variant in ("MAB = 0", "MAB_2 = 1", "MAB_3 = 2", "N = 3", "Self_2 = 0"):
        assert f"    {variant}," in text
    assert "pub enum Stock {\n}" in text and "match self {}" in text


@pytest.mark.parametrize(
    ("name", "package"),
    [("rover", "rover"), ("R2C", "r2c"), ("fn", "spec_fn"), ("test", "spec_test"), ("_x", "spec_x"), ("a.b", "a_b")],
)
def test_the_package_has_a_name_that_cargo_takes(name: str, package: str) -> None:
    assert rust.package(name) == package


def test_the_same_input_gives_the_same_bytes() -> None:
    found = built(ROVER)
    assert rust.emit(found.model, build(found.model).tables, "rover") == rust.emit(found.model, found.tables, "rover")
