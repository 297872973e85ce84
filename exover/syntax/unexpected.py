"""A token that the grammar does not allow at its place, with what is known of that place."""

from typing import Literal, TypeAlias

from exover.dataclass import dataclass
from exover.syntax.lex import NAME, Token

Closed: TypeAlias = Literal["", "condition", "term"]
"""What the bracket closes that stands before a token: a predicate or a condition, or a term; "" if it is not known."""


@dataclass(frozen=True, slots=True)
class Unexpected:
    """A token that is none of the `expected` kinds, in the statement that `keyword` begins, and its neighbours.

    `opened`: the tokens of the statement so far, as far as they are kept, "" for what is read; the first is `keyword`.
    `closed`: what a bracket before the token has closed.
    """

    token: Token
    before: Token | None
    expected: frozenset[str]
    keyword: str
    following: Token | None = None
    opened: tuple[str, ...] = ()
    closed: Closed = ""

    @property
    def text(self) -> str:
        """The text of the token."""
        return self.token.text

    @property
    def previous(self) -> str:
        """The text of the token before; empty if there is none."""
        return self.before.text if self.before else ""

    @property
    def ahead(self) -> str:
        """The text of the token that follows; empty if there is none."""
        return self.following.text if self.following else ""

    @property
    def named(self) -> bool:
        """Whether a name stands before the token."""
        return self.before is not None and self.before.kind == NAME
