"""The gate's state machine: two pure functions of frozen values, without clock and without I/O (docs/gate.md)."""

from collections.abc import Mapping
from dataclasses import field
from typing import Any, assert_never

from exover.dataclass import dataclass
from exover.gate.outer import (
    Alarm,
    AlarmKind,
    Called,
    CallId,
    Cancelled,
    CancelRefused,
    ClientGone,
    Finish,
    Forward,
    GivenUp,
    Hold,
    ModuleGone,
    Observed,
    OuterEffect,
    OuterEvent,
    Refuse,
    Reported,
    SlotSaid,
    Stop,
    Ticked,
    reason_text,
)
from exover.gate.state import ASTRAY, AWAY, USUAL, GateState, Held, Queued, Times
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
from exover.model.state import SlotId

Result = tuple[GateState, tuple[OuterEffect, ...]]
_WHY = {"unavailable": AWAY, "stray": ASTRAY}
"""The reasons of the rules by which the gate gives up a held call; that of a deadline names what it waited for."""


@dataclass(frozen=True)
class GateMachine:
    """The state machine for these slots; `times` by request; `abort_orphans` iff what a gone client runs is aborted."""

    every_slot: frozenset[SlotId]
    times: Mapping[str, Times] = field(default_factory=dict)
    abort_orphans: bool = True

    def start(self) -> GateState:
        """Return the initial state, in which no module has said what runs; without any slot the gate has started."""
        return GateState(self.every_slot, started=not self.every_slot)

    def parts(self, state: GateState, outer: OuterEvent, now: float) -> tuple[OuterEvent, ...]:
        """Return the outer events that an outer event stands for, each of which asks the checker at most once.

        Once the gate has started, the readings kept from before come first.
        """
        split = self._split(state, outer, now)
        return (*map(Observed, state.readings.values()), *split) if state.started and state.readings else split

    def _split(self, state: GateState, outer: OuterEvent, now: float) -> tuple[OuterEvent, ...]:
        match outer:
            case ClientGone(client):
                waiting = [each.call for each in state.places.values()]
                running = [each.call for each in state.slots.values()] if self.abort_orphans else []
                return tuple(Cancelled(call) for call in waiting + running if call and call.client == client)
            case ModuleGone(requests):
                return (outer, *(GivenUp(name, "unavailable") for name in state.places if name in requests))
            case Ticked():
                late = [name for name, queued in state.places.items() if _past(queued.until, now)]
                return (outer, *(GivenUp(name, "deadline") for name in late))
            case SlotSaid(slot, True) if slot not in state.slots and slot not in state.strays:
                called = [name for name, queued in state.places.items() if queued.call]
                return (outer, *(GivenUp(name, "stray") for name in called))
            case _:
                return (outer,)

    def question(self, state: GateState, outer: OuterEvent) -> Event | None:
        """Return the event that the checker has to be asked; None if the gate answers by itself."""
        match outer:
            case Called(_, ask):
                return None if state.denial(ask.request) else ask
            case Cancelled(call):
                return _abort(state, state.where(call))
            case GivenUp(request):
                return AbortWaiting(request) if request in state.places else _unsent(state, request)
            case Reported(report):
                return report if (report.request, report.slot) in state.slots else None
            case Observed(observe):
                return observe if state.started else None
            case SlotSaid((request, slot), active):
                return Report(request, slot, "interrupted") if not active and (request, slot) in state.slots else None
            case _:
                return None

    def answer(
        self, state: GateState, outer: OuterEvent, event: Event | None, actions: tuple[Action, ...], now: float
    ) -> Result:
        """Return the state after an outer event, whose `event` the checker answered by `actions`, and the effects."""
        step = _Step(self, state, now)
        step.own(outer, event)
        for action in actions:
            step.obey(action, outer, event)
        if event is not None and not _refused(event, actions):
            step.violations(actions)
        return step.result()


class _Step:
    """One call of `answer`: the fields of the state that are replaced, and the effects so far."""

    __slots__ = "_changes", "_effects", "_machine", "_newcomer", "_now", "_state"

    def __init__(self, machine: GateMachine, state: GateState, now: float) -> None:
        self._machine = machine
        self._state = state
        self._now = now
        self._changes: dict[str, Any] = {}
        self._effects: list[OuterEffect] = []
        self._newcomer: CallId | None = None
        """The call of this event, until it is forwarded, held or refused."""

    def result(self) -> Result:
        return self._state._replace(**self._changes), tuple(self._effects)

    # ---- the state ----

    def _slots(self) -> dict[SlotId, Held]:
        found: dict[SlotId, Held] | None = self._changes.get("slots")
        if found is None:
            found = self._changes["slots"] = dict(self._state.slots)
        return found

    def _places(self) -> dict[str, Queued]:
        found: dict[str, Queued] | None = self._changes.get("places")
        if found is None:
            found = self._changes["places"] = dict(self._state.places)
        return found

    def _get(self, name: str) -> Any:
        """Return the current value of a field of the state."""
        return self._changes[name] if name in self._changes else getattr(self._state, name)

    def _alarm(self, kind: AlarmKind, slot: SlotId | None, detail: str = "") -> None:
        request, number = slot or (None, None)
        self._effects.append(Alarm(kind, request, number, detail))

    def _times(self, request: str) -> Times:
        return self._machine.times.get(request, USUAL)

    # ---- what the gate does itself ----

    def own(self, outer: OuterEvent, event: Event | None) -> None:
        """Do what does not depend on the actions of the checker."""
        match outer:
            case Called(call, ask):
                self._newcomer = call
                if event is None:
                    self._refuse(call, *(self._state.denial(ask.request) or ("", None)))
            case Reported(report):
                self._end((report.request, report.slot), report, event)
            case CancelRefused(slot):
                if slot in self._state.slots or slot in self._state.strays:
                    self._alarm("refuses-to-stop", slot)
            case ModuleGone(requests):
                self._lose(requests)
            case SlotSaid(slot, active):
                self._said(slot, active, event)
            case Ticked():
                self._late()
            case Observed(observe):
                self._observed(observe, event)
            case GivenUp():
                if isinstance(event, Report):
                    self._end((event.request, event.slot), event, event)
            case Cancelled() | ClientGone():
                pass
            case _:
                assert_never(outer)

    def _end(self, slot: SlotId, report: Report, event: Event | None) -> None:
        if event is None:
            self._alarm("stray", slot, f"it was reported as {report.outcome}, and does not run here")
            return
        held = self._slots().pop(slot)
        self._effects.append(Finish(held.call, slot, report.outcome))
        self._heard(slot)

    def _observed(self, observe: Observe, event: Event | None) -> None:
        """Keep a reading that was not told to the checker; drop the kept one once the checker has been told."""
        if event is None or observe.name in self._state.readings:
            others = {name: each for name, each in self._state.readings.items() if name != observe.name}
            self._changes["readings"] = others if event else {**others, observe.name: observe}

    def _lose(self, requests: frozenset[str]) -> None:
        self._changes["away"] = self._state.away | requests
        self._changes["unsaid"] = self._state.unsaid | {
            slot for slot in self._machine.every_slot if slot[0] in requests
        }
        for slot, held in self._state.slots.items():
            if slot[0] in requests and not held.lost:
                self._slots()[slot] = held._replace(call=None, lost=True, due=None)
                self._alarm("module-gone", slot, "it counts as active until its module says that it does not run")
                if held.call:
                    self._refuse(held.call, "unavailable", AWAY)

    def _said(self, slot: SlotId, active: bool, event: Event | None) -> None:
        held = self._state.slots.get(slot)
        if active and held is None:
            if slot not in self._state.strays:
                self._changes["strays"] = self._state.strays | {slot}
                if not self._state.started:
                    self._changes["unsaid"] = self._state.unsaid | {slot}
                self._alarm("stray", slot, "it runs, and was not launched here")
                self._effects.append(Stop(slot, "stray", ASTRAY))
            return
        if held and not active:
            self._end(slot, Report(*slot, "interrupted"), event)
        elif held and held.lost:
            self._slots()[slot] = held._replace(lost=False)
            if held.phase == "stopping":
                self._effects.append(Stop(slot, "aborted", None))
        if slot in self._state.strays:
            self._changes["strays"] = self._state.strays - {slot}
        self._heard(slot)

    def _heard(self, slot: SlotId) -> None:
        """Note that a slot was launched, or that its module has said whether it runs: the module is there."""
        if slot in self._get("unsaid"):
            self._changes["unsaid"] = self._get("unsaid") - {slot}
            self._changes["away"] = self._get("away") - {slot[0]}
            self._changes["started"] = self._state.started or not self._changes["unsaid"]

    def _late(self) -> None:
        for slot, held in self._state.slots.items():
            if _past(held.due, self._now):
                self._slots()[slot] = held._replace(due=None)
                self._alarm("no-report" if held.phase == "running" else "does-not-stop", slot)

    # ---- what the checker says ----

    def obey(self, action: Action, outer: OuterEvent, event: Event | None) -> None:
        """Update the state for one action, and add its effects."""
        match action:
            case Launched(name, slot, args, _, _, launch_rule):
                self._forward((name, slot), args, self._taker(name, launch_rule, event))
            case Waits(name, rule, because, launch_rule):
                self._hold(name, rule, because, launch_rule)
            case Rejected():
                self._reject(action, outer, event)
            case Killed(name, slot, rule, because):
                self._stop((name, slot), rule, because)
            case Violated():
                pass
            case Invalid(code, detail):
                self._invalid(code, detail, event)
            case _:
                assert_never(action)

    def _taker(self, name: str, launch_rule: str | None, event: Event | None) -> CallId | None:
        """Return the call that is launched, if any: the newcomer, else that of the waiting place, which is emptied."""
        if launch_rule is None and self._newcomer and isinstance(event, Ask) and event.request == name:
            call, self._newcomer = self._newcomer, None
            return call
        queued = self._places().pop(name, None) if name in self._get("places") else None
        return queued.call if queued else None

    def _forward(self, slot: SlotId, args: Args, call: CallId | None) -> None:
        away = slot[0] in self._get("away")
        astray = call is not None and bool(self._get("strays"))
        lost = away or astray
        answer = self._times(slot[0]).answer
        due = None if answer is None or lost else self._now + answer
        self._slots()[slot] = Held(None if lost else call, args, "running", lost, due)
        if call and astray:
            self._refuse(call, "stray", ASTRAY)
        elif away:
            self._alarm("module-gone", slot, "it is launched, and its module is not there")
            if call:
                self._refuse(call, "unavailable", AWAY)
        else:
            self._heard(slot)
            self._effects.append(Forward(call, slot, args))

    def _hold(self, name: str, rule: str, because: str | None, launch_rule: str | None) -> None:
        call = None
        until = None
        if launch_rule is None and self._newcomer:
            call, self._newcomer = self._newcomer, None
            self._effects.append(Hold(call, rule, because))
            wait = self._times(name).wait
            until = None if wait is None else self._now + wait
        self._places()[name] = Queued(call, launch_rule, rule, because, until)

    def _reject(self, action: Rejected, outer: OuterEvent, event: Event | None) -> None:
        name, rule, because = action.request, action.rule, action.because
        asked = self._newcomer and isinstance(event, Ask) and event.request == name and action.launch_rule is None
        if asked and rule != "superseded" and self._newcomer:
            call, self._newcomer = self._newcomer, None
            self._refuse(call, rule, because)
            return
        queued = self._places().get(name)
        if queued is not None and queued.origin == action.launch_rule:
            del self._places()[name]
            if queued.call and outer != Cancelled(queued.call):
                self._refuse(queued.call, *(_given_up(outer, name, queued) or (rule, because)))
        if action.launch_rule is not None:
            self._effects.append(Alarm("refused-launch", name, None, f"{action.launch_rule} is refused by {rule}"))

    def _stop(self, slot: SlotId, rule: str, because: str | None) -> None:
        held = self._slots()[slot]
        self._slots()[slot] = held._replace(phase="stopping", due=self._now + self._times(slot[0]).stop)
        self._effects.append(Stop(slot, rule, because))

    def _invalid(self, code: str, detail: str, event: Event | None) -> None:
        if self._newcomer and isinstance(event, Ask):
            self._refuse(self._newcomer, code, detail)
        elif not (isinstance(event, Observe) and event.broken):
            self._alarm("invalid", None, f"{code}: {detail}" if detail else code)

    def _refuse(self, call: CallId, rule: str, because: str | None) -> None:
        self._effects.append(Refuse(call, rule, because))

    def violations(self, actions: tuple[Action, ...]) -> None:
        """Add an alarm for each rule that is violated since this event."""
        broken = frozenset([action.rule for action in actions if isinstance(action, Violated)])
        if broken != self._state.violated:
            self._changes["violated"] = broken
            for rule in sorted(broken - self._state.violated):
                self._alarm("violation", None, rule)


def _abort(state: GateState, where: SlotId | str | None) -> Event | None:
    if isinstance(where, str):
        return AbortWaiting(where)
    return Abort(*where) if where and state.slots[where].phase == "running" else None


def _unsent(state: GateState, request: str) -> Event | None:
    """Return the end of what was launched as another was given up, and not sent, since something is stray."""
    lost = (slot for slot, held in state.slots.items() if held.lost and slot not in state.unsaid)
    return next((Report(*slot, "interrupted") for slot in lost if slot[0] == request), None)


def _given_up(outer: OuterEvent, name: str, queued: Queued) -> tuple[str, str | None] | None:
    """Return rule and reason if the gate itself gives up this held call; else None."""
    if not isinstance(outer, GivenUp) or outer.request != name:
        return None
    if outer.rule in _WHY:
        return outer.rule, _WHY[outer.rule]
    return outer.rule, f"it has waited too long for {reason_text(queued.rule, queued.because)}"


def _refused(event: Event, actions: tuple[Action, ...]) -> bool:
    """Return whether the event was invalid and changed nothing; a broken reading is taken as the `else` value."""
    if not (actions and isinstance(actions[0], Invalid)):
        return False
    return not (isinstance(event, Observe) and event.broken)


def _past(due: float | None, now: float) -> bool:
    return due is not None and due <= now
