"""Causes that keep a request from a launch in a state, and causes of these causes.

The first cause is the rule that decides. The next is what keeps those requests from a launch that would mend it. The
reference interpreter tells whether a change mends it: it does iff the rule no longer decides after the change (a
counterfactual cause, Halpern, Pearl 2005).
"""

from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import field, replace
from functools import partial
from random import Random

from exover.checks.causes.near_events import arguments, least_arguments, onward
from exover.checks.causes.shadowing import Tried, WithoutRules
from exover.dataclass import dataclass
from exover.model.decision import BUSY, Reason
from exover.model.evaluate import holds
from exover.model.event import Args, Ask
from exover.model.expression import And, Compare, Cond, Count, Not, Or, Status, Used, operands
from exover.model.model import Effect, Forget, Launch, Model, Request, SetState
from exover.model.property import Assumption
from exover.model.reads import Read, reads, rule_reads, users
from exover.model.semantics import Reference
from exover.model.state import State

TRIED = 4
"""The number of random arguments of a request that are tried besides the least."""
ENOUGH = 5
"""The number of states in which a rule is the only obstacle after which it is taken for the lasting one."""


@dataclass(frozen=True, slots=True)
class Blocked:
    """A request that cannot start in a state with these arguments, and the reason.

    `waits`: it is in its waiting place; `refused`: it is rejected, not made to wait.
    """

    request: Request
    args: Args
    reason: Reason
    waits: bool
    refused: bool


@dataclass(frozen=True, slots=True)
class Forbidden:
    """A request whose ask with these arguments would be launched in a state, but an assumption forbids the step."""

    request: Request
    args: Args
    assumption: Assumption


@dataclass
class Obstacles:
    """Finds what keeps requests from launches; random runs take only steps after which the assumptions are true."""

    reference: Reference
    without: WithoutRules
    assumptions: Sequence[Assumption]
    is_late: Callable[[], bool] = lambda: False
    _lasting: dict[tuple[object, str], State | None] = field(default_factory=dict)

    def blocked(self, state: State, name: str) -> Blocked | None:
        """Return what keeps a request from a launch: with the waiting arguments if it waits, else with the least.

        None if it would be launched, with some of the tried arguments if it does not wait.
        """
        request, place = self.reference.model.request[name], state.places[name]
        if place:
            return self._decided(state, request, place.args, waits=True)
        found = (self._decided(state, request, args, waits=False) for args in _tried(request))
        first = next(found)
        return None if first is None or None in found else first

    def launchable(self, state: State, name: str) -> list[Args]:
        """Return those of the tried arguments with which an ask of the request would be launched."""
        request = self.reference.model.request[name]
        return [args for args in _tried(request) if self._decided(state, request, args, waits=False) is None]

    def refusal(self, state: State, launch: Launch) -> Blocked | None:
        """Return for what the last step refused a required launch; None if it did not."""
        model, rule = self.reference.model, state.refused.get(launch.name)
        if rule is None:
            return None
        request = model.request[launch.request]
        texts = model.texts | {clause.resource: model.text(clause) for clause in reversed(request.consumptions)}
        return Blocked(request, launch.args, Reason(rule, texts.get(rule)), waits=False, refused=True)

    def _decided(self, state: State, request: Request, args: Args, waits: bool) -> Blocked | None:
        decision = self.reference.decide(state, request, args)
        if decision.reason is None:
            return None
        return Blocked(request, args, decision.reason, waits, decision.verdict == "reject")

    def lasting(self, state: State, name: str) -> State | None:
        """Return a state on random runs from `state` in which at most one rule is in the way of a launch.

        The first state without any; else the first of the rule that is most often the only obstacle; None if there is
        neither, or if it `is_late`.
        """
        key = state.key(), name
        if key not in self._lasting and not self.is_late():
            self._lasting[key] = self._found_lasting(state, name)
        return self._lasting.get(key)

    def _found_lasting(self, begun: State, name: str) -> State | None:
        alone, first, seen = Counter[str](), dict[str, State](), set[object]()
        model = self.reference.model
        read = {each.name for guard in model.request[name].guards for each in reads(guard.condition)}
        often = [each for each in model.requests if each.name in read]
        for state in onward(self.reference, begun, self.assumptions, often):
            key = state.key()
            if key in seen:
                continue
            seen.add(key)
            found = self.blocked(state, name)
            if found is None:
                return state
            if found.reason == BUSY:
                continue
            rule = found.reason.rule
            if self.is_alone(found, state):
                alone[rule] += 1
                first.setdefault(rule, state)
                if alone[rule] >= ENOUGH:
                    break
        return first[alone.most_common(1)[0][0]] if alone else None

    def forbidden(self, state: State, name: str) -> Forbidden | None:
        """Return the assumption that forbids the ask of a request that would be launched; None if with some of the
        tried arguments no assumption does, or if with none of them it would be launched.
        """
        forbids = [(args, self._asked(state, name, args).forbids) for args in self.launchable(state, name)]
        if not forbids or not all(broken for _, broken in forbids):
            return None
        args, broken = forbids[0]
        return Forbidden(self.reference.model.request[name], args, broken[0])

    def _asked(self, state: State, name: str, args: Args) -> Tried:
        return Tried(self.reference, self.assumptions, state, Ask(name, args))

    def stays(self, state: State, name: str) -> tuple[State, Blocked | Forbidden | None]:
        """Return the lasting obstacle of a launch, and a state in which it is one: what the request waits by, else the
        rule that is the only obstacle (`lasting`), else the assumption; None if there is nothing.
        """
        now = self.blocked(state, name)
        if now is not None and now.waits:
            return state, now
        later = self.lasting(state, name) or state
        last = self.blocked(later, name) or self.forbidden(later, name)
        return (later, last) if last is not None else (state, now)

    def chain(self, state: State, name: str) -> Iterator[tuple[State, Blocked | Forbidden | Launch]]:
        """Yield the causes that keep a request from a launch, breadth first, each with a state in which it is one.

        After a rule come the launch rules that launch again what holds the request up, and the requests that would mend
        it but cannot start either, waiting ones first.
        """
        model = self.reference.model
        told, left = {name}, deque([(state, name)])
        while left:
            there, link = self.stays(*left.popleft())
            if link is not None:
                yield there, link
            if not isinstance(link, Blocked):
                continue
            read = set(reason_reads(model, there, link.request, link.reason))
            hinders = set(_hindering(model, link.request, link.reason))
            again = [each for each in model.launches if each.request in hinders and each.name not in told]
            again = [each for each in again if there.active([each.request]) and holds(model, there, each.condition)]
            for launch in again:
                told.add(launch.name)
                yield there, launch
            wanted = [(read, partial(self.is_mended, link))]
            wanted += [(set(reads(each.condition)), partial(self._is_let_go, each)) for each in again]
            found = []
            for each in model.requests:
                idle = each.name not in told and not there.active([each.name])
                mends = idle and any(self._mends(there, each, read, is_mended) for read, is_mended in wanted)
                other = (self.blocked(there, each.name) or self.forbidden(there, each.name)) if mends else None
                if other is not None:
                    told.add(each.name)
                    found.append(other)
            found.sort(key=lambda each: not (isinstance(each, Blocked) and each.waits))
            left += [(there, each.request.name) for each in found]

    def is_mended(self, link: Blocked, state: State) -> bool:
        """Return whether in this state the decision on the request no longer has the reason of the link."""
        return self.reference.decide(state, link.request, link.args).reason != link.reason

    def is_so(self, link: Blocked | Forbidden, state: State) -> bool:
        """Return whether the link is one in this state as well: blocked for this reason, or its launch forbidden."""
        if isinstance(link, Blocked):
            return not self.is_mended(link, state)
        step = self._asked(state, link.request.name, link.args)
        return step.launches(link.request.name) and link.assumption in step.forbids

    def is_alone(self, link: Blocked, state: State) -> bool:
        """Return whether the rule is the only obstacle: without it an ask would be launched and not be forbidden."""
        ask = Ask(link.request.name, link.args)
        launch = self.without.launch(self.assumptions, state, ask, link.reason.rule)
        return launch is not None and not launch.forbids

    def _is_let_go(self, launch: Launch, state: State) -> bool:
        """Return whether the condition of a launch rule is false in a state."""
        return not holds(self.reference.model, state, launch.condition)

    def _mends(self, state: State, each: Request, read: set[Read], is_mended: Callable[[State], bool]) -> bool:
        """Return whether the start or end of a request changes something that is `read` so that a cause is mended."""
        name = each.name
        if any(other.name == name and other.kind in ("active", "waiting", "past", "last") for other in read):
            return True
        if any(other.kind == "level" and other.name == share.resource for other in read for share in each.productions):
            return True
        named = {other.name for other in read if other.kind in ("reading", "past")}
        changed = [_changed(state, effect) for effect in each.effects if named.intersection(_names(effect))]
        changed += [
            state.with_reading(latch.name, value=False)
            for latch in self.reference.model.latches
            if name in latch.resets and latch.name in named
        ]
        return any(map(is_mended, changed))


def _tried(request: Request) -> Iterator[Args]:
    """Yield the least arguments of a request, then `TRIED` random ones."""
    random = Random(0)
    yield least_arguments(request)
    yield from (arguments(request, random) for _ in range(TRIED if request.params else 0))


def reason_reads(model: Model, state: State, request: Request, reason: Reason) -> Sequence[Read]:
    """Return what the guard, rule or consumption of a reason reads, without idle requests that could hinder.

    Of a resource, who uses it; if the reason is that the request is busy, whether it is active or waits.
    """
    read: dict[Read, None] = {}
    if reason == BUSY:
        read[Read("active" if state.active([request.name]) else "waiting", request.name)] = None
    for guard in request.guards:
        if guard.name == reason.rule:
            read |= dict.fromkeys(sorted(reads(guard.condition)))
    idle = {name for name in _hindering(model, request, reason) if not state.active([name])}
    for each in (each for rule in model.rules if rule.name == reason.rule for each in sorted(rule_reads(rule))):
        holders = [Read("active", name) for name in users(model, each.name)] if each.kind == "used" else [each]
        read |= dict.fromkeys(each for each in holders if each.kind != "active" or each.name not in idle)
    if any(clause.resource == reason.rule for clause in request.consumptions):
        read[Read("level", reason.rule)] = None
    return tuple(read)


def _hindering(model: Model, request: Request, reason: Reason) -> Iterator[str]:
    """Yield the requests that may hinder by being active: those that have to end before a guard or rule lets the
    request pass, and the request itself if it is busy.
    """
    if reason == BUSY:
        yield request.name
    for guard in request.guards:
        if guard.name == reason.rule:
            yield from _made_by(model, guard.condition, truth=False)
    for rule in model.rules:
        if rule.name == reason.rule:
            yield from _made_by(model, rule.condition, truth=True)
            yield from (rule.slot_of,) if rule.slot_of else ()


def _made_by(model: Model, condition: Cond, truth: bool) -> Iterator[str]:
    """Yield the requests that may make a condition true, or else false, by being active."""
    match condition:
        case Status("active" | "running" | "stopping", request) if truth:
            yield request
        case Not(part):
            yield from _made_by(model, part, not truth)
        case And(parts) | Or(parts):
            for part in parts:
                yield from _made_by(model, part, truth)
        case Compare():
            for term in operands(condition):
                match term:
                    case Count(requests):
                        yield from requests
                    case Used(resource):
                        yield from users(model, resource)
        case _:
            pass


def _names(effect: Effect) -> tuple[str, ...]:
    return (effect.state,) if isinstance(effect, SetState) else effect.requests


def _changed(state: State, effect: Effect) -> State:
    match effect:
        case SetState(name, value):
            return state.with_reading(name, value)
        case Forget(requests):
            return replace(state, past={**state.past, **dict.fromkeys(requests)})
