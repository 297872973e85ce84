"""The tests themselves: their rooms are those of the packages, and what several need stands in modules of its own."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

TESTS = Path(__file__).parent
ROOT = TESTS.parent / "exover"
SUBJECTS = {"agreement", "cases", "docs", "newcomers", "support"}
"""Rooms of tests that are about several packages."""
PARTS = ("body", "orelse", "finalbody", "handlers", "cases")
"""Of a statement: the statements in it, and what has such."""
ROOTED = re.compile(r"^ROOT = Path\(__file__\)(?:\.resolve\(\))?\.parents\[(\d)\]$", re.MULTILINE)
"""Where a module says how many folders up the repository is."""
IN_RUNTIME = {"run"}
"""Packages whose tests stand in tests/runtime: what they run is the evidence of docs/evidence.md, read from there."""


def imported(tree: ast.Module) -> Iterator[str]:
    """Yield the full names of what a module imports, wherever it does: in blocks of statements, not in expressions."""
    blocks: list[ast.AST] = [tree]
    for node in blocks:
        match node:
            case ast.Import(names):
                yield from (name.name for name in names)
            case ast.ImportFrom(module=str(module), names=names):
                yield from (f"{module}.{name.name}" for name in names)
            case _:
                blocks += (each for part in PARTS for each in getattr(node, part, ()))


def is_test(name: str) -> bool:
    """Return whether a name leads into a module of tests."""
    package, *rest = name.split(".")
    return package == "tests" and any(part.startswith("test_") for part in rest)


def rooms(folder: Path) -> set[str]:
    """Return the names of the folders below one that have tests, at whatever depth."""
    return {path.name for path in folder.iterdir() if path.is_dir() and any(path.rglob("test_*.py"))}


def packages(folder: Path) -> set[str]:
    """Return the names of the packages below one."""
    return {path.parent.name for path in folder.glob("*/__init__.py")}


def test_rooms_mirror_packages() -> None:
    assert rooms(TESTS) == (packages(ROOT) - IN_RUNTIME) | {"runtime"} | SUBJECTS
    assert rooms(TESTS / "engines") == packages(ROOT / "engines")
    assert rooms(TESTS / "engines" / "aig") == packages(ROOT / "engines" / "aig")


def test_no_helper_is_imported_from_a_module_of_tests() -> None:
    """A module of tests can be moved, split and deleted without a look at the others."""
    trees = {path: ast.parse(path.read_text(encoding="utf-8")) for path in sorted(TESTS.rglob("*.py"))}
    names = [(str(path.relative_to(TESTS)), name) for path, tree in trees.items() for name in imported(tree)]
    assert any(name.startswith("tests.support.") for _, name in names)
    assert [(path, name) for path, name in names if is_test(name)] == []


def test_what_modules_call_root_is_the_repository() -> None:
    """What they look for there is not found elsewhere once they are moved."""
    texts = {path: path.read_text(encoding="utf-8") for path in sorted(TESTS.rglob("*.py"))}
    said = [(path, up) for path, text in texts.items() for up in ROOTED.findall(text)]
    assert len(said) > 10
    assert [str(path) for path, up in said if path.parents[int(up)] != TESTS.parent] == []
