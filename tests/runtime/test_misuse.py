"""What a host must not do, or what changes between two instructions: calls within calls, copies, flips within a step.

Interrupting a step after each of its instructions needs an x86-64 under Linux; elsewhere these two are left out.
"""

import platform
import subprocess
import sys
from pathlib import Path

import pytest

from exover.emit import c
from exover.pipeline import build
from tests.runtime.compiling import COMPILERS, FAULT_CHECKER, MISALIGNED, READY, WARNINGS, compile_c, model_of

SPEC = "spec misuse; module m { request a(); request b(); } mutex apart: m.a, m.b;"
STEPPED = pytest.mark.skipif(
    platform.machine() != "x86_64" or sys.platform != "linux", reason="steps by the trap flag of an x86-64 under Linux"
)


@pytest.fixture(scope="module")
def misuse(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("misuse")
    model = model_of(SPEC)
    for artefact in c.emit(model, build(model).tables, "misuse"):
        (folder / artefact.name).write_bytes(artefact.content)
    sources = [Path(__file__).parent / "misuse.c", folder / "misuse_tables.c", folder / "exover.c"]
    compile_c(COMPILERS[0], [*WARNINGS, "-O2", f"-I{folder}"], sources, folder / "misuse")
    return folder / "misuse"


def seen(program: Path, what: str) -> list[int]:
    done = subprocess.run([program, what], capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, (done.returncode, done.stderr)
    return list(map(int, done.stdout.split()))


@STEPPED
def test_a_call_within_a_call_never_launches_both_of_a_pair(misuse: Path) -> None:
    """Not at once, and not by an ask that follows; most instructions of a step lie between its first and last look."""
    both, afterwards, mostly_faults = seen(misuse, "reenter")
    assert (both, afterwards, mostly_faults) == (0, 0, 1)


@STEPPED
def test_answers_stay_within_their_places_whatever_their_number_becomes(misuse: Path) -> None:
    assert seen(misuse, "count") == [0, 0]


def test_a_copy_denies_and_the_original_goes_on(misuse: Path) -> None:
    assert seen(misuse, "copy") == [1, FAULT_CHECKER, READY]


def test_the_same_bit_of_two_pointers_breaks_the_seal(misuse: Path) -> None:
    assert seen(misuse, "pointers") == [0]


def test_only_codes_that_there_are_are_told(misuse: Path) -> None:
    assert seen(misuse, "numbers") == [0]


def test_tables_have_to_be_aligned(misuse: Path) -> None:
    assert seen(misuse, "alignment") == [MISALIGNED]
