"""docs/architecture.md draws the house as it is: every module in the block of its package, and nothing that is gone."""

import re
from argparse import _SubParsersAction
from pathlib import Path

import pytest

from exover.cli.arguments import parser

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
DRAWING = PAGE[PAGE.index("\nexover/\n") : PAGE.index("\nspecs/  properties/")]
BLOCKS = dict(re.findall(r"^  (\w+)/ (.*?)(?=^  \S|\Z)", DRAWING, re.MULTILINE | re.DOTALL))
SOURCES = {".c", ".h", ".rs"}


def modules(package: str) -> set[str]:
    return {path.name for path in (ROOT / "exover" / package).rglob("*.py")} - {"__init__.py"}


def named(text: str, suffix: str = "py") -> set[str]:
    return set(re.findall(rf"\w+\.{suffix}\b", text))


def listed_in_code(package: str) -> set[str]:
    """Return the modules of single checks and verbs, which the page does not name one by one."""
    if package == "checks":
        return modules("checks/questions")
    (verbs,) = [action for action in parser()._actions if isinstance(action, _SubParsersAction)]
    return {f"{verb}.py" for verb in verbs.choices} | {"imports.py"} if package == "cli" else set()


def test_every_package_is_drawn() -> None:
    folders = {path.parent.relative_to(ROOT / "exover").parts[0] for path in (ROOT / "exover").glob("*/**/*.py")}
    assert folders - {"runtime"} <= set(BLOCKS) and set(BLOCKS) - folders <= {"runtime"}


@pytest.mark.parametrize("package", sorted(BLOCKS))
def test_a_package_is_drawn_as_it_is(package: str) -> None:
    drawn, there = named(BLOCKS[package]), modules(package)
    assert not drawn - there, "drawn, and not there"
    assert not there - drawn - listed_in_code(package), "there, and not drawn"


def test_the_sources_in_c_and_rust_are_drawn() -> None:
    files = [path for path in (ROOT / "exover").rglob("*") if path.suffix in SOURCES and path.parent.name != "rust"]
    there = {(path.relative_to(ROOT / "exover").parts[0], path.name) for path in files}
    drawn = {(package, name) for package in BLOCKS for name in named(BLOCKS[package], r"(?:c|h|rs)")}
    assert there <= drawn and drawn - there <= {("audit", "audit.c")}


def test_the_modules_beside_the_packages_are_drawn() -> None:
    outside = re.sub(r"^  \w+/ .*?(?=^  \S|\Z)", "", DRAWING, flags=re.MULTILINE | re.DOTALL)
    there = {path.name for path in (ROOT / "exover").glob("*.py")}
    assert named(outside) == there - {"__init__.py"}
