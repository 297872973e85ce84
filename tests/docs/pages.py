"""The pages of the documentation as programs: their blocks are written, run and compared as they stand.

Blocks are read in order. A fenced block whose info string names a file (`exo rover.exo`) is written there. A `sh`
block is run and must end with status 0, or with N if it says `exit=N`. Is a tool missing that it says it `needs=`, it
is left out, and the test is skipped when all else has run. The `python` blocks without a name are one program. A `text`
block is all that the block before it prints; `…` stands for any text in a line, and alone for any lines. An `exo`
block without a name is an excerpt: its lines stand in some named block of the page.

`python -m tests.docs.pages PAGE…` writes what is printed now into the `text` blocks in which nothing is left out.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import chdir, redirect_stdout
from dataclasses import dataclass
from difflib import unified_diff
from io import StringIO
from pathlib import Path

import pytest

from tests.support.warm import command

ROOT = Path(__file__).resolve().parents[2]
PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
BIN = Path(sys.executable).parent
FENCE = re.compile(r"^```(\w+)([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
GAP = "…"


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


def places() -> str:
    """Return where programs are looked for: `exover` begins at once, and all that is installed beside it is there."""
    return os.pathsep.join([str(command().parent), str(BIN), os.environ["PATH"]])


def run(block: Block, folder: Path) -> str:
    """Return what the commands print; they end with the status that the block says."""
    kept = {name: value for name, value in os.environ.items() if name != "EXOVER_NO_CACHE"}  # as readers have it
    environment = {**kept, "PATH": places()}
    commands = block.text.replace(".venv/bin/exover", "exover").replace(".venv/bin/", f"{BIN}/")
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", commands],
        cwd=folder, env=environment, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == int(said(block).get("exit", "0")), f"{commands}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def execute(block: Block, names: dict[str, object], folder: Path) -> str:
    """Return what a Python block prints that knows the names of those before it."""
    printed = StringIO()
    with chdir(folder), redirect_stdout(printed):
        exec(compile(block.text, "<page>", "exec"), names)
    return printed.getvalue()


def play(page: Path, folder: Path) -> Iterator[Block]:
    """Write the files and run the commands of a page in order, and yield each block after it was handled."""
    for block, output in handled(page, folder):
        if block.language == "text" and output is not None:
            assert agrees(block.text, output), difference(block.text, output)
        yield block


def handled(page: Path, folder: Path) -> Iterator[tuple[Block, str | None]]:
    """Yield each block after it was handled, and what the one before it has printed, if it was run."""
    output: str | None = None
    left_out: list[str] = []
    names: dict[str, object] = {}
    for block in blocks(page):
        before = output
        output = None
        if block.language == "sh":
            left_out += missing(block)
            output = None if missing(block) else run(block, folder)
        elif block.language == "python" and not block.info:
            output = execute(block, names, folder)
        elif block.info:
            (folder / block.info).parent.mkdir(parents=True, exist_ok=True)
            (folder / block.info).write_text(block.text, encoding="utf-8")
        yield block, before
    if left_out:
        pytest.skip(f"all of {page.name} ran but for what needs {', '.join(left_out)}")


def agrees(text: str, output: str) -> bool:
    """Return whether an output is what a `text` block says, gaps and blanks at the end of lines apart."""
    lines = [_pattern(line.rstrip()) for line in text.splitlines()]
    printed = "".join(f"{line.rstrip()}\n" for line in output.splitlines())
    return re.fullmatch("".join(lines), printed) is not None


def _pattern(line: str) -> str:
    return r"(?:.*\n)*?" if line == GAP else re.escape(line).replace(re.escape(GAP), ".*") + r"\n"


def difference(text: str, output: str) -> str:
    """Return how an output differs from what a block says."""
    return "\n".join(unified_diff(text.splitlines(), output.splitlines(), "the page", "what is printed", lineterm=""))


def fill(folder: Path) -> None:
    """Put into a folder what the commands of the pages read: what stands in a checkout."""
    for name in ("specs", "properties", "examples"):
        shutil.copytree(ROOT / name, folder / name)


def _rewrite(page: Path, folder: Path) -> None:
    """Write what is printed now into the blocks of a page that tell all that is printed."""
    content = page.read_text(encoding="utf-8")
    for block, output in handled(page, folder):
        if block.language == "text" and output is not None and GAP not in block.text:
            told = "".join(f"{line.rstrip()}\n" for line in output.splitlines())
            content = content.replace(f"```text\n{block.text}```", f"```text\n{told}```", 1)
    page.write_text(content, encoding="utf-8")


if __name__ == "__main__":
    for name in sys.argv[1:]:
        with tempfile.TemporaryDirectory() as scratch:
            fill(Path(scratch))
            _rewrite(Path(name), Path(scratch))
