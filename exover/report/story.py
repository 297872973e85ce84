"""A run with the state at each of its moments, from which all drawings and texts of a trace are made."""

from collections.abc import Iterator

from exover.dataclass import dataclass
from exover.model.event import Action, Args, Event
from exover.model.model import Model
from exover.model.semantics import Reference
from exover.model.state import Place, State
from exover.model.trace import Trace
from exover.model.wording import action_text, event_text, named_text, value_text


@dataclass(frozen=True, slots=True)
class Scene:
    """One step of a run: the event, the actions that answered it, the states before and after it."""

    event: Event
    actions: tuple[Action, ...]
    before: State
    after: State


@dataclass(frozen=True, slots=True)
class Story:
    """A run from the initial state; `loop_start`: the index of the scene to which a lasso returns."""

    model: Model
    start: State
    scenes: tuple[Scene, ...]
    loop_start: int | None = None

    @property
    def states(self) -> tuple[State, ...]:
        """The state at each moment: the initial one, then that after each step."""
        return (self.start, *(scene.after for scene in self.scenes))


def story_of(model: Model, trace: Trace) -> Story:
    """Return the story of a trace; the states are those of the reference interpreter."""
    reference = Reference(model)
    start = state = reference.start()
    scenes: list[Scene] = []
    for moment in trace.moments:
        after, _ = reference.step(state, moment.event)
        scenes.append(Scene(moment.event, moment.actions, state, after))
        state = after
    return Story(model, start, tuple(scenes), trace.loop_start)


def story_lines(story: Story) -> Iterator[str]:
    """Yield a numbered line for each event, and below it, indented, one for each action and each other change.

    The start and the end of the loop of a lasso have lines of their own.
    """
    model, width = story.model, len(str(len(story.scenes)))
    margin = " " * (width + 4)
    if not story.scenes:
        yield "at the start, before any event"
    for step, scene in enumerate(story.scenes, 1):
        if step - 1 == story.loop_start:
            yield f"{'':>{width}}  the loop starts here:"
        yield f"{step:>{width}}. {event_text(model, scene.event)}"
        yield from (f"{margin}{action_text(model, action)}" for action in scene.actions)
        yield from (f"{margin}{change}" for change in changes(model, scene))
    if story.loop_start is not None:
        yield f"{'':>{width}}  and again from step {story.loop_start + 1}, for ever"


def changes(model: Model, scene: Scene) -> Iterator[str]:
    """Yield the changes of a step that no action tells: readings, levels, pasts, waiting turned into clearing."""
    before, after = scene.before, scene.after
    for name, value in after.readings.items():
        if value != before.readings[name]:
            yield f"{name} {value_text(before.readings[name])} -> {value_text(value)}"
    for name, level in after.levels.items():
        if level != before.levels[name]:
            yield f"level({name}) {before.levels[name]} -> {level}"
    for name, values in after.past.items():
        if values != before.past[name]:
            yield f"past({name}) {past_text(model, name, before.past[name])} -> {past_text(model, name, values)}"
    for name, place in after.places.items():
        old = before.places[name]
        if place and old and place.args == old.args and place.clearing != old.clearing:
            yield f"{name} {place_text(old)} -> {place_text(place)}"


def past_text(model: Model, name: str, values: Args | None) -> str:
    """Return a past as `none`, `ok`, or its arguments and results."""
    if values is None:
        return "none"
    request = model.request[name]
    return named_text(request.params + request.results, values) or "ok"


def place_text(place: Place | None) -> str:
    """Return the state of a waiting place: `empty`, `waiting` or `clearing`."""
    if place is None:
        return "empty"
    return "clearing" if place.clearing else "waiting"
