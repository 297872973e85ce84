"""What changes between two instructions of a step is found where it is used: the step is stopped there, and goes on."""

import subprocess
from pathlib import Path

import pytest

from exover.emit import c
from exover.pipeline import build
from exover.run.codec import FAULTY, REJECT
from tests.runtime.compiling import (
    COMPILERS,
    FAULT_ACTIONS,
    FAULT_ANSWERS,
    FAULT_INDEX,
    FAULT_STATE,
    SANITIZERS,
    WARNINGS,
    compile_c,
    model_of,
)

SPEC = """spec guards;
poster p: bool = false;
poster top: real in 0 .. 2 = 1;
resource film: 3 consumable = 1;
module m {
    request a(v: real in 0 .. 2, n: int in 0 .. 3) returns (z: real in 0 .. 2) {
        check v <= 1 or past(m.a with z > v);
    }
    request b() { wait until not active(m.a); }
    request c() { interrupts m.a; }
    request d(v: real in 0 .. 2) instances 2 { fail when v > top; }
}"""


@pytest.fixture(scope="module")
def guards(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("guards")
    model = model_of(SPEC)
    for artefact in c.emit_tables(model, build(model, unchecked=True).tables, "guards"):
        (folder / artefact.name).write_bytes(artefact.content)
    flags = [*WARNINGS, "-Wno-shadow", *SANITIZERS, "-DEXOVER_WIDTH=2", f"-I{folder}"]
    sources = [Path(__file__).parent / "guards.c", folder / "guards_tables.c"]
    compile_c(COMPILERS[0], flags, sources, folder / "guards")
    return folder / "guards"


def seen(program: Path, what: str) -> list[str]:
    done = subprocess.run([program, what], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_a_call_within_a_step_has_no_answers_and_the_step_launches_nothing(guards: Path) -> None:
    """Each call that there is; the step that it interrupts rejects what waits, and what was asked for."""
    counts, ended = seen(guards, "within")
    assert counts == "0 0"
    assert ended == f"{REJECT} 1 {FAULTY};{REJECT} 2 {FAULTY};"


def test_a_number_of_answers_that_has_grown_is_a_fault_where_it_is_used(guards: Path) -> None:
    (line,) = seen(guards, "numbers")
    said, killed, ended = [FAULT_ACTIONS, 1], [FAULT_ACTIONS, 0], [1, 1, FAULT_ACTIONS]
    assert list(map(int, line.split())) == [*said, *killed, *ended, 1, FAULT_ANSWERS]


def test_a_step_whose_fault_has_lost_its_cause_launches_nothing(guards: Path) -> None:
    assert seen(guards, "cause") == [f"{REJECT} 2 {FAULTY};"]


def test_records_that_have_changed_since_they_were_read_are_a_fault(guards: Path) -> None:
    """Ranges of parameters, then of cuts; and what a slot weighs by its argument, by none, by one that there is not."""
    (line,) = seen(guards, "records")
    assert list(map(int, line.split())) == [*[FAULT_INDEX] * 5, 2, 1, 1]


def test_arguments_that_have_changed_are_a_fault_where_a_poster_is_read(guards: Path) -> None:
    assert seen(guards, "posters") == [f"{REJECT} -1 {FAULTY};", str(FAULT_STATE)]


def test_tables_are_not_swapped_to_by_a_checker_that_has_changed(guards: Path) -> None:
    assert seen(guards, "swapped") == [f"{REJECT} -1 {FAULTY};"]
