"""What keeps a request from a launch in a state, and what would have to come first and cannot.

A rule that decides is one cause; that what would mend it cannot happen either is the next. Whether a change mends it is
asked of the reference interpreter: it does if the rule no longer decides once the change is made (a counterfactual
cause, Halpern, Pearl 2005).
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
"""So many arguments are tried of a request beside the least."""
ENOUGH = 5
"""So often a rule has to stand alone in the way to be believed to be what stays."""


@dataclass(frozen=True, slots=True)
class Blocked:
    """A request that cannot start in a state with these arguments, and the reason; `waits`: it stands in its place."""

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
    """Finds what keeps requests from launches. Only steps are looked at after which the assumptions are true."""

    reference: Reference
    without: WithoutRules
    assumptions: Sequence[Assumption]
    is_late: Callable[[], bool] = lambda: False
    _lasting: dict[tuple[object, str], State | None] = field(default_factory=dict)

    def blocked(self, state: State, name: str) -> Blocked | None:
        """Return what keeps a request from a launch, with what waits, or else its least arguments; None if nothing does
        with some arguments that are tried.
        """
        request, place = self.reference.model.request[name], state.places[name]
        if place:
            return self._decided(state, request, place.args, waits=True)
        found = (self._decided(state, request, args, waits=False) for args in _tried(request))
        first = next(found)
        return None if first is None or None in found else first

    def launchable(self, state: State, name: str) -> list[Args]:
        """Return arguments that are tried with which nothing keeps a request that is asked from a launch."""
        request = self.reference.model.request[name]
        return [args for args in _tried(request) if self._decided(state, request, args, waits=False) is None]

    def refusal(self, state: State, launch: Launch) -> Blocked | None:
        """Return what the last step refused a required launch for; None if it did not."""
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
        """Return a state that random runs come to from one, where a rule stands alone in the way of a request, or none.

        If some state has no rule in its way, it is the first such, else the first of the rule that stands alone most
        often; None if there is neither, or it is late.
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
        """Return the assumption that forbids the ask of a request that nothing else keeps from a launch; None if there
        are arguments with which none does.
        """
        forbids = [(args, self._asked(state, name, args).forbids) for args in self.launchable(state, name)]
        if not forbids or not all(broken for _, broken in forbids):
            return None
        args, broken = forbids[0]
        return Forbidden(self.reference.model.request[name], args, broken[0])

    def _asked(self, state: State, name: str, args: Args) -> Tried:
        return Tried(self.reference, self.assumptions, state, Ask(name, args))

    def stays(self, state: State, name: str) -> tuple[State, Blocked | Forbidden | None]:
        """Return what keeps a request from a launch whatever is mended, and a state in which it does: by what the
        request waits, else the rule that stands alone in its way, or the assumption; None if there is nothing.
        """
        now = self.blocked(state, name)
        if now is not None and now.waits:
            return state, now
        later = self.lasting(state, name) or state
        last = self.blocked(later, name) or self.forbidden(later, name)
        return (later, last) if last is not None else (state, now)

    def chain(self, state: State, name: str) -> Iterator[tuple[State, Blocked | Forbidden | Launch]]:
        """Yield what keeps a request from a launch, then of what would mend that what cannot start either, those that
        wait first, and launch rules that require again what it is held up by; each with the state in which that is so.
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
        """Return whether a request would not be blocked in a state for the reason for which it is."""
        return self.reference.decide(state, link.request, link.args).reason != link.reason

    def is_so(self, link: Blocked | Forbidden, state: State) -> bool:
        """Return whether in a state, too, a request is blocked for this reason, or its launch forbidden."""
        if isinstance(link, Blocked):
            return not self.is_mended(link, state)
        step = self._asked(state, link.request.name, link.args)
        return step.launches(link.request.name) and link.assumption in step.forbids

    def is_alone(self, link: Blocked, state: State) -> bool:
        """Return whether an ask of the request would be launched, and is not forbidden, but for the rule alone."""
        ask = Ask(link.request.name, link.args)
        launch = self.without.launch(self.assumptions, state, ask, link.reason.rule)
        return launch is not None and not launch.forbids

    def _is_let_go(self, launch: Launch, state: State) -> bool:
        """Return whether a launch rule requires nothing in a state."""
        return not holds(self.reference.model, state, launch.condition)

    def _mends(self, state: State, each: Request, read: set[Read], is_mended: Callable[[State], bool]) -> bool:
        """Return whether a request that starts or ends changes what is read so that something is mended."""
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
    """Yield the least arguments of a request, and some others."""
    random = Random(0)
    yield least_arguments(request)
    yield from (arguments(request, random) for _ in range(TRIED if request.params else 0))


def reason_reads(model: Model, state: State, request: Request, reason: Reason) -> Sequence[Read]:
    """Return what the guard or the consumption of a reason reads, or the rule, but for requests that would be in the
    way and are idle; of a resource who uses it. A busy request is active or waits itself.
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
    """Yield the requests that may be in the way by being active: those that have to end for a guard or a rule to let a
    request pass, and itself if it is busy.
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
