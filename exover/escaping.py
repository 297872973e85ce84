"""Texts of others made harmless where they are shown: on a terminal, in HTML, in Markdown."""

from collections.abc import Iterable


def visible(line: str) -> str:
    """Return a line with U+FFFD for each unprintable character, so that it cannot control a terminal."""
    return "".join(character if character.isprintable() else "\ufffd" for character in line)


def visible_lines(lines: Iterable[str]) -> str:
    """Return the lines as a text, each `visible` and with its end."""
    return "".join(f"{visible(line)}\n" for line in lines)


def plain_html(line: str) -> str:
    """Return a line with all HTML in it escaped, as the text of an element of HTML or XML."""
    from html import escape  # imported late: it loads a table of all named characters

    return escape(visible(line), quote=False)


def plain_markdown(line: str) -> str:
    """Return a line with all Markdown and HTML in it escaped."""
    return "".join(f"\\{each}" if each in "\\`*_~[]|#@$" else each for each in plain_html(line))
