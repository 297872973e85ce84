"""What libFuzzer begins with in `make fuzz-c` are tables that load and launch: it looks behind their head."""

import subprocess
from pathlib import Path

from tests.runtime.compiling import COMPILERS, READY, RUNTIME, SANITIZERS, WARNINGS, compile_c
from tests.runtime.corpus import WIDTH, write


def test_the_fuzzer_begins_with_tables_that_load_and_launch(tmp_path: Path) -> None:
    program = tmp_path / "alone"
    flags = [*WARNINGS, *SANITIZERS, "-DALONE", f"-DEXOVER_WIDTH={WIDTH}", f"-I{RUNTIME}"]
    compile_c(COMPILERS[0], flags, [Path(__file__).parent / "fuzz.c"], program)
    files = write(tmp_path / "corpus")
    done = subprocess.run([program, *files], capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr
    found = [tuple(map(int, line.split())) for line in done.stdout.splitlines()]
    assert [status for status, _ in found] == [READY] * len(files) and len(files) > 10
    assert all(launches for _, launches in found)
