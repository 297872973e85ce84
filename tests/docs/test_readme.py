"""The examples of the README and of the tutorial, run as they stand.

Blocks are read in order. A fenced block whose info string names a file (`exo rover.exo`) is written there. A `sh`
block is run and must end with status 0, or with N if it says `exit=N`; the lines of a `text` block right after it are
lines of its output, in that order. Is a tool missing that it says it `needs=`, it is left out, and the test is skipped
when all else has run. The `python` blocks without a name are one program. An `exo` block without a name is an excerpt:
its lines stand in some named block of the page.
"""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import chdir, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BIN = Path(sys.executable).parent
FENCE = re.compile(r"^```(\w+)([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True, slots=True)
class Block:
    """A fenced block: its language, the rest of its info string, its text."""

    language: str
    info: str
    text: str


def blocks(page: Path) -> list[Block]:
    """Return the fenced blocks of a page in order."""
    return [Block(m[1], m[2].strip(), m[3]) for m in FENCE.finditer(page.read_text(encoding="utf-8"))]


def said(block: Block) -> dict[str, str]:
    """Return what the info string of a `sh` block says: `exit=N`, `needs=TOOL,TOOL`."""
    words = dict(word.split("=") for word in block.info.split())
    assert words.keys() <= {"exit", "needs"}, f"not understood: {block.info}"
    return words


def missing(block: Block) -> list[str]:
    """Return the tools that a `sh` block needs and that are not there."""
    return [tool for tool in said(block).get("needs", "").split(",") if tool and shutil.which(tool) is None]


def run(block: Block, folder: Path) -> str:
    """Return what the commands print; they end with the status that the block says."""
    status = said(block).get("exit", "0")
    environment = {**os.environ, "PATH": f"{BIN}{os.pathsep}{os.environ['PATH']}"}
    commands = block.text.replace(".venv/bin/", f"{BIN}/")
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", commands],
        cwd=folder, env=environment, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == int(status), f"{commands}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def execute(block: Block, names: dict[str, object], folder: Path) -> str:
    """Return what a Python block prints that knows the names of those before it."""
    printed = StringIO()
    with chdir(folder), redirect_stdout(printed):
        exec(compile(block.text, "<page>", "exec"), names)
    return printed.getvalue()


def play(page: Path, folder: Path) -> Iterator[Block]:
    """Write the files and run the commands of a page in order, and yield each block after it was handled."""
    output: str | None = None
    left_out: list[str] = []
    names: dict[str, object] = {}
    for block in blocks(page):
        if block.language == "sh":
            gone = missing(block)
            left_out += gone
            output = None if gone else run(block, folder)
        elif block.language == "python" and not block.info:
            output = execute(block, names, folder)
        elif block.language == "text" and output is not None:
            printed = iter(output.splitlines())
            for line in filter(None, block.text.splitlines()):
                assert line in printed, f"not printed, or not in this order: {line}\n{output}"
        else:
            output = None
            if block.info:
                (folder / block.info).parent.mkdir(parents=True, exist_ok=True)
                (folder / block.info).write_text(block.text, encoding="utf-8")
        yield block
    if left_out:
        pytest.skip(f"all of {page.name} ran but for what needs {', '.join(left_out)}")


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """Return a folder with what the README's commands read."""
    shutil.copytree(ROOT / "specs", tmp_path / "specs")
    return tmp_path


def test_the_readme_runs_and_its_spec_holds(checkout: Path) -> None:
    played = list(play(ROOT / "README.md", checkout))
    specs = [block.info for block in played if block.language == "exo"]
    assert sum(block.language == "sh" for block in played) >= 4
    assert specs
    for spec in specs:
        run(Block("sh", "", f"exover check {spec}"), checkout)


def test_the_tutorial_runs(tmp_path: Path) -> None:
    played = list(play(ROOT / "docs" / "tutorial.md", tmp_path))
    assert sum(block.language == "sh" for block in played) >= 4


def test_the_tutorial_writes_the_rover() -> None:
    rover, *_ = [block.text for block in blocks(ROOT / "docs" / "tutorial.md") if block.info == "rover.exo"]
    assert (ROOT / "specs" / "rover.exo").read_text(encoding="utf-8").endswith(rover)
    assert rover == (ROOT / "tests" / "vectors" / "rover.exo").read_text(encoding="utf-8")


def test_excerpts_of_the_tutorial_stand_in_its_specs() -> None:
    page = [block for block in blocks(ROOT / "docs" / "tutorial.md") if block.language == "exo"]
    written = {line.strip() for block in page if block.info for line in block.text.splitlines()}
    excerpts = [line.strip() for block in page if not block.info for line in block.text.splitlines()]
    assert excerpts
    assert [line for line in excerpts if line not in written] == []


def test_links_between_pages_lead_somewhere() -> None:
    pages = [ROOT / "README.md", ROOT / "properties" / "README.md"]
    pages += [*(ROOT / "docs").glob("*.md"), *(ROOT / "specs").rglob("*.md")]
    texts = {page: re.sub(r"`[^`]*`", "", page.read_text(encoding="utf-8")) for page in pages}
    links = [(page, link) for page, text in texts.items() for link in re.findall(r"\]\((?!https?:)([^)#]+)\)", text)]
    assert len(links) > 10
    assert [(str(page), link) for page, link in links if not (page.parent / link).exists()] == []
