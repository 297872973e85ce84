"""After any fault what runs can be stopped, whoever waits is told, and no argument is believed that has changed."""

import re
import subprocess
from itertools import combinations
from pathlib import Path

import pytest

from exover.emit import c
from exover.pipeline import build
from exover.run import codec
from tests.runtime.compiling import COMPILERS, FAULTY, RUNTIME, SANITIZERS, WARNINGS, compile_c, model_of


@pytest.fixture(scope="module", params=["emitted", "any tables"])
def faulty(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("faulty")
    model = model_of(FAULTY)
    for artefact in c.emit(model, build(model).tables, "faulty"):
        (folder / artefact.name).write_bytes(artefact.content)
    which = [] if request.param == "emitted" else ["-DEXOVER_WIDTH=2"]
    names = ("faulty_api.c", "faulty_tables.c", "exover.c")
    sources = [Path(__file__).parent / "faulty.c", *(folder / name for name in names)]
    compile_c(COMPILERS[0], [*WARNINGS, *SANITIZERS, f"-I{folder}", *which], sources, folder / "faulty")
    return folder / "faulty"


def seen(program: Path, what: str) -> str:
    return subprocess.run([program, what], capture_output=True, text=True, check=True, timeout=120).stdout.strip()


def test_arguments_that_have_changed_are_not_handed_out(faulty: Path) -> None:
    """Of all bits of two arguments and of their complements none is handed out, and each is a fault from then on."""
    assert seen(faulty, "arguments") == "0 0"


def test_after_every_flip_aborts_kill_and_who_waits_is_told(faulty: Path) -> None:
    assert seen(faulty, "answers") == "1 0 0 0"


def test_the_first_answer_after_a_fault_rejects_what_waits(faulty: Path) -> None:
    """Whichever call it is; the second is silent about it."""
    assert seen(faulty, "told") == "10" * 5


def test_codes_of_answers_are_far_apart() -> None:
    header = (RUNTIME / "exover.h").read_text()
    codes = [int(code, 16) for code in re.findall(r"^    EXOVER_[A-Z]+ = (0x[0-9a-f]{4})", header, re.MULTILINE)]
    known = [codec.LAUNCH, codec.WAIT, codec.REJECT, codec.KILL, codec.VIOLATION, codec.INVALID]
    assert codes == known
    assert min((one ^ other).bit_count() for one, other in combinations([0, *codes], 2)) >= 4


def test_no_flip_of_an_answer_or_of_their_number_is_a_launch(faulty: Path) -> None:
    assert seen(faulty, "words") == "0 0 0"


def test_nothing_stands_behind_the_answers_of_a_cycle(faulty: Path) -> None:
    assert seen(faulty, "cycle") == "1 0"


def test_idle_time_finds_every_bit_without_an_event(faulty: Path) -> None:
    assert seen(faulty, "scrub") == "0 0 0"


def test_what_slots_and_waiting_places_hold_and_since_when(faulty: Path) -> None:
    assert seen(faulty, "views") == "1" * 7
