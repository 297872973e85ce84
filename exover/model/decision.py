"""What the checker decides on a newcomer (docs/language.md section 4, "Decide r(args)"), slow and obvious."""

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Literal, assert_never

from exover.dataclass import dataclass
from exover.model.evaluate import NOTHING, Scope, applies, bind, holds
from exover.model.event import Args
from exover.model.model import (
    Consumption,
    Effect,
    Forget,
    Kill,
    KillRemedy,
    KillSlot,
    Model,
    Reject,
    Remedy,
    Request,
    Rule,
    SetState,
    Wait,
)
from exover.model.reads import RulesByNeed, in_question, rule_needs
from exover.model.state import Slot, SlotId, State
from exover.model.waiting import killed, killed_requests


@dataclass(frozen=True, slots=True)
class Reason:
    """A rule's name and its text."""

    rule: str
    because: str | None = None


BUSY = Reason("busy")


@dataclass(frozen=True, slots=True)
class Decision:
    """What is done with a newcomer: a verdict, the slots to kill in order, and the requests to dismiss.

    `reason` is the one of the verdict; each kill and each dismissed request has a reason of its own.
    """

    verdict: Literal["reject", "wait", "clear", "settle", "launch"]
    reason: Reason | None = None
    kills: tuple[tuple[SlotId, Reason], ...] = ()
    dismissed: tuple[tuple[str, Reason], ...] = ()


Objection = tuple[Literal["reject", "wait", "clear", "settle"], Reason]
"""A verdict that is no launch, and the reason for it."""


@dataclass(frozen=True, slots=True)
class Instance:
    """A rule (`slot` is None), or the copy for one slot of a rule that stands for each slot of a request."""

    rule: Rule
    slot: SlotId | None = None

    @property
    def reason(self) -> Reason:
        """The rule's name and text."""
        return Reason(self.rule.name, self.rule.because)


@dataclass(frozen=True, slots=True)
class NewcomerStates:
    """A newcomer under decision: σ' is `launched`, C is `cleared`; `questions` are the rules in question.

    `slot` is the newcomer's: one past the last if none is idle. `cleared` maps each slot to clear to the reason why.
    """

    state: State
    launched: State
    slot: SlotId
    questions: tuple[Instance, ...]
    cleared: Mapping[SlotId, Reason]


@dataclass(frozen=True)
class Decisions:
    """The decisions of a model, and the evaluation of its rules in states."""

    model: Model

    @cached_property
    def questions(self) -> dict[str, tuple[Rule, ...]]:
        """The rules in question by request."""
        return in_question(self.model)

    def decide(self, state: State, request: Request, args: Args) -> Decision:
        """Return what is done with the newcomer `request(args)` in this state."""
        newcomer = self.newcomer(state, request, args)
        if newcomer is None:
            return Decision("reject", BUSY)
        cleared, demands = newcomer.cleared, self._demands(newcomer, request, args)
        kills = tuple((slot, reason) for slot, reason in cleared.items() if state.phase(slot) == "running")
        for verdict, reason in _objections(cleared, demands):
            return Decision(verdict, reason, kills if verdict == "clear" else ())
        dismissed = tuple((verdict.request, reason) for verdict, reason in demands if isinstance(verdict, Dismiss))
        return Decision("launch", dismissed=dismissed)

    def objections(self, state: State, request: Request, args: Args) -> tuple[Objection, ...]:
        """Return all that keeps the newcomer from a launch in this state: a verdict and its reason each, the decisive
        one first; nothing iff it is launched, and only that it is busy if it is.
        """
        newcomer = self.newcomer(state, request, args)
        if newcomer is None:
            return (("reject", BUSY),)
        return tuple(_objections(newcomer.cleared, self._demands(newcomer, request, args)))

    def newcomer(self, state: State, request: Request, args: Args, every: bool = False) -> NewcomerStates | None:
        """Return the newcomer `request(args)` as it would be launched in this state; None iff the request is busy.

        It is asked about the rules that are `possible`, or about `every` rule in question.
        """
        idle = [index for index, slot in enumerate(state.slots[request.name]) if slot is None]
        if not idle and not request.interrupts_self:
            return None
        index = idle[0] if idle else request.instances
        launched = self.launching(state, request, args, index)
        slot = (request.name, index)
        asked = self.questions[request.name] if every else self.possible(state, request)
        questions = tuple(i for rule in asked for i in self.instances(launched, rule))
        return NewcomerStates(state, launched, slot, questions, self.clear(launched, slot, questions))

    def clear(self, launched: State, newcomer: SlotId, questions: Sequence[Instance]) -> dict[SlotId, Reason]:
        """Return C: the slots to clear, in the order in which they were found, each with the rule that put it there."""
        cleared: dict[SlotId, Reason] = {}
        for instance in questions:
            kills = list(kills_first(instance.rule.remedies))
            if not kills:
                continue
            state = launched.idle(cleared)
            if not self.true_either_way(state, instance):
                continue
            for remedy in kills:
                others = [slot for slot in self.targets(state, remedy, instance) if slot != newcomer]
                if not self.true_either_way(state.idle(others), instance):
                    for slot in others:
                        cleared.setdefault(slot, instance.reason)
                    break
        return cleared

    def _demands(self, newcomer: NewcomerStates, request: Request, args: Args) -> "list[tuple[str | Dismiss, Reason]]":
        """Return the demands in the order of the text, all with the slots to clear taken as idle."""
        scope = Scope(bind(request.params, args))
        present = newcomer.state.idle(newcomer.cleared)
        launched = newcomer.launched.idle(newcomer.cleared)
        found: list[tuple[int, str | Dismiss, Reason]] = []
        for guard in request.guards:
            if not holds(self.model, present, guard.condition, scope):
                found.append((guard.place, guard.objection, Reason(guard.name, guard.because)))
        for consumption in self._shortages(newcomer.state, request, scope):
            resource = self.model.resource[consumption.resource]
            reason = Reason(resource.name, self.model.text(consumption))
            found.append((consumption.place, verdict_without_kill(resource.remedies), reason))
        for instance in newcomer.questions:
            demands = self.rule_demands(launched, newcomer.slot, instance)
            found += [(instance.rule.place, verdict, instance.reason) for verdict in demands]
        found.sort(key=lambda demand: demand[0])
        return [(verdict, reason) for _, verdict, reason in found]

    def _shortages(self, state: State, request: Request, scope: Scope) -> list[Consumption]:
        """Return, for each resource of which the newcomer consumes more than its level, its first clause that counts.

        A clause counts iff its `when` holds.
        """
        return [
            clauses[0]
            for resource, clauses in self.consumed(state, request, scope).items()
            if sum(clause.amount for clause in clauses) > state.levels[resource]
        ]

    def consumed(self, state: State, request: Request, scope: Scope) -> dict[str, list[Consumption]]:
        """Return, for each resource that a newcomer consumes, its clauses that count, in the order of the text."""
        counting: dict[str, list[Consumption]] = {}
        for consumption in request.consumptions:
            if applies(self.model, state, consumption.when, scope):
                counting.setdefault(consumption.resource, []).append(consumption)
        return counting

    def rule_demands(self, launched: State, newcomer: SlotId, instance: Instance) -> "list[str | Dismiss]":
        """Return what a rule in question demands for the newcomer: a verdict, requests to dismiss, or nothing."""
        remedies = instance.rule.remedies
        if self.true_either_way(launched, instance):
            return [verdict_without_kill(remedies)]
        name = newcomer[0]
        if name not in killed(instance.rule):
            return []
        if not self.true_either_way(self.with_clearing(launched, name), instance):
            return []
        for remedy in remedies:
            if isinstance(remedy, Reject | Wait):
                return [verdict_without_kill((remedy,))]
            spared = [other for other in killed_requests(remedy, instance.rule) if other != name]
            slots = self.targets(launched, remedy, instance)
            without = launched.idle(slot for slot in slots if slot != newcomer)
            if not self.true_either_way(self.with_clearing(without, name, spared), instance):
                return [Dismiss(other) for other in spared]
        return ["reject"]

    def with_clearing(self, state: State, newcomer: str, without: list[str] | None = None) -> State:
        """Return the state in which the requests that are clearing, but for the newcomer's and `without`, run too."""
        for name, place in state.places.items():
            if place and place.clearing and name != newcomer and name not in (without or ()):
                state = state.with_slot((name, len(state.slots[name])), Slot("running", place.args))
        return state

    def launching(self, state: State, request: Request, args: Args, index: int) -> State:
        """Return the state with the request running in slot `index`, and `on launch` and `consumes` applied."""
        scope = Scope(bind(request.params, args))
        for consumption in request.consumptions:
            if applies(self.model, state, consumption.when, scope):
                level = state.levels[consumption.resource] - consumption.amount
                state = state.with_level(consumption.resource, level)
        state = state.with_slot((request.name, index), Slot("running", args))
        return affect(state, request.on_launch)

    # ---- rules ----

    @cached_property
    def _of_states(self) -> RulesByNeed:
        return RulesByNeed(self.model.rules, [rule_needs(rule, self.model) for rule in self.model.rules])

    @cached_property
    def _of_newcomers(self) -> dict[str, RulesByNeed]:
        """The rules in question by request, of those that were asked for so far; the request itself is active."""
        return {}

    def rules(self, state: State) -> list[Rule]:
        """Return the rules in order, without those whose F is false because no request that it needs is active."""
        return self._of_states.possible({name for name, _ in state.held})

    def possible(self, state: State, request: Request) -> list[Rule]:
        """Return the rules in question in order, without those whose F is false once the request is launched, be what
        is clearing active or not, because no request that it needs is active.
        """
        name = request.name
        if name not in self._of_newcomers:
            rules = self.questions[name]
            needed = [tuple(each for each in rule_needs(rule, self.model) if name not in each) for rule in rules]
            self._of_newcomers[name] = RulesByNeed(rules, needed)
        clearing = {other for other, place in state.places.items() if place and place.clearing}
        return self._of_newcomers[name].possible({other for other, _ in state.held} | clearing)

    def instances(self, state: State, rule: Rule) -> list[Instance]:
        """Return the rule, or, if it stands for each slot of a request, its copies for the active slots in order."""
        if rule.slot_of is None:
            return [Instance(rule)]
        return [Instance(rule, slot) for slot in state.active([rule.slot_of])]

    def true(self, state: State, instance: Instance) -> bool:
        """Return whether the F of a rule holds; that of a copy is false if its slot is idle."""
        scope = NOTHING
        if instance.slot:
            name, index = instance.slot
            slot = state.slots[name][index]
            if slot is None:
                return False
            scope = Scope(bind(self.model.request[name].params, slot.args))
        return holds(self.model, state, instance.rule.condition, scope)

    def true_either_way(self, state: State, instance: Instance) -> bool:
        """Return whether F holds with the stopping slots as they are, or with them taken as idle."""
        if self.true(state, instance):
            return True
        stopped = state.once_stopped()
        return stopped is not state and self.true(stopped, instance)

    def targets(self, state: State, kill: KillRemedy, instance: Instance) -> list[SlotId]:
        """Return the active slots that a kill names, in order."""
        match kill:
            case Kill(requests):
                return state.active(requests)
            case KillSlot():
                return [instance.slot] if instance.slot else []
            case _:
                assert_never(kill)


@dataclass(frozen=True, slots=True)
class Dismiss:
    """The demand that what is in this request's waiting place is rejected if the newcomer is launched."""

    request: str


def _objections(cleared: Mapping[SlotId, Reason], demands: "list[tuple[str | Dismiss, Reason]]") -> Iterator[Objection]:
    """Yield what keeps a newcomer from a launch, the decisive first: demands to reject, demands to wait, what is to be
    cleared, demands to settle.
    """
    yield from (("reject", reason) for verdict, reason in demands if verdict == "reject")
    yield from (("wait", reason) for verdict, reason in demands if verdict == "wait")
    yield from (("clear", reason) for reason in cleared.values())
    yield from (("settle", reason) for verdict, reason in demands if verdict == "settle")


def kills_first(remedies: tuple[Remedy, ...]) -> Iterator[KillRemedy]:
    """Yield the kills that stand before the first remedy that is none."""
    for remedy in remedies:
        if isinstance(remedy, Reject | Wait):
            return
        yield remedy


def verdict_without_kill(remedies: tuple[Remedy, ...]) -> Literal["reject", "wait"]:
    """Return the verdict of the first remedy that is no kill; without one, `reject`."""
    for remedy in remedies:
        if isinstance(remedy, Reject | Wait):
            return "reject" if isinstance(remedy, Reject) else "wait"
    return "reject"


def affect(state: State, effects: tuple[Effect, ...]) -> State:
    """Return the state after the effects of `on` clauses, applied in order."""
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
