"""The harness, compiled once for all tests."""

from pathlib import Path

import pytest

from tests.runtime.compiling import COMPILERS, RUNTIME, SANITIZERS, WARNINGS, Harness, compile_c


@pytest.fixture(scope="session")
def harness(tmp_path_factory: pytest.TempPathFactory) -> Harness:
    """Return the harness for tables of width 2, with sanitizers."""
    program = tmp_path_factory.mktemp("harness") / "harness"
    sources = [Path(__file__).parent / "harness.c", RUNTIME / "exover.c"]
    compile_c(COMPILERS[0], [*WARNINGS, *SANITIZERS, "-DEXOVER_WIDTH=2", f"-I{RUNTIME}"], sources, program)
    return Harness(program)
