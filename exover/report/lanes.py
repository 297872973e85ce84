"""A story as lanes: what is drawn in which lane at which moment, without coordinates.

Moment 0 is the start, moment i the state after step i; a lane of a request has one row for each slot in use and one
for its waiting place, a lane of a poster, state, latch or level has one row of values.
"""

from collections.abc import Iterator
from typing import Literal, assert_never

from exover.dataclass import dataclass
from exover.model.event import (
    Abort,
    AbortWaiting,
    Action,
    Ask,
    Event,
    Invalid,
    Killed,
    Launched,
    Observe,
    Rejected,
    Report,
    Violated,
    Waits,
)
from exover.model.model import Model
from exover.model.state import State
from exover.model.wording import action_text, event_text, named_text, value_text
from exover.report.story import Story, place_text

LaneMarkKind = Literal["ask", "report", "observe", "abort", "launch", "wait", "reject", "kill", "violation", "invalid"]
CHECKER = "checker"
"""The lane for what belongs to no request; no request has this name, since names of requests have a dot."""
Marks = dict[tuple[bool, str], dict[int, tuple["LaneMark", ...]]]
"""The marks of a lane by step; lanes by whether they have values, and by name: a poster may have that of a request."""
MOST_ARGUMENTS = 24
"""The most characters of arguments that a mark shows; its tooltip shows all of them."""


@dataclass(frozen=True, slots=True)
class LaneMark:
    """An event or an action: a short `text` to be shown, and the `whole` text for a tooltip."""

    kind: LaneMarkKind
    text: str
    whole: str


@dataclass(frozen=True, slots=True)
class Row:
    """The content of a slot, a waiting place or a reading at each moment; "" for idle slots and empty places."""

    label: str
    cells: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Lane:
    """The lane of a request, or with `values` of something that has a value; `marks`: by step, in their order."""

    name: str
    values: bool
    rows: tuple[Row, ...]
    marks: dict[int, tuple[LaneMark, ...]]

    def busy(self, first: int, last: int) -> bool:
        """Return whether the lane has a cell that is not empty, or a mark, from moment `first` to moment `last`."""
        drawn = any(row.cells[i] for row in self.rows for i in range(first, last + 1))
        return drawn or any(first <= step <= last for step in self.marks)


def lanes_of(story: Story) -> tuple[Lane, ...]:
    """Return the lanes of requests, readings and levels that are not idle, or not constant, or have a mark."""
    marks: Marks = {}
    for step, scene in enumerate(story.scenes, 1):
        found = [_of_event(story.model, scene.event)]
        found += [_of_action(story.model, action) for action in scene.actions]
        for name, mark in found:
            lane = marks.setdefault((mark.kind == "observe", name), {})
            lane[step] = (*lane.get(step, ()), mark)
    lanes = [Lane(CHECKER, False, (), marks.get((False, CHECKER), {}))]
    lanes += [
        Lane(request.name, False, tuple(_rows(story, request.name)), marks.get((False, request.name), {}))
        for request in story.model.requests
    ]
    lanes += _readings(story, marks)
    return tuple(lane for lane in lanes if lane.busy(0, len(story.scenes)))


def _rows(story: Story, name: str) -> Iterator[Row]:
    """Yield the rows of the slots of a request and of its waiting place that are taken at some moment."""
    several = story.model.request[name].instances > 1
    rows = [
        Row(f"[{slot}]" if several else "", tuple(_slot(state, name, slot) for state in story.states))
        for slot in range(story.model.request[name].instances)
    ]
    places = (state.places[name] for state in story.states)
    rows.append(Row("place", tuple(place_text(place) if place else "" for place in places)))
    yield from (row for row in rows if any(row.cells))


def _slot(state: State, name: str, slot: int) -> str:
    content = state.slots[name][slot]
    return content.phase if content else ""


def _readings(story: Story, marks: Marks) -> Iterator[Lane]:
    """Yield a lane for each reading and level that changes or is observed."""
    for name in (*story.start.readings, *story.start.levels):
        cells = tuple(value_text(state.observed(name)) for state in story.states)
        mine = marks.get((True, name), {})
        if mine or len(set(cells)) > 1:
            yield Lane(name, True, (Row("", cells),), mine)


def _of_event(model: Model, event: Event) -> tuple[str, LaneMark]:
    """Return the lane of an event and its mark."""
    whole = event_text(model, event)
    match event:
        case Ask(name, args):
            given = named_text(model.request[name].params, args).replace(" = ", "=")
            if len(given) > MOST_ARGUMENTS:
                given = f"{given[: MOST_ARGUMENTS - 1]}…"
            return name, LaneMark("ask", f"ask {given}".rstrip(), whole)
        case Report(name, slot, outcome):
            several = model.request[name].instances > 1
            return name, LaneMark("report", f"{outcome} [{slot}]" if several else outcome, whole)
        case Observe(name, _, broken):
            return name, LaneMark("observe", "broken" if broken else "observed", whole)
        case Abort(name) | AbortWaiting(name):
            return name, LaneMark("abort", "abort", whole)
        case _:
            assert_never(event)


def _of_action(model: Model, action: Action) -> tuple[str, LaneMark]:
    """Return the lane of an action and its mark, which shows the rule."""
    whole = action_text(model, action)
    match action:
        case Launched(name, launch_rule=required):
            return name, LaneMark("launch", f"launch {required}" if required else "launch", whole)
        case Waits(name, rule):
            return name, LaneMark("wait", f"wait {rule}", whole)
        case Rejected(name, rule):
            return name, LaneMark("reject", f"reject {rule}", whole)
        case Killed(name, _, rule):
            return name, LaneMark("kill", f"kill {rule}", whole)
        case Violated(rule):
            return CHECKER, LaneMark("violation", f"violation {rule}", whole)
        case Invalid(code):
            return CHECKER, LaneMark("invalid", f"invalid {code}", whole)
        case _:
            assert_never(action)
