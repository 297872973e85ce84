"""The reference interpreter, watched: which rules change what it does, and which guards and remedies decide.

At every moment at which it decides something, models without one of the rules are asked the same.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

from exover.model.decision import Decision, Reason
from exover.model.event import Action, Args, Violated
from exover.model.model import Launch, Model, Request
from exover.model.semantics import Reference, Step
from exover.model.state import SlotId, State


@dataclass(frozen=True)
class Watched(Reference):
    """Remembers what it has seen in all steps that it was asked for."""

    twins: dict[str, Reference]
    """By the name of a rule the model without it."""
    changed: set[str] = field(default_factory=set)
    """The rules without which something else would have been done."""
    decided: set[tuple[str, ...]] = field(default_factory=set)
    """`reject x`, `wait x`, `settle x`: the demand of x was taken; `kill x r`: r was killed or dismissed for x."""

    @cached_property
    def asked(self) -> dict[str, set[str]]:
        """By request the twins that can decide on it otherwise: without a rule that is in question, or its own one."""
        named = {request: {rule.name for rule in rules} for request, rules in self.questions.items()}
        return {request: {*names, f"{request}.interrupts.self"} & self.twins.keys() for request, names in named.items()}

    def decide(self, state: State, request: Request, args: Args) -> Decision:
        """Decide, and note whose demand was taken and whose absence would have made it another decision."""
        decision = super().decide(state, request, args)
        if decision.reason and decision.verdict != "clear":
            self.decided.add((decision.verdict, decision.reason.rule))
        for name in self.asked[request.name] - self.changed:
            twin = self.twins[name]
            other = twin.decide(state, twin.model.request[request.name], args)
            if _done(state, decision) != _done(state, other):
                self.changed.add(name)
        return decision

    def _ask(self, step: Step, name: str, args: Args, required: Launch | None = None) -> Step:
        """Without the rule by which it interrupts itself, a request is not decided while its place is taken."""
        itself = f"{name}.interrupts.self"
        twin = self.twins.get(itself)
        if twin is None or step.state.places[name] is None:
            return super()._ask(step, name, args, required)
        if super().decide(step.state, self.model.request[name], args).verdict != "reject":
            self.changed.add(itself)
        others = Watched(self.model, {k: v for k, v in self.twins.items() if k != itself}, self.changed, self.decided)
        return Reference._ask(others, step, name, args, required)

    def _apply(
        self,
        step: Step,
        request: Request,
        args: Args,
        decision: Decision,
        launch_rule: str | None,
        required: Launch | None = None,
    ) -> Step:
        first = {name: reason.rule for name, reason in reversed(decision.dismissed) if step.state.places[name]}
        self.decided.update(("kill", rule, name) for name, rule in first.items())
        return super()._apply(step, request, args, decision, launch_rule, required)

    def _kill(self, step: Step, slots: list[SlotId], reason: Reason) -> Step:
        running = step.state.running()
        self.decided.update(("kill", reason.rule, name) for name, index in slots if (name, index) in running)
        return super()._kill(step, slots, reason)

    def _recover(self, step: Step) -> Step:
        after = super()._recover(step)
        if after is step:
            return after  # no rule kills anything, so none is missed
        for name in self.twins.keys() - self.changed:
            if self.twins[name]._recover(step).state != after.state:
                self.changed.add(name)
        return after

    def violations(self, state: State) -> tuple[Action, ...]:
        found = super().violations(state)
        self.changed.update(action.rule for action in found if isinstance(action, Violated))
        return found


def watched(model: Model) -> Watched:
    """Return the reference interpreter of a model, which has seen nothing yet."""
    return Watched(model, {name: Reference(_without(model, name)) for name in {rule.name for rule in model.rules}})


def _without(model: Model, name: str) -> Model:
    """Return the model as it is when the clause or rule of this name is taken out of the text."""
    requests = tuple(
        replace(request, interrupts_self=False) if name == f"{request.name}.interrupts.self" else request
        for request in model.requests
    )
    return replace(model, requests=requests, rules=tuple(rule for rule in model.rules if rule.name != name))


def _done(state: State, decision: Decision) -> tuple[object, ...]:
    """Return what a decision does in this state, without its reasons."""
    dismissed = {name for name, _ in decision.dismissed if state.places[name]}
    return decision.verdict, {slot for slot, _ in decision.kills}, dismissed
