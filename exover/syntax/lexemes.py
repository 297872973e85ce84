"""The tokens of a text, each with the kind that the parser gives it and with the comments before it."""

import re
from collections.abc import Iterator

from exover.dataclass import dataclass
from exover.syntax.grammar import Start, grammar
from exover.syntax.lex import tokens
from exover.syntax.machine import ParserState

_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)


@dataclass(frozen=True, slots=True)
class Comment:
    """A comment, without blanks at the ends of its lines; `newlines`: the line ends before it, counted up to 2."""

    text: str
    newlines: int

    @property
    def ends_line(self) -> bool:
        """Whether it extends to the end of its line."""
        return self.text.startswith("//")


@dataclass(frozen=True, slots=True)
class Lexeme:
    """A token: `kind` is the keyword if the parser takes it for one, else that of lex.py.

    `comments` come before it, and then `newlines` line ends, counted up to 2.
    """

    kind: str
    text: str
    comments: tuple[Comment, ...]
    newlines: int


class UnreadableText(Exception):
    """A text that must be without mistakes has a syntax error."""


def lexemes(text: str, start: Start) -> Iterator[Lexeme]:
    """Yield the tokens of a text without mistakes, `<end>` last; raises `UnreadableText` at a syntax error."""
    machine = ParserState(grammar(), start)
    machine.building = False
    end = 0
    for token in tokens(text, [], start == "properties"):
        comments, newlines = _trivia(text[end : token.start])
        yield Lexeme(machine.kind(token), token.text, comments, newlines)
        if not machine.feed(token):
            raise UnreadableText(f"`{token.text}` cannot stand at {token.start}")
        end = token.end


def _trivia(blank: str) -> tuple[tuple[Comment, ...], int]:
    """Return the comments between two tokens, and the number of line ends after the last comment."""
    found: list[Comment] = []
    end = 0
    for match in _COMMENT.finditer(blank):
        lines = (line.rstrip() for line in match[0].split("\n"))
        found.append(Comment("\n".join(lines), _newlines(blank[end : match.start()])))
        end = match.end()
    return tuple(found), _newlines(blank[end:])


def _newlines(blank: str) -> int:
    return min(blank.count("\n"), 2)
