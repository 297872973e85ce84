"""THE meaning: what the checker does with one event (docs/language.md section 4), slow and obvious.

Every engine is measured against this one. A function here is a paragraph of the page, in its words and its order.
"""

from dataclasses import field, replace
from functools import cached_property
from typing import assert_never

from exover.dataclass import dataclass
from exover.model.decision import BUSY, Decision, Decisions, Reason, affect
from exover.model.evaluate import Scope, applies, bind, holds
from exover.model.event import (
    Abort,
    AbortWaiting,
    Action,
    Args,
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
from exover.model.model import Launch, Request
from exover.model.state import Place, Slot, SlotId, State, resting


@dataclass(frozen=True)
class Step:
    """A step under way: the state, the actions so far, and what has to be remembered until the step ends."""

    state: State
    actions: tuple[Action, ...] = ()
    tried: frozenset[str] = frozenset()
    """Launch rules that were tried in this step."""
    fallen: frozenset[str] = frozenset()
    """Requests that fell from clearing to waiting in this step."""
    refused: dict[str, str] = field(default_factory=dict)
    """Launch rules that were tried and refused in this step, each with the rule that refused it."""

    def so(self, state: State, *actions: Action) -> "Step":
        """Return the step with this state and these further actions."""
        return replace(self, state=state, actions=self.actions + actions)


@dataclass(frozen=True)
class Reference(Decisions):
    """The reference interpreter of a model."""

    def start(self) -> State:
        """Return the initial state."""
        return self._start

    @cached_property
    def _start(self) -> State:
        return self._latch(resting(self.model), cleared_by=None)

    def step(self, state: State, event: Event) -> tuple[State, tuple[Action, ...]]:
        """Return the state after the event and the actions that answer it, in order."""
        fault = self.validate(state, event)
        if fault:
            return state, (fault,)
        step = self._update(Step(state), event)
        while True:
            before = step.state
            step = self._settle(self._launch_required(self._recover(step)))
            if step.state == before:
                state = replace(step.state, refused=step.refused)
                return state, step.actions + self.violations(state)

    def validate(self, state: State, event: Event) -> Invalid | None:
        """Return why a well-formed event cannot happen in this state, or None."""
        match event:
            case Report(name, slot) if state.slots[name][slot] is None:
                return Invalid("not-active", f"slot {slot} of {name} is idle")
            case Abort(name, slot) if state.slots[name][slot] is None:
                return Invalid("nothing-to-abort", f"slot {slot} of {name} is idle")
            case AbortWaiting(name) if state.places[name] is None:
                return Invalid("nothing-to-abort", f"nothing waits at {name}")
            case _:
                return None

    def _update(self, step: Step, event: Event) -> Step:
        state = step.state
        match event:
            case Ask(name, args):
                return self._ask(step, name, args)
            case Report(name, _, outcome):
                cleared_by = name if outcome == "ok" else None
                return step.so(self._latch(self._end(state, event), cleared_by))
            case Observe(name, value, broken):
                faults = (Invalid("out-of-range", f"taken as {value}"),) if broken else ()
                state = state.with_observed(name, value)
                return step.so(self._latch(state, cleared_by=None), *faults)
            case Abort(name, slot):
                return self._kill(step, [(name, slot)], Reason("abort"))
            case AbortWaiting(name):
                return self._give_up(step, name, Reason("aborted"))
            case _:
                assert_never(event)

    def _ask(self, step: Step, name: str, args: Args, required: Launch | None = None) -> Step:
        """Return the step with an ask done; `required`: the launch rule that raised it."""
        request, place = self.model.request[name], step.state.places[name]
        if place and not request.interrupts_self:
            return self._refuse(step, name, BUSY, required)
        decision = self.decide(step.state, request, args)
        if decision.verdict == "reject":
            return self._refuse(step, name, decision.reason or BUSY, required)
        if place:
            step = step.so(step.state, Rejected(name, "superseded", launch_rule=place.launch_rule))
        launch_rule = required.name if required else None
        step = self._apply(step, request, args, decision, launch_rule, required)
        if decision.verdict != "launch" and decision.reason:
            waits = Waits(name, decision.reason.rule, decision.reason.because, launch_rule)
            step = step.so(step.state, waits)
        return step

    def _refuse(self, step: Step, name: str, reason: Reason, required: Launch | None) -> Step:
        """Return the step with a newcomer rejected; a refusal that repeats the last step's is no action."""
        if required is None:
            return step.so(step.state, Rejected(name, reason.rule, reason.because))
        known = step.state.refused.get(required.name)
        step = replace(step, refused={**step.refused, required.name: reason.rule})
        if known == reason.rule:
            return step
        return step.so(step.state, Rejected(name, reason.rule, reason.because, required.name))

    def _reject(self, step: Step, name: str, decision: Decision) -> Step:
        """Return the step with what is in the waiting place rejected, once it was decided again."""
        return self._give_up(step, name, decision.reason or BUSY)

    def _give_up(self, step: Step, name: str, reason: Reason) -> Step:
        """Return the step with what is in the waiting place of a request rejected, if something is."""
        place = step.state.places[name]
        if not place:
            return step
        rejected = Rejected(name, reason.rule, reason.because, place.launch_rule)
        return step.so(step.state.with_place(name, None), rejected)

    def _apply(
        self,
        step: Step,
        request: Request,
        args: Args,
        decision: Decision,
        launch_rule: str | None,
        required: Launch | None = None,
    ) -> Step:
        """Return the step with a decision done that is no rejection: kill, take the waiting place, or launch.

        `launch_rule`: the origin of the request; `required`: its launch rule, if that requires it in this step.
        """
        name = request.name
        for slot, reason in decision.kills:
            step = self._kill(step, [slot], reason)
        if decision.verdict != "launch":
            return step.so(step.state.with_place(name, Place(decision.verdict != "wait", args, launch_rule)))
        step = step.so(step.state.with_place(name, None))
        for other, reason in decision.dismissed:
            step = self._give_up(step, other, reason)
        index = step.state.slots[name].index(None)
        state = self.launching(step.state, request, args, index)
        rule, because = (required.name, required.because) if required else (None, None)
        return step.so(state, Launched(name, index, args, rule, because, launch_rule))

    def _kill(self, step: Step, slots: list[SlotId], reason: Reason) -> Step:
        for name, index in slots:
            slot = step.state.slots[name][index]
            if slot and slot.phase == "running":
                state = step.state.with_slot((name, index), Slot("stopping", slot.args))
                step = step.so(state, Killed(name, index, reason.rule, reason.because))
        return step

    def _end(self, state: State, report: Report) -> State:
        """Return the state after a report: the slot is idle; `last` is set; if `ok`, the past is set and `produces`
        clauses are applied; then the `on` clauses are.
        """
        request = self.model.request[report.request]
        slot = state.slots[report.request][report.slot]
        assert slot is not None, "validated"
        scope = Scope(bind(request.params, slot.args))
        state = state.with_slot((request.name, report.slot), None)
        state = replace(state, last={**state.last, request.name: report.outcome})
        if report.outcome == "ok":
            state = state.with_past(request.name, slot.args + report.results)
            for share in request.productions:
                if applies(self.model, state, share.when, scope):
                    capacity = self.model.resource[share.resource].capacity
                    state = state.with_level(share.resource, min(capacity, state.levels[share.resource] + share.amount))
        clauses = {"ok": request.on_ok, "failed": request.on_failed, "interrupted": request.on_interrupted}
        return affect(state, clauses[report.outcome])

    def _latch(self, state: State, cleared_by: str | None) -> State:
        for latch in self.model.latches:
            if holds(self.model, state, latch.condition):
                state = state.with_reading(latch.name, True)
            elif cleared_by in latch.resets:
                state = state.with_reading(latch.name, False)
        return state

    def _recover(self, step: Step) -> Step:
        stopped = step.state.once_stopped()
        for rule in self.rules(step.state):
            kills = rule.kills
            for instance in self.instances(step.state, rule) if kills else ():
                if not self.true(stopped, instance):
                    continue
                for kill in kills:
                    slots = self.targets(step.state, kill, instance)
                    if not self.true(stopped.idle(slots), instance):
                        step = self._kill(step, slots, instance.reason)
                        stopped = step.state.once_stopped()
                        break
        return step

    def _launch_required(self, step: Step) -> Step:
        for launch in self.model.launches:
            if launch.name in step.tried or not holds(self.model, step.state, launch.condition):
                continue
            place = step.state.places[launch.request]
            held = [slot.args for slot in step.state.slots[launch.request] if slot] + ([place.args] if place else [])
            if launch.args in held:
                continue
            step = replace(step, tried=step.tried | {launch.name})
            step = self._ask(step, launch.request, launch.args, launch)
        return step

    def _settle(self, step: Step) -> Step:
        if not any(step.state.places.values()):
            return step
        for request in self.model.requests:
            place = step.state.places[request.name]
            if not place:
                continue
            decision = self.decide(step.state, request, place.args)
            if decision.verdict == "reject":
                step = self._reject(step, request.name, decision)
            elif decision.verdict == "launch":
                step = self._apply(step, request, place.args, decision, place.launch_rule)
            elif decision.verdict == "wait" or request.name in step.fallen:
                fallen = step.fallen | ({request.name} if place.clearing else set())
                waiting = step.state.with_place(request.name, replace(place, clearing=False))
                step = replace(step, state=waiting, fallen=fallen)
            else:
                step = self._apply(step, request, place.args, decision, place.launch_rule)
        return step

    def violations(self, state: State) -> tuple[Action, ...]:
        """Return a violation for each rule that is broken in a state, by name and in order."""
        stopped = state.once_stopped()
        broken = [
            i.reason for rule in self.rules(stopped) for i in self.instances(stopped, rule) if self.true(stopped, i)
        ]
        return tuple(Violated(reason.rule, reason.because) for reason in dict.fromkeys(broken))
