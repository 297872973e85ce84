"""Follows the robot in the state of the tables, as far as the tables let it (docs/audit.md, "What is asked").

Slow and simple, over any engine; `exover/runtime/audit.c` does the same, and tests compare it with this.
"""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Protocol, assert_never

from exover.audit.held import REFUSED, UNDECIDED, HeldSlot, KnownRequest
from exover.audit.mission import KillDeed, LaunchDeed, LostLines, Noted, RejectDeed, ToldMark, Unread, Void, WaitDeed
from exover.audit.trail import DIVERGENCES, AuditAnswer, AuditRow, MissionFigures, RowKind
from exover.model.event import (
    NO_RULES,
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
from exover.model.model import Model


class AuditChecker(Protocol):
    """An engine that also tells whether a waiting place is taken."""

    def step(self, event: Event) -> tuple[Action, ...]:
        """Take a well-formed event and return the actions that answer it."""
        ...

    def waits(self, request: str) -> bool:
        """Return whether the waiting place of a request is taken."""
        ...


class Follower:
    """The audit of one mission. `tell` gets each divergence, and each ask if `wants_asks`."""

    def __init__(self, model: Model, checker: AuditChecker, tell: Callable[[AuditRow], None], wants_asks: bool) -> None:
        self._model = model
        self._checker = checker
        self._tell = tell
        self._wants_asks = wants_asks
        self._known = {
            each.name: KnownRequest([None] * each.instances, [None] * each.instances) for each in model.requests
        }
        self._event = 0
        self._asked: str | None = None
        self._stops: dict[tuple[str, int], str] = {}
        self._killed: set[tuple[str, int]] = set()
        self._line, self._time = 0, 0.0
        self.figures = MissionFigures()

    def take(self, line: int, noted: Noted) -> None:
        """Take the items of a line."""
        self._line, self._time = line, noted.time
        for item in noted.items:
            match item:
                case Ask() | Report() | Observe() | Abort() | AbortWaiting():
                    self._begin()
                    self._raise(item)
                case LaunchDeed(name, instance, args):
                    self.figures.deeds += 1
                    self._launched(name, instance, args)
                case KillDeed(name, instance):
                    self.figures.deeds += 1
                    self._killed_by_robot(name, instance)
                case WaitDeed(name):
                    self.figures.deeds += 1
                    self._waited(name)
                case RejectDeed(name):
                    self.figures.deeds += 1
                    self._rejected(name)
                case ToldMark():
                    self._told()
                case LostLines(lines):
                    self.figures.lost += lines
                case Void():
                    self._begin()
                    self.figures.passed += 1
                case Unread():
                    self._unread(item)
                case _:
                    assert_never(item)

    # ---- events ----

    def _begin(self) -> None:
        self.figures.events += 1
        self._forget()

    def _forget(self) -> None:
        """End the last event: what follows is not about it."""
        self._event += 1
        self._asked = None
        self._stops.clear()
        self._killed.clear()

    def _raise(self, event: Event) -> None:
        match event:
            case Ask(name, args):
                self._ask(name, args)
                self._was_asked(name)
            case Report(name, instance):
                slot = self._ending(name, instance)
                if slot is not None:
                    self._recorded(replace(event, slot=slot))
            case Observe():
                self._recorded(event)
            case Abort(name, instance):
                slot = self._known[name].meant(instance)
                if slot is not None and slot < 0:
                    self.figures.passed += 1
                else:
                    self._recorded(Abort(name, instance if slot is None else slot))
            case AbortWaiting(name):
                if self._checker.waits(name):
                    self._recorded(event)
                else:
                    self.figures.passed += 1
            case _:
                assert_never(event)

    def _ask(self, name: str, args: Args) -> None:
        actions = self._recorded(Ask(name, args))
        known = self._known[name]
        known.answer, known.rule = verdict(name, actions)

    def _was_asked(self, name: str) -> None:
        known = self._known[name]
        self._asked = name
        known.asked = self._event
        known.open = known.answer in ("reject", "invalid")
        self.figures.asks[name, known.answer] += 1
        if self._wants_asks:
            self._note("ask", name, None, known.answer, known.rule)

    def _unread(self, item: Unread) -> None:
        code = item.fault.code
        if item.kind == "launch":
            self.figures.deeds += 1
            assert item.request is not None
            if item.instance is None:
                self._note("launched", item.request, None, "invalid", code)
            else:
                self._vacate(item.request, item.instance)
                self._refuse(item.request, item.instance, "invalid", code)
            return
        if item.kind in ("deed", "other"):
            self.figures.deeds += item.kind == "deed"
            self._forget()
            return
        self._begin()
        self.figures.invalid += 1
        if item.kind == "ask" and item.request is not None:
            known = self._known[item.request]
            known.answer, known.rule = "invalid", code
            self._was_asked(item.request)
        elif item.kind == "report" and item.request is not None and item.instance is not None:
            slot = self._ending(item.request, item.instance)
            if slot is not None:
                self._follow(Report(item.request, slot, "failed"))

    def _ending(self, name: str, instance: int) -> int | None:
        """Return the slot that a report of an instance ends, which is idle from now on; None if there is none.

        If the tables had not launched the instance, this notes a divergence `ran`.
        """
        known = self._known[name]
        slot = known.meant(instance)
        known.slot_of[instance] = None
        if slot is not None and slot >= 0:
            known.slots[slot] = None
            return slot
        self.figures.passed += 1
        if slot is None:
            if self._checker.waits(name):
                self._note("ran", name, instance, "wait", known.waits_for)
            elif known.open:
                self._note("ran", name, instance, known.answer, known.rule)
            else:
                self._note("ran", name, instance, "none", None)
            known.open = False
            self._give_up(name)
        return None

    # ---- deeds ----

    def _launched(self, name: str, instance: int, args: Args | None) -> None:
        known = self._known[name]
        self._vacate(name, instance)
        if args is None and not self._model.request[name].params:
            args = ()
        if known.claim(instance, args):
            return
        if self._checker.waits(name):
            self._refuse(name, instance, "wait", known.waits_for)
        elif known.open:
            self._refuse(name, instance, known.answer, known.rule)
        elif args is None:
            self.figures.undecided += 1
            known.slot_of[instance] = UNDECIDED
        else:
            self._ask(name, args)
            if not known.claim(instance, args):
                self._refuse(name, instance, known.answer, known.rule)

    def _vacate(self, name: str, instance: int) -> None:
        """End the earlier run of an instance, if its end was not recorded, as interrupted."""
        known = self._known[name]
        slot, known.slot_of[instance] = known.slot_of[instance], None
        if slot is not None and slot >= 0:
            known.slots[slot] = None
            self._follow(Report(name, slot, "interrupted"))

    def _refuse(self, name: str, instance: int, answer: AuditAnswer, rule: str | None) -> None:
        known = self._known[name]
        self._note("launched", name, instance, answer, rule)
        known.slot_of[instance] = REFUSED
        known.open = False
        self._give_up(name)

    def _killed_by_robot(self, name: str, instance: int) -> None:
        number = self._known[name].meant(instance)
        if number is None or number < 0:
            self.figures.passed += 1
            return
        slot = self._known[name].slots[number]
        assert slot
        if not slot.stopping:
            self._note("stopped", name, instance, "none", None)
            self._follow(Abort(name, number))
        self._killed.add((name, number))

    def _waited(self, name: str) -> None:
        known = self._known[name]
        known.waited = self._event
        if known.asked == self._event and known.open and known.held != self._event:
            self._note("otherwise", name, None, known.answer, known.rule)
            known.open = False

    def _rejected(self, name: str) -> None:
        known = self._known[name]
        known.open = False
        if not known.was_denied(self._event) and self._checker.waits(name):
            self._note("otherwise", name, None, "wait", known.waits_for)
            self._give_up(name)

    def _told(self) -> None:
        self.figures.told += 1
        for (name, number), rule in self._stops.items():
            slot = self._known[name].slots[number]
            if slot and slot.stopping and slot.owner is not None and (name, number) not in self._killed:
                self._note("kept", name, slot.owner, "none", rule)
        self._stops.clear()
        if self._asked is not None:
            known = self._known[self._asked]
            if known.open and known.waited == self._event:
                self._note("otherwise", self._asked, None, known.answer, known.rule)
            known.open = False
        ends: list[tuple[str, int]] = []
        for name, known in self._known.items():
            withheld = [number for number, slot in enumerate(known.slots) if slot and slot.withheld(self._event)]
            if withheld and not known.wanted:
                self._note("withheld", name, None, "launch", None)
            known.wanted = bool(withheld)
            ends += ((name, number) for number in withheld)
        for name, number in ends:
            slot = self._known[name].slots[number]
            if slot and slot.owner is None:
                self._known[name].slots[number] = None
                self._follow(Report(name, number, "interrupted"))

    # ---- the tables ----

    def _recorded(self, event: Event) -> tuple[Action, ...]:
        """Ask the tables a recorded event, and return what they answer."""
        actions = self._checker.step(event)
        self._take(actions, True)
        return actions

    def _follow(self, event: Event) -> None:
        """Ask the tables an event of the audit's own."""
        self.figures.followed += 1
        self._take(self._checker.step(event), False)

    def _give_up(self, name: str) -> None:
        if self._checker.waits(name):
            self._follow(AbortWaiting(name))

    def _take(self, actions: Iterable[Action], counted: bool) -> None:
        """Take over the actions that answer an event; `counted` iff it was recorded and is not the audit's own."""
        for action in actions:
            if counted:
                self._use(action)
            match action:
                case Launched(name, number, args):
                    self._known[name].slots[number] = HeldSlot(args, self._event, not counted)
                case Waits(name, rule):
                    self._known[name].waits_for = rule
                    self._known[name].held = self._event
                case Rejected(name) if counted:
                    self._known[name].deny(self._event)
                case Killed(name, number, rule):
                    slot = self._known[name].slots[number]
                    assert slot
                    slot.stopping = True
                    if counted:
                        self._stops.setdefault((name, number), rule)
                case Invalid():
                    self.figures.invalid += 1
                case Rejected() | Violated():
                    pass
                case _:
                    assert_never(action)

    def _use(self, action: Action) -> None:
        """Count the rule and the launch rule that an action names as used."""
        rule = None if isinstance(action, Invalid) else action.rule
        origin = action.launch_rule if isinstance(action, Launched | Waits | Rejected) else None
        for each in dict.fromkeys((rule, origin)):
            if each is not None and each not in NO_RULES:
                self.figures.used[each] += 1

    def _note(self, kind: RowKind, name: str, instance: int | None, answer: AuditAnswer, rule: str | None) -> None:
        if kind in DIVERGENCES:
            self.figures.diverged[kind] += 1
        self._tell(AuditRow(self._line, self._time, kind, name, instance, answer, rule))


def verdict(name: str, actions: Iterable[Action]) -> tuple[AuditAnswer, str | None]:
    """Return the final answer to an ask of a request, and its rule or code.

    It is the first answer about the newcomer, but `wait` gives way to a later launch or reject in the same step.
    """
    answer: tuple[AuditAnswer, str | None] = "none", None
    for action in actions:
        match action:
            case Launched(request, launch_rule=None) if request == name:
                return "launch", action.rule
            case Waits(request, rule, launch_rule=None) if request == name:
                answer = "wait", rule
            case Rejected(request, rule, launch_rule=None) if request == name and rule != "superseded":
                return "reject", rule
            case Invalid(code):
                return "invalid", code
            case _:
                pass
    return answer
