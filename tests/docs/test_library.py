"""The examples of docs/library.md, run as they stand; its recipe for pytest has the types that it says."""

import subprocess
import sys
from pathlib import Path

from tests.docs.pages import ROOT, blocks, play

PAGE = ROOT / "docs" / "library.md"


def test_the_examples_run(tmp_path: Path) -> None:
    played = list(play(PAGE, tmp_path))
    assert sum(block.language == "python" for block in played) > 8


def test_the_lift_is_that_of_the_readme() -> None:
    (here,), (there,) = ([b.text for b in blocks(p) if b.info == "lift.exo"] for p in (PAGE, ROOT / "README.md"))
    assert here == there


def test_the_recipe_is_typed(tmp_path: Path) -> None:
    """As `make lint` has it, whose cache is taken: to judge all of exover anew takes twenty seconds.

    Of a text that it knows mypy tells the folder where it met it first.
    """
    (recipe,) = [block.text for block in blocks(PAGE) if block.info == "test_lift.py"]
    file = tmp_path / "test_lift.py"
    file.write_text(f"{recipe}\n\nexover.load(3)\n")
    command = [sys.executable, "-m", "mypy", "--strict", str(file)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=300)
    told = [line.partition(":") for line in done.stdout.splitlines()]
    complaints = [what for where, _, what in told if Path(where).name == file.name and ": error: " in what]
    assert len(complaints) == 1 and 'Argument 1 to "load"' in complaints[0], done.stdout
