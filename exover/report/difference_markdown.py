"""The differences between two versions of a spec as a comment of a merge request (docs/diff.md)."""

from collections.abc import Iterator

from exover.escaping import plain_html, plain_markdown, visible
from exover.model.difference import Compared
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
    yield f"**{plain_markdown(last_line(compared))}**"
    yield from (line for note in compared.notes for line in ("", f"> {plain_markdown(note)}"))
    for each in compared.differences:
        yield ""
        yield f"<details><summary>{plain_html(title(each))}</summary>"
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
    yield from (f"- {plain_markdown(line)}" for line in rest)


def _code(text: str) -> str:
    return f"`{visible(text).replace('`', chr(0xFFFD))}`"


def _fenced(line: str) -> str:
    return visible(line).replace("```", "\ufffd" * 3)
