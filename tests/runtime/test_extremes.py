"""No number of damaged tables makes an expression overflow, a pointer leave its array, or a step endless."""

import subprocess
from pathlib import Path

import pytest

from exover.ocrd.packing import pack, words
from exover.pipeline import build
from tests.runtime.compiling import COMPILERS, ROOT, RUNTIME, SANITIZERS, WARNINGS, compile_c, model_of

BOUNDS = {4: 1_000_000, 8: 1_000_000_000_000}
"""Bytes of words, and a reading that needs them."""


@pytest.fixture(scope="module", params=BOUNDS, ids=lambda width: f"{8 * width} bits")
def extremes(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, int]:
    """Return the program for a width, and a reading that needs it."""
    program = tmp_path_factory.mktemp("extremes") / "extremes"
    sources = [Path(__file__).parent / "extremes.c"]
    compile_c(
        COMPILERS[0],
        [*WARNINGS, "-Wno-shadow", *SANITIZERS, f"-DEXOVER_WIDTH={request.param}", f"-I{RUNTIME}"],
        sources,
        program,
    )
    return program, BOUNDS[request.param]


@pytest.mark.parametrize("checked", [False, True], ids=["no check words", "check words"])
@pytest.mark.parametrize("name", ["specs/rover", "tests/vectors/corners"])
def test_extreme_numbers_stay_defined(name: str, checked: bool, extremes: tuple[Path, int]) -> None:
    program, far = extremes
    text = (ROOT / f"{name}.exo").read_text(encoding="utf-8") + f"\nposter far: int in -{far} .. {far} = 0;\n"
    tables = build(model_of(text)).tables
    done = subprocess.run(
        [program, *["checked"] * checked], input=pack(tables), capture_output=True, check=False, timeout=120
    )
    assert done.returncode == 0, done.stderr.decode()
    count, found = map(int, done.stdout.split())
    assert count == len(words(tables)) and found > 100
