"""The differences between two versions of a spec as a comment of a merge request (docs/diff.md)."""

from collections.abc import Iterator
from html import escape

from exover.model.difference import Compared
from exover.model.wording import visible
from exover.report.difference import (
    change_text,
    in_both,
    last_line,
    property_title,
    run_lines,
    title,
    unknown_by_reason,
)


def render(compared: Compared) -> str:
    """Return the differences as a comment of a merge request: a table, and each run folded away."""
    return "".join(f"{line}\n" for line in _lines(compared))


def _lines(compared: Compared) -> Iterator[str]:
    old, new = (_code(file) for file in compared.files)
    yield f"### {old} → {new}"
    yield ""
    yield f"**{_plain(last_line(compared))}**"
    yield from (line for note in compared.notes for line in ("", f"> {_plain(note)}"))
    for each in compared.differences:
        yield ""
        yield f"<details><summary>{_html(title(each))}</summary>"
        yield ""
        yield from ("```text", *(_fenced(line) for line in run_lines(compared, each)), "```")
        yield ""
        yield "</details>"
    rest = [property_title(each) for each in in_both(compared)]
    rest += [
        f"unknown, {reason}: {'; '.join(map(change_text, unknown))}"
        for reason, unknown in unknown_by_reason(compared).items()
    ]
    if rest:
        yield ""
    yield from (f"- {_plain(line)}" for line in rest)


def _html(text: str) -> str:
    """Return a line with all HTML in it escaped, for where Markdown is not read."""
    return escape(visible(text), quote=False)


def _plain(text: str) -> str:
    """Return a line with all Markdown and HTML in it escaped."""
    return "".join(f"\\{c}" if c in "\\`*_~[]|#@$" else c for c in _html(text))


def _code(text: str) -> str:
    return f"`{visible(text).replace('`', chr(0xFFFD))}`"


def _fenced(line: str) -> str:
    return visible(line).replace("```", "\ufffd" * 3)
