"""A text as its tokens, each with what the parser takes it for and with the comments before it."""

import re
from collections.abc import Iterator

from exover.dataclass import dataclass
from exover.syntax.grammar import Start, grammar
from exover.syntax.lex import tokens
from exover.syntax.machine import ParserState

_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)


@dataclass(frozen=True, slots=True)
class Comment:
    """A comment as it is written, without blanks at its end; how many line ends stand before it, 2 at most."""

    text: str
    newlines: int

    @property
    def ends_line(self) -> bool:
        """Whether nothing can stand behind it on its line."""
        return self.text.startswith("//")


@dataclass(frozen=True, slots=True)
class Lexeme:
    """A token: `kind` is its keyword where it is one, else as lex.py says; `newlines` stand just before it."""

    kind: str
    text: str
    comments: tuple[Comment, ...]
    newlines: int


class UnreadableText(Exception):
    """A text that should have been parsed is none of the language."""


def lexemes(text: str, start: Start) -> Iterator[Lexeme]:
    """Yield the tokens of a text without mistakes, `<end>` last; raise `UnreadableText` if it has some."""
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
    """Return the comments in what stands between two tokens, and the line ends behind the last of them."""
    found: list[Comment] = []
    end = 0
    for match in _COMMENT.finditer(blank):
        lines = (line.rstrip() for line in match[0].split("\n"))
        found.append(Comment("\n".join(lines), _newlines(blank[end : match.start()])))
        end = match.end()
    return tuple(found), _newlines(blank[end:])


def _newlines(blank: str) -> int:
    return min(blank.count("\n"), 2)
