"""Requirements of docs/runtime.md traced to tests and back: requirements.toml as the tables of docs/evidence.md.

`python -m tests.runtime.evidence` writes the tables anew.
"""

import ast
import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).parent
DOCS = HERE.parents[1] / "docs"
PAGE, REQUIRED = DOCS / "evidence.md", DOCS / "runtime.md"
BEGIN, END = "<!-- generated: python -m tests.runtime.evidence -->\n", "<!-- end of what is generated -->\n"


@dataclass(frozen=True, slots=True)
class Requirement:
    """A sentence of the page by its number, with its section and the tests that show it."""

    number: str
    text: str
    section: str
    tests: tuple[str, ...]


def sections() -> dict[str, str]:
    """Return the text of each section of the page, blanks made one; what stands before the first is `The C runtime`."""
    parts = re.split(r"^## (.+)$", REQUIRED.read_text(encoding="utf-8"), flags=re.MULTILINE)
    named = [("The C runtime", parts[0]), *zip(parts[1::2], parts[2::2], strict=True)]
    return {title: " ".join(text.split()) for title, text in named}


def requirements() -> list[Requirement]:
    """Return the requirements in order; the section of one that stands nowhere is empty."""
    known = sections()
    found = []
    for number, row in _read().items():
        if number != "toolkit":
            section = next((title for title, text in known.items() if row["text"] in text), "")
            found.append(Requirement(number, row["text"], section, tuple(row["tests"])))
    return found


def toolkit() -> dict[str, str]:
    """Return the tests that show no requirement, each with what it is about."""
    return {test: about for about, tests in _read()["toolkit"].items() for test in tests}


def _read() -> dict[str, dict[str, list[str]]]:
    return tomllib.loads((HERE / "requirements.toml").read_text(encoding="utf-8"))


def existing() -> list[str]:
    """Return all tests of tests/runtime as `file::function`."""
    found = []
    for file in sorted(HERE.glob("test_*.py")):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        functions = [node.name for node in tree.body if isinstance(node, ast.FunctionDef)]
        found += [f"{file.name}::{name}" for name in functions if name.startswith("test_")]
    return found


def tables() -> str:
    """Return what is generated: from requirements to tests, and from tests to requirements."""
    return "".join(f"{line}\n" for line in [*_forth(), "", *_back()])


def _forth() -> Iterator[str]:
    yield "| | what is required | section | shown by |"
    yield "|---|---|---|---|"
    for each in requirements():
        shown = "<br>".join(f"`{test}`" for test in each.tests)
        text = re.sub(r"\[(.+?)\]\(.+?\)", r"\1", each.text).replace("|", "\\|").replace("**", "")
        yield f"| {each.number} | {text} | {each.section} | {shown} |"


def _back() -> Iterator[str]:
    other = toolkit()
    yield "| test | shows |"
    yield "|---|---|"
    for test in existing():
        shows = [each.number for each in requirements() if test in each.tests]
        yield f"| `{test}` | {', '.join(shows) or other.get(test, '')} |"


def written() -> str:
    """Return the page with the tables as they are now."""
    page = PAGE.read_text(encoding="utf-8")
    before, _, rest = page.partition(BEGIN)
    return f"{before}{BEGIN}\n{tables()}\n{END}{rest.partition(END)[2]}"


if __name__ == "__main__":
    PAGE.write_text(written(), encoding="utf-8")
