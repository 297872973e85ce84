"""THE meaning: what the checker does with one event (docs/language.md section 4), slow and obvious.

Every engine is measured against this one. A function here is a paragraph of the page, in its words and its order.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Literal, assert_never

from exover.model.evaluate import NOTHING, Scope, applies, bind, holds
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
from exover.model.model import (
    Consumption,
    Effect,
    Forget,
    Kill,
    KillSlot,
    Launch,
    Model,
    Reject,
    Remedy,
    Request,
    Rule,
    SetState,
    Wait,
)
from exover.model.reads import in_question
from exover.model.state import Place, Slot, SlotId, State, resting


@dataclass(frozen=True, slots=True)
class Reason:
    """A rule's name and its text."""

    rule: str
    because: str | None = None


BUSY = Reason("busy")


@dataclass(frozen=True, slots=True)
class Decision:
    """What is done with a newcomer; `kills` in order, each for its reason; `dismissed` requests with their reasons."""

    verdict: Literal["reject", "wait", "clear", "settle", "launch"]
    reason: Reason | None = None
    kills: tuple[tuple[SlotId, Reason], ...] = ()
    dismissed: tuple[tuple[str, Reason], ...] = ()


@dataclass(frozen=True, slots=True)
class Instance:
    """A rule, or its copy for the slot `slot` where there is one for each slot of a request."""

    rule: Rule
    slot: SlotId | None = None

    @property
    def reason(self) -> Reason:
        """The rule's name and text."""
        return Reason(self.rule.name, self.rule.because)


@dataclass(frozen=True)
class Step:
    """A state, the actions taken in this step so far, and what the step remembers until it ends."""

    state: State
    actions: tuple[Action, ...] = ()
    tried: frozenset[str] = frozenset()
    """Launch rules that were tried in this step."""
    fallen: frozenset[str] = frozenset()
    """Requests that fell from clearing to waiting in this step."""

    def so(self, state: State, *actions: Action) -> "Step":
        """Return the step with this state and these further actions."""
        return Step(state, self.actions + actions, self.tried, self.fallen)


@dataclass(frozen=True)
class Reference:
    """The reference interpreter of a model."""

    model: Model

    @cached_property
    def questions(self) -> dict[str, tuple[Rule, ...]]:
        """The rules in question by request."""
        return in_question(self.model)

    # ---- the step ----

    def start(self) -> State:
        """Return the initial state."""
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
                return step.state, step.actions + self._violations(step.state)

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
                level = name in state.levels
                state = state.with_level(name, int(value)) if level else state.with_reading(name, value)
                return step.so(self._latch(state, cleared_by=None), *faults)
            case Abort(name, slot):
                return self._kill(step, [(name, slot)], Reason("abort"))
            case AbortWaiting(name):
                return step.so(state.with_place(name, None), Rejected(name, "aborted"))
            case _:
                assert_never(event)

    def _ask(self, step: Step, name: str, args: Args, required: Launch | None = None) -> Step:
        """Handle an ask; `required`: the launch rule that raised it."""
        request, place = self.model.request[name], step.state.places[name]
        if place and not request.interrupts_self:
            return step.so(step.state, Rejected(name, BUSY.rule))
        decision = self.decide(step.state, request, args)
        if decision.verdict == "reject":
            return self._reject(step, name, decision)
        if place:
            step = step.so(step.state, Rejected(name, "superseded"))
        step = self._apply(step, request, args, decision, required)
        if decision.verdict != "launch" and decision.reason:
            step = step.so(step.state, Waits(name, decision.reason.rule, decision.reason.because))
        return step

    def _reject(self, step: Step, name: str, decision: Decision) -> Step:
        reason = decision.reason or BUSY
        return step.so(step.state, Rejected(name, reason.rule, reason.because))

    def _apply(
        self, step: Step, request: Request, args: Args, decision: Decision, required: Launch | None = None
    ) -> Step:
        """Carry out a decision that is no rejection: kill, take the waiting place, or launch."""
        name = request.name
        for slot, reason in decision.kills:
            step = self._kill(step, [slot], reason)
        if decision.verdict != "launch":
            return step.so(step.state.with_place(name, Place(decision.verdict != "wait", args)))
        step = step.so(step.state.with_place(name, None))
        for other, reason in decision.dismissed:
            if step.state.places[other]:
                cleared = step.state.with_place(other, None)
                step = step.so(cleared, Rejected(other, reason.rule, reason.because))
        index = step.state.slots[name].index(None)
        state = self._launching(step.state, request, args, index)
        why = (required.name, required.because) if required else (None, None)
        return step.so(state, Launched(name, index, args, *why))

    def _kill(self, step: Step, slots: list[SlotId], reason: Reason) -> Step:
        for name, index in slots:
            slot = step.state.slots[name][index]
            if slot and slot.phase == "running":
                state = step.state.with_slot((name, index), Slot("stopping", slot.args))
                step = step.so(state, Killed(name, index, reason.rule, reason.because))
        return step

    def _end(self, state: State, report: Report) -> State:
        """Return the state after a report: the slot idle, outcome, past and products noted, `on` clauses applied."""
        request = self.model.request[report.request]
        slot = state.slots[report.request][report.slot]
        assert slot is not None, "validated"
        scope = Scope(bind(request.params, slot.args))
        state = state.with_slot((request.name, report.slot), None)
        state = State(
            state.slots,
            state.places,
            state.past,
            {**state.last, request.name: report.outcome},
            state.readings,
            state.levels,
        )
        if report.outcome == "ok":
            state = state.with_past(request.name, slot.args + report.results)
            for share in request.productions:
                if applies(self.model, state, share.when, scope):
                    capacity = self.model.resource[share.resource].capacity
                    state = state.with_level(
                        share.resource, min(capacity, state.levels[share.resource] + share.amount)
                    )
        clauses = {"ok": request.on_ok, "failed": request.on_failed, "interrupted": request.on_interrupted}
        return _affect(state, clauses[report.outcome])

    def _latch(self, state: State, cleared_by: str | None) -> State:
        for latch in self.model.latches:
            if holds(self.model, state, latch.condition):
                state = state.with_reading(latch.name, True)
            elif cleared_by in latch.resets:
                state = state.with_reading(latch.name, False)
        return state

    def _recover(self, step: Step) -> Step:
        for rule in self.model.rules:
            for instance in self.instances(step.state, rule):
                calm = step.state.idle(step.state.stopping())
                if not self._true(calm, instance):
                    continue
                for remedy in rule.remedies:
                    slots = self._targets(step.state, remedy, instance)
                    if slots is not None and not self._true(calm.idle(slots), instance):
                        step = self._kill(step, slots, instance.reason)
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
            step = Step(step.state, step.actions, step.tried | {launch.name}, step.fallen)
            step = self._ask(step, launch.request, launch.args, launch)
        return step

    def _settle(self, step: Step) -> Step:
        for request in self.model.requests:
            place = step.state.places[request.name]
            if not place:
                continue
            decision = self.decide(step.state, request, place.args)
            if decision.verdict == "reject":
                step = self._reject(step.so(step.state.with_place(request.name, None)), request.name, decision)
            elif decision.verdict == "launch":
                step = self._apply(step, request, place.args, decision)
            elif decision.verdict == "wait" or request.name in step.fallen:
                fallen = step.fallen | ({request.name} if place.clearing else set())
                waiting = step.state.with_place(request.name, Place(False, place.args))
                step = Step(waiting, step.actions, step.tried, fallen)
            else:
                step = self._apply(step, request, place.args, decision)
        return step

    def _violations(self, state: State) -> tuple[Action, ...]:
        calm = state.idle(state.stopping())
        broken = [i.reason for rule in self.model.rules for i in self.instances(calm, rule) if self._true(calm, i)]
        return tuple(Violated(reason.rule, reason.because) for reason in dict.fromkeys(broken))

    # ---- the decision ----

    def decide(self, state: State, request: Request, args: Args) -> Decision:
        """Return what is done with the newcomer `request(args)` in this state."""
        idle = [index for index, slot in enumerate(state.slots[request.name]) if slot is None]
        if not idle and not request.interrupts_self:
            return Decision("reject", BUSY)
        index = idle[0] if idle else request.instances
        newcomer = (request.name, index)
        launched = self._launching(state, request, args, index)
        questions = [i for rule in self.questions[request.name] for i in self.instances(launched, rule)]

        cleared = self._clear(launched, newcomer, questions)
        demands = self._demands(state, launched, request, args, newcomer, questions, list(cleared))
        kills = tuple((slot, cleared[slot]) for slot in cleared if slot in state.running())
        for wanted in ("reject", "wait"):
            for verdict, reason in demands:
                if verdict == wanted:
                    return Decision(wanted, reason)
        if cleared:
            return Decision("clear", next(iter(cleared.values())), kills)
        for verdict, reason in demands:
            if verdict == "settle":
                return Decision("settle", reason)
        dismissed = tuple((verdict.request, reason) for verdict, reason in demands if isinstance(verdict, _Dismiss))
        return Decision("launch", dismissed=dismissed)

    def _clear(self, launched: State, newcomer: SlotId, questions: list[Instance]) -> dict[SlotId, Reason]:
        """Return C: the slots to clear, in the order in which they were found, each with the rule that put it there."""
        cleared: dict[SlotId, Reason] = {}
        for instance in questions:
            state = launched.idle(cleared)
            if not self._true_either_way(state, instance):
                continue
            for remedy in instance.rule.remedies:
                slots = self._targets(state, remedy, instance)
                if slots is None:
                    break
                others = [slot for slot in slots if slot != newcomer]
                if not self._true_either_way(state.idle(others), instance):
                    for slot in others:
                        cleared.setdefault(slot, instance.reason)
                    break
        return cleared

    def _demands(
        self,
        state: State,
        launched: State,
        request: Request,
        args: Args,
        newcomer: SlotId,
        questions: list[Instance],
        cleared: list[SlotId],
    ) -> "list[tuple[str | _Dismiss, Reason]]":
        """Return the demands in the order of the text, all with the slots to clear taken as idle."""
        scope = Scope(bind(request.params, args))
        present = state.idle(slot for slot in cleared)
        launched = launched.idle(cleared)
        found: list[tuple[int, str | _Dismiss, Reason]] = []
        for guard in request.guards:
            if not holds(self.model, present, guard.condition, scope):
                verdict = {"check": "reject", "wait": "wait", "settle": "settle"}[guard.kind]
                found.append((guard.place, verdict, Reason(guard.name, guard.because)))
        for consumption in self._shortages(state, request, scope):
            resource = self.model.resource[consumption.resource]
            reason = Reason(resource.name, consumption.because or resource.because)
            found.append((consumption.place, verdict_without_kill(resource.remedies), reason))
        for instance in questions:
            demands = self._rule_demands(launched, newcomer, instance)
            found += [(instance.rule.place, verdict, instance.reason) for verdict in demands]
        found.sort(key=lambda demand: demand[0])
        return [(verdict, reason) for _, verdict, reason in found]

    def _shortages(self, state: State, request: Request, scope: Scope) -> list[Consumption]:
        """Return the first clause that counts of every resource of which the newcomer consumes more than there is."""
        counting: dict[str, list[Consumption]] = {}
        for consumption in request.consumptions:
            if applies(self.model, state, consumption.when, scope):
                counting.setdefault(consumption.resource, []).append(consumption)
        return [
            clauses[0]
            for resource, clauses in counting.items()
            if sum(clause.amount for clause in clauses) > state.levels[resource]
        ]

    def _rule_demands(self, launched: State, newcomer: SlotId, instance: Instance) -> "list[str | _Dismiss]":
        """Return what a rule in question demands for the newcomer: a verdict, or requests to dismiss."""
        remedies = instance.rule.remedies
        if self._true_either_way(launched, instance):
            return [verdict_without_kill(remedies)]
        name = newcomer[0]
        if not any(name in self._killed_requests(remedy, instance) for remedy in remedies):
            return []
        crowded = self._with_clearing(launched, name)
        if not self._true_either_way(crowded, instance):
            return []
        for remedy in remedies:
            if isinstance(remedy, Reject | Wait):
                return [verdict_without_kill((remedy,))]
            killed = self._killed_requests(remedy, instance)
            slots = self._targets(launched, remedy, instance) or []
            without = launched.idle(slot for slot in slots if slot != newcomer)
            spared = [other for other in killed if other != name]
            if not self._true_either_way(self._with_clearing(without, name, spared), instance):
                return [_Dismiss(other) for other in spared]
        return ["reject"]

    def _with_clearing(self, state: State, newcomer: str, without: list[str] | None = None) -> State:
        """Return the state in which the requests that are clearing, but for the newcomer's and `without`, run too."""
        for name, place in state.places.items():
            if place and place.clearing and name != newcomer and name not in (without or ()):
                state = state.with_slot((name, len(state.slots[name])), Slot("running", place.args))
        return state

    def _launching(self, state: State, request: Request, args: Args, index: int) -> State:
        """Return the state with the request running in slot `index`, and `on launch` and `consumes` applied."""
        scope = Scope(bind(request.params, args))
        for consumption in request.consumptions:
            if applies(self.model, state, consumption.when, scope):
                level = state.levels[consumption.resource] - consumption.amount
                state = state.with_level(consumption.resource, level)
        state = state.with_slot((request.name, index), Slot("running", args))
        return _affect(state, request.on_launch)

    # ---- rules ----

    def instances(self, state: State, rule: Rule) -> list[Instance]:
        """Return the rule, or its copies for the active slots that it speaks of, in their order."""
        if rule.slot_of is None:
            return [Instance(rule)]
        return [Instance(rule, slot) for slot in state.active([rule.slot_of])]

    def _true(self, state: State, instance: Instance) -> bool:
        """Return whether the F of a rule holds."""
        scope = NOTHING
        if instance.slot:
            name, index = instance.slot
            slot = state.slots[name][index]
            if slot is None:
                return False
            scope = Scope(bind(self.model.request[name].params, slot.args))
        return holds(self.model, state, instance.rule.condition, scope)

    def _true_either_way(self, state: State, instance: Instance) -> bool:
        """Return whether F holds with the stopping slots as they are, or with them taken as idle."""
        return self._true(state, instance) or self._true(state.idle(state.stopping()), instance)

    def _targets(self, state: State, remedy: Remedy, instance: Instance) -> list[SlotId] | None:
        """Return the active slots that a kill remedy names, in order; None for a remedy that is no kill."""
        match remedy:
            case Kill(requests):
                return state.active(requests)
            case KillSlot():
                return [instance.slot] if instance.slot else []
            case Reject() | Wait():
                return None
            case _:
                assert_never(remedy)

    def _killed_requests(self, remedy: Remedy, instance: Instance) -> tuple[str, ...]:
        """Return the requests that a remedy kills; none if it is no kill."""
        match remedy:
            case Kill(requests):
                return requests
            case KillSlot():
                return (instance.slot[0],) if instance.slot else ()
            case Reject() | Wait():
                return ()
            case _:
                assert_never(remedy)


@dataclass(frozen=True, slots=True)
class _Dismiss:
    """The demand that what waits at this request is given up if the newcomer is launched."""

    request: str


def verdict_without_kill(remedies: tuple[Remedy, ...]) -> str:
    """Return the verdict of the first remedy that is no kill; without one, `reject`."""
    for remedy in remedies:
        if isinstance(remedy, Reject | Wait):
            return "reject" if isinstance(remedy, Reject) else "wait"
    return "reject"


def _affect(state: State, effects: tuple[Effect, ...]) -> State:
    for effect in effects:
        match effect:
            case SetState(name, value):
                state = state.with_reading(name, value)
            case Forget(requests):
                for request in requests:
                    state = state.with_past(request, None)
            case _:
                assert_never(effect)
    return state
