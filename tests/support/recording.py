"""What one step of the reference interpreter does, as the marks of a step (`exover.loop.exact.actions`)."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from exover.model.decision import Reason
from exover.model.event import Abort, AbortWaiting, Action, Args, Event, Killed, Launched, Rejected, Waits
from exover.model.model import Launch, Model
from exover.model.semantics import Step
from exover.model.state import State
from tests.support.watch import Watched

Label = tuple[str, ...]


@dataclass(frozen=True)
class Recording(Watched):
    """The reference interpreter, which notes the launch rules it tries, whose waiting place is left, and its passes."""

    tried: set[str] = field(default_factory=set)
    left: set[str] = field(default_factory=set)
    begun: list[State] = field(default_factory=list)

    def _ask(self, step: Step, name: str, args: Args, required: Launch | None = None) -> Step:
        if required is not None:
            self.tried.add(required.name)
        after = super()._ask(step, name, args, required)
        new = after.actions[len(step.actions) :]
        if not any(isinstance(each, Rejected) and each.request == name and each.rule != "superseded" for each in new):
            self.left.add(name)
        return after

    def _give_up(self, step: Step, name: str, reason: Reason) -> Step:
        if step.state.places[name]:
            self.left.add(name)
        return super()._give_up(step, name, reason)

    def _recover(self, step: Step) -> Step:
        self.begun.append(step.state)
        return super()._recover(step)


@dataclass(frozen=True, slots=True)
class Done:
    """The state after a step, the marks that it passes, and how many passes changed something."""

    state: State
    marks: frozenset[Label]
    passes: int


def done(model: Model, before: State, event: Event, may_wait: Mapping[str, bool]) -> Done:
    """Return what the step by a valid event does; what asks or waits is `left` where the newcomer takes its place."""
    reference = Recording(model, {})
    after, actions = reference.step(before.unrefused(), event)
    found: set[Label] = {("rule", name) for name in reference.tried}
    for action in actions:
        found |= _marks(action)
    launched = {action.request for action in actions if isinstance(action, Launched)}
    found |= {("left", name) for name in launched | {name for name in reference.left if may_wait[name]}}
    found |= {mark for mark in reference.decided if mark[1] != "abort"}
    if isinstance(event, Abort | AbortWaiting):
        found.add(("abort",))
    return Done(after, frozenset(found), len(reference.begun) - 1)


def _marks(action: Action) -> set[Label]:
    match action:
        case Launched(name, rule=rule):
            return {("launch", name)} | ({("rule", rule)} if rule else set())
        case Waits(name, rule):
            return {("rule", rule), ("put", name)}
        case Rejected(_, rule) | Killed(_, _, rule):
            return {("rule", rule)} - {("rule", word) for word in ("superseded", "aborted", "abort")}
        case _:
            return set()
