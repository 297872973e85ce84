"""What must be believed stays small: the checker imports nothing else of exover, and does not grow."""

import ast
import io
import tokenize
from collections.abc import Iterator
from pathlib import Path

import exover.certificate

FOLDER = Path(exover.certificate.__file__).parent
MOST = 845
"""Lines of code, without blank ones, comments and docstrings."""
LAYOUT = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER)


def code_lines(text: str) -> set[int]:
    """Return the numbers of the lines of code."""
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    lines = {line for t in tokens if t.type not in LAYOUT for line in range(t.start[0], t.end[0] + 1)}
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            lines -= set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return lines


def imported(text: str) -> Iterator[str]:
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (each.name for each in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module or ""


def test_the_checker_is_small() -> None:
    text = '"""A docstring."""\n\nX = [\n    1,  # one\n]\n# a comment\n"""More."""\n'
    assert code_lines(text) == {3, 4, 5}
    assert sum(len(code_lines(path.read_text())) for path in FOLDER.glob("*.py")) <= MOST


def test_the_checker_imports_nothing_else_of_exover() -> None:
    names = {name for path in FOLDER.glob("*.py") for name in imported(path.read_text())}
    assert {name for name in names if name.startswith("exover") and not name.startswith("exover.certificate")} == set()
    assert "z3" in names
