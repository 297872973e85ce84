"""docs/architecture.md draws the house as it is: every module in the block of its package, and nothing that is gone."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
DRAWING = PAGE[PAGE.index("\nexover/\n") : PAGE.index("\nspecs/  properties/")]
BLOCKS = dict(re.findall(r"^  (\w+)/ (.*?)(?=^  \S|\Z)", DRAWING, re.MULTILINE | re.DOTALL))
LISTED_IN_CODE = {"checks", "cli"}
"""Packages with one module for each check or verb, which the page does not name one by one."""


def modules(package: str) -> set[str]:
    return {path.name for path in (ROOT / "exover" / package).rglob("*.py")} - {"__init__.py"}


def named(text: str) -> set[str]:
    return set(re.findall(r"\w+\.py\b", text))


def test_every_package_is_drawn() -> None:
    folders = {path.parent.relative_to(ROOT / "exover").parts[0] for path in (ROOT / "exover").glob("*/**/*.py")}
    assert folders - {"runtime"} <= set(BLOCKS) and set(BLOCKS) - folders <= {"runtime"}


@pytest.mark.parametrize("package", sorted(BLOCKS))
def test_a_package_is_drawn_as_it_is(package: str) -> None:
    drawn, there = named(BLOCKS[package]), modules(package)
    assert not drawn - there, "drawn, and not there"
    if package not in LISTED_IN_CODE:
        assert not there - drawn, "there, and not drawn"


def test_the_modules_beside_the_packages_are_drawn() -> None:
    outside = re.sub(r"^  \w+/ .*?(?=^  \S|\Z)", "", DRAWING, flags=re.MULTILINE | re.DOTALL)
    there = {path.name for path in (ROOT / "exover").glob("*.py")}
    assert named(outside) == there - {"__init__.py", "__main__.py"}
