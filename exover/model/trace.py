"""Traces: concrete runs step by step, and their replay on an engine."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator

from exover.dataclass import dataclass
from exover.model.event import Action, Event
from exover.model.semantics import Reference
from exover.model.state import State

Answers = tuple[Action, ...]
Replay = Callable[[tuple[Event, ...]], tuple[Answers, ...]]
"""Runs the events from the initial state on an engine and returns what it answered to each."""


@dataclass(frozen=True, slots=True)
class Moment:
    """An event and the actions that answered it."""

    event: Event
    actions: Answers


@dataclass(frozen=True, slots=True)
class Trace:
    """A run from the initial state.

    With `loop_start` it is a lasso: the state after the last moment equals that before `moments[loop_start]`, and the
    moments from there to the last, at least one, are repeated for ever.
    """

    moments: tuple[Moment, ...]
    loop_start: int | None = None

    @property
    def events(self) -> tuple[Event, ...]:
        """The events of the run."""
        return tuple(moment.event for moment in self.moments)


def run(reference: Reference, events: tuple[Event, ...], loop_start: int | None = None) -> Trace:
    """Return the trace of these events on the reference interpreter.

    Raises `ValueError` if there is a `loop_start` and the last state is not equal to the one there.
    """
    states, moments = [reference.start()], []
    for event in events:
        state, actions = reference.step(states[-1], event)
        states.append(state)
        moments.append(Moment(event, actions))
    if loop_start is not None and (loop_start >= len(moments) or states[loop_start].key() != states[-1].key()):
        raise ValueError(f"the run does not return to where it was after {loop_start} steps")
    return Trace(tuple(moments), loop_start)


def end_of(reference: Reference, events: Iterable[Event]) -> State:
    """Return the state to which a run leads on the reference interpreter."""
    return deque(visited(reference, events), maxlen=1).pop()


def visited(reference: Reference, events: Iterable[Event]) -> Iterator[State]:
    """Yield the states of a run on the reference interpreter: the initial one, and the one after each event."""
    state = reference.start()
    yield state
    for event in events:
        state, _ = reference.step(state, event)
        yield state


def same(trace: Trace, replay: Replay) -> bool:
    """Return whether an engine answers the events of the trace with exactly its actions."""
    return replay(trace.events) == tuple(moment.actions for moment in trace.moments)


class Disagreement(Exception):
    """Two engines answer one run or one question differently: a fault of this program, never of a spec."""


def confirm(trace: Trace, engine: str, replay: Replay) -> None:
    """Raise `Disagreement` unless an engine answers the events of the trace with exactly its actions."""
    if not same(trace, replay):
        raise Disagreement(f"{engine} answers a run of {len(trace.moments)} steps otherwise than the reference")
