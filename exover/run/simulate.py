"""Answers a stream of event lines by any engine (docs/language.md section 7)."""

from collections.abc import Generator, Iterable, Iterator
from typing import BinaryIO, Protocol

from exover.model.event import Action, Event, Invalid
from exover.model.model import Model
from exover.model.semantics import Reference
from exover.model.wire import answer_line
from exover.model.wire_reading import TOO_LONG, is_blank, read_event


class Engine(Protocol):
    """A checker that remembers its state from one event to the next."""

    def step(self, event: Event) -> tuple[Action, ...]:
        """Take a well-formed event and return the actions that answer it, in order."""
        ...


class ReferenceEngine:
    """The reference interpreter as an engine; it starts in the initial state."""

    def __init__(self, model: Model) -> None:
        self._reference = Reference(model)
        self._state = self._reference.start()

    def step(self, event: Event) -> tuple[Action, ...]:
        """Take a well-formed event and return the actions that answer it."""
        self._state, actions = self._reference.step(self._state, event)
        return actions


def answers(
    model: Model, engine: Engine, lines: Iterable[str | bytes]
) -> Iterator[tuple[Event | Invalid, tuple[Action, ...]]]:
    """Yield the event of each line that is not blank, and the actions that answer it, before the next line is read."""
    for line in lines:
        if not is_blank(line):
            event = read_event(model, line)
            yield event, (event,) if isinstance(event, Invalid) else engine.step(event)


def simulate(model: Model, engine: Engine, lines: Iterable[str | bytes]) -> Generator[str, None, int]:
    """Yield one answer line for each line that is not blank, before the next line is read; steps count from 1.

    Returns how many of the lines are events, valid or not; a line that is answered `bad-event` is none.
    """
    events = 0
    for step, (event, actions) in enumerate(answers(model, engine, lines), 1):
        events += not (isinstance(event, Invalid) and event.is_unread)
        yield answer_line(model, step, actions)
    return events


def lines_of(stream: BinaryIO) -> Iterator[bytes]:
    """Yield the lines of a stream as they come; of one too long to be an event, only the first `TOO_LONG` bytes."""
    while line := stream.readline(TOO_LONG):
        yield line
        while len(line) == TOO_LONG and not line.endswith(b"\n"):
            line = stream.readline(TOO_LONG)
