"""`exover docs`, and that the pages travel with the wheel."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.support.command import COMMAND, environment

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / "docs").glob("*.md"))


@pytest.mark.parametrize("name", ["checks", "checks.md"])
def test_a_page_is_printed(run, name: str) -> None:
    done = run("docs", name)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == (ROOT / "docs" / "checks.md").read_text(encoding="utf-8")


def test_without_a_name_the_list_of_pages_is_printed_and_names_all(run) -> None:
    printed = run("docs").stdout
    assert printed == (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    assert [page.name for page in PAGES if f"({page.name})" not in printed] == ["index.md"]


@pytest.mark.parametrize(
    ("page", "reason"),
    [
        ("cheks", "there is no page `cheks`; did you mean `checks`?"),
        ("../README", "there is no page `../README`; there are architecture, audit, binding, "),
    ],
)
def test_a_page_that_is_none(run, page: str, reason: str) -> None:
    done = run("docs", page)
    assert (done.returncode, done.stdout) == (2, "")
    assert reason in done.stderr


def test_a_page_is_opened(run, tmp_path: Path) -> None:
    browser = tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\necho "$1" > {tmp_path}/opened\n')
    browser.chmod(0o755)
    done = run.apart("docs", "checks", "--open", env=environment(BROWSER=f"{browser} %s"))
    assert (done.returncode, done.stdout) == (0, "")
    assert (tmp_path / "opened").read_text().startswith("file:///")
    assert (tmp_path / "opened").read_text().endswith("/docs/checks.md\n")
    done = run.apart(
        "docs", "checks", "--open", env=environment(BROWSER="no-such-program", PATH="/nowhere", DISPLAY="")
    )
    assert done.returncode == 2
    assert "`exover docs checks` prints it" in done.stderr


def test_every_file_and_page_is_in_the_wheel(tmp_path: Path) -> None:
    """It is built from a copy, and unpacked where nothing of the repository is."""
    pytest.importorskip("setuptools")
    source = tmp_path / "source"
    source.mkdir()
    for name in ("exover", "docs", "pyproject.toml", "README.md", "LICENSE"):
        subprocess.run(["cp", "-a", str(ROOT / name), str(source / name)], check=True)
    program = f"from setuptools import build_meta; build_meta.build_wheel({str(tmp_path)!r})"
    subprocess.run([sys.executable, "-W", "ignore", "-c", program], cwd=source, capture_output=True, check=True)
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "installed")
    package = source / "exover"
    files = {path.relative_to(source) for path in package.rglob("*") if path.is_file() and path.suffix != ".pyc"}
    assert Path("exover/engines/aig/circuit/simulate.c") in files
    assert [path for path in sorted(files) if not (tmp_path / "installed" / path).is_file()] == []
    for page in PAGES:
        assert (tmp_path / "installed" / "exover" / "docs" / page.name).read_bytes() == page.read_bytes()
    variables = environment() | {"PYTHONPATH": str(tmp_path / "installed")}
    done = subprocess.run(
        [*COMMAND, "docs", "ci"], cwd=os.sep, env=variables, capture_output=True, text=True, check=True
    )
    assert done.stdout == (ROOT / "docs" / "ci.md").read_text(encoding="utf-8")


def test_the_site_lists_every_page() -> None:
    listed = {line.strip(" -") for line in (ROOT / "mkdocs.yml").read_text().splitlines() if line.endswith(".md")}
    assert listed == {page.name for page in PAGES}
