"""`exover doctor`: a line for each thing that may be missing, whether it is there or not."""

import argparse
import platform
import re
import sys
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import pytest

from exover import __version__
from exover.cli import doctor
from tests.support.command import Run, environment

NAMES = [
    "CUDD",
    "Z3",
    "python-sat",
    "ABC",
    "NuSMV",
    "pygls",
    "Cyclone DDS",
    "rosbags",
    "pyarrow",
    "dask.distributed",
    "opentelemetry",
    "Graphviz",
    "C compiler",
    "rustc",
    "cargo",
]
MARKED = re.compile(r"^([-+!]) ([^:]+): (.*)$")


def marks(printed: str) -> dict[str, tuple[str, str, str]]:
    """Return mark, text and what is to do of each library and program."""
    lines = printed.splitlines()
    found = {}
    for line, below in zip(lines, [*lines[1:], ""], strict=True):
        if told := MARKED.match(line):
            found[told[2]] = (told[1], told[3], below.removeprefix("    to do: ") if below.startswith("    ") else "")
    return found


def test_a_line_for_each(run: Run) -> None:
    ended = run("doctor")
    assert (ended.returncode, ended.stderr) == (0, "")
    found = marks(ended.stdout)
    assert list(found) == NAMES
    assert all("; " in text and (mark == "+") == (todo == "") for mark, text, todo in found.values())
    versions = f"exover {__version__}, Python {platform.python_version()}, "
    assert ended.stdout.startswith(versions)


def test_what_is_missing_is_no_error(run: Run, tmp_path: Path) -> None:
    ended = run("doctor", env=environment(PATH=str(tmp_path), CC="nothing", RUSTC="nothing"))
    assert (ended.returncode, ended.stderr) == (0, "")
    found = marks(ended.stdout)
    assert found["ABC"][0] == "!" and found["ABC"][1].startswith("not there (no ABC was found on PATH); the embedded")
    assert "berkeley-abc" in found["ABC"][2]
    assert re.search(r"in place of (\w+ and )*ABC", ended.stdout.splitlines()[-1])
    for name in ("C compiler", "rustc", "cargo"):
        assert found[name][0] == "-" and "install" in found[name][2]


def test_diagrams_in_python_are_called_slow(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(doctor, "find_spec", lambda name: None)
    assert doctor.run(argparse.Namespace()) == 0
    mark, text, todo = marks(capsys.readouterr().out)["CUDD"]
    assert mark == "!" and "many times slower" in text and "wheel" in todo


def test_a_package_that_is_missing_is_told(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def none(name: str) -> str:
        raise PackageNotFoundError(name)

    monkeypatch.setattr(doctor, "version", none)
    doctor.run(argparse.Namespace())
    found = marks(capsys.readouterr().out)
    assert [name for name, (mark, _, _) in found.items() if mark != "+"][:3] == ["CUDD", "Z3", "python-sat"]
    assert found["Z3"][1] == "not there (z3-solver is not installed); exover was not installed whole"


def test_what_is_no_abc_is_not_taken_for_it(run: Run, tmp_path: Path) -> None:
    (tmp_path / "abc").write_text(f"#!{sys.executable}\nprint('ABC 9.99')\n")
    (tmp_path / "abc").chmod(0o755)
    ended = run("doctor", env=environment(PATH=str(tmp_path)))
    mark, text, _ = marks(ended.stdout)["ABC"]
    assert mark == "!" and "does not answer as ABC does" in text
