"""`exover doctor`: a line for each thing that may be missing, whether it is there or not."""

import sys
from pathlib import Path

from tests.cli.conftest import Run, environment

NAMES = ["CUDD", "python-sat", "ABC", "NuSMV", "C compiler", "rustc", "cargo"]


def test_a_line_for_each(run: Run) -> None:
    ended = run("doctor")
    assert (ended.returncode, ended.stderr) == (0, "")
    assert [line[2:].split(": ")[0] for line in ended.stdout.splitlines()] == NAMES
    assert all(line[0] in "+-" and "; " in line for line in ended.stdout.splitlines())


def test_what_is_missing_is_no_error(run: Run, tmp_path: Path) -> None:
    ended = run("doctor", env=environment(PATH=str(tmp_path), CC="nothing", RUSTC="nothing"))
    assert (ended.returncode, ended.stderr) == (0, "")
    marks = {line[2:].split(": ")[0]: line for line in ended.stdout.splitlines()}
    assert marks["ABC"].startswith("- ABC: not there (no ABC was found on PATH); ")
    assert all(marks[name][0] == "-" for name in ("C compiler", "rustc", "cargo"))


def test_what_is_no_abc_is_not_taken_for_it(run: Run, tmp_path: Path) -> None:
    (tmp_path / "abc").write_text(f"#!{sys.executable}\nprint('ABC 9.99')\n")
    (tmp_path / "abc").chmod(0o755)
    ended = run("doctor", env=environment(PATH=str(tmp_path)))
    (line,) = (line for line in ended.stdout.splitlines() if line[2:].startswith("ABC"))
    assert line[0] == "-" and "does not answer as ABC does" in line
