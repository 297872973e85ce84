"""The reference interpreter with a log: for each action of a step, the decision or recovery that caused it.

The interpreter itself runs, so there is no second implementation of docs/language.md that could differ; what is added
here only logs where its actions come from.
"""

from dataclasses import field

from exover.dataclass import dataclass
from exover.model.decision import Decision, Reason
from exover.model.event import Action, Args, Event
from exover.model.model import Launch, Request
from exover.model.semantics import Reference, Step
from exover.model.state import SlotId, State


@dataclass(frozen=True, slots=True)
class Decided:
    """A decision on a newcomer in a state; `required`: the launch rule that asks for it; `again`: it stood waiting."""

    state: State
    request: Request
    args: Args
    decision: Decision
    required: Launch | None = None
    again: bool = False


@dataclass(frozen=True, slots=True)
class Recovered:
    """Slots that were killed to restore a rule, and the state before."""

    state: State
    slots: tuple[SlotId, ...]
    reason: Reason


Cause = Decided | Recovered


@dataclass(slots=True)
class Log:
    """The log of a step: by index of an action its cause; by request its last decision; what the step is doing."""

    causes: dict[int, Cause] = field(default_factory=dict)
    decided: dict[str, Decided] = field(default_factory=dict)
    required: Launch | None = None
    settling: bool = False
    recovering: bool = False


@dataclass(frozen=True)
class StepRecorder(Reference):
    """The reference interpreter with a log of one step."""

    log: Log = field(default_factory=Log, compare=False)

    def decide(self, state: State, request: Request, args: Args) -> Decision:
        """Return the decision on a newcomer, and log it."""
        decision = super().decide(state, request, args)
        self.log.decided[request.name] = Decided(
            state, request, args, decision, self.log.required, again=self.log.settling
        )
        return decision

    def _note(self, before: Step, after: Step, cause: Cause | None) -> Step:
        """Log the cause of the actions that `after` has more than `before`, unless they have one; return `after`."""
        if cause:
            for index in range(len(before.actions), len(after.actions)):
                self.log.causes.setdefault(index, cause)
        return after

    def _ask(self, step: Step, name: str, args: Args, required: Launch | None = None) -> Step:
        self.log.decided.pop(name, None)
        self.log.required = required
        after = super()._ask(step, name, args, required)
        self.log.required = None
        return self._note(step, after, self.log.decided.get(name))

    def _apply(
        self,
        step: Step,
        request: Request,
        args: Args,
        decision: Decision,
        launch_rule: str | None,
        required: Launch | None = None,
    ) -> Step:
        after = super()._apply(step, request, args, decision, launch_rule, required)
        return self._note(step, after, self.log.decided[request.name])

    def _reject(self, step: Step, name: str, decision: Decision) -> Step:
        return self._note(step, super()._reject(step, name, decision), self.log.decided[name])

    def _settle(self, step: Step) -> Step:
        self.log.settling = True
        after = super()._settle(step)
        self.log.settling = False
        return after

    def _recover(self, step: Step) -> Step:
        self.log.recovering = True
        after = super()._recover(step)
        self.log.recovering = False
        return after

    def _kill(self, step: Step, slots: list[SlotId], reason: Reason) -> Step:
        after = super()._kill(step, slots, reason)
        return self._note(step, after, Recovered(step.state, tuple(slots), reason) if self.log.recovering else None)


@dataclass(frozen=True, slots=True)
class Watched:
    """A step with its log: the states before and after it, and its actions, each with its cause if it has one."""

    before: State
    after: State
    event: Event
    actions: tuple[tuple[Action, Cause | None], ...]


def watch(reference: Reference, state: State, event: Event) -> Watched:
    """Return the step that the reference interpreter takes, with the causes of its actions."""
    witness = StepRecorder(reference.model)
    after, actions = witness.step(state, event)
    causes = witness.log.causes
    return Watched(state, after, event, tuple((action, causes.get(index)) for index, action in enumerate(actions)))
