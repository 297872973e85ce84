"""Answers of model checkers to the questions of a circuit."""

from collections.abc import Callable

from exover.dataclass import dataclass

Clause = tuple[int, ...]
"""A disjunction of literals of latches (`2 * node + sign`)."""
Inputs = tuple[frozenset[int], ...]
"""A run from the start: by step the nodes of the inputs that are true; the others are false."""


@dataclass(frozen=True, slots=True)
class Unreachable:
    """No run makes the bad literal true.

    `invariant`: clauses that form an inductive invariant: the start satisfies them, every step from a state of all of
    them leads to such a state; and they exclude the bad literal.
    """

    invariant: tuple[Clause, ...]


@dataclass(frozen=True, slots=True)
class Reachable:
    """This run makes the bad literal true in its last step."""

    inputs: Inputs


@dataclass(frozen=True, slots=True)
class Open:
    """The question is left open, for this reason."""

    reason: str


@dataclass(frozen=True, slots=True)
class Inductive:
    """No run makes the bad literal true: induction proves it of this and other bad literals together."""


Answer = Unreachable | Reachable | Open
Settled = Answer | Inductive
SayAnswer = Callable[[int, Answer], None]
"""Takes the index of a bad literal, and the answer."""
SaySettled = Callable[[int, Settled], None]
"""The same; the answer may be `Inductive`, too."""
StopRequested = Callable[[], bool]
"""Returns whether no more answers are wanted; it is polled."""


def never() -> bool:
    """Return False: all answers are wanted."""
    return False
