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
from typing import Literal

from exover.checks.causes.hindrances import changed, hindering, made_by, reason_reads, settings, touches
from exover.checks.causes.near_events import arguments, least_arguments, observations, onward, reports
from exover.checks.causes.property_detail import conditions
from exover.checks.causes.shadowing import Tried, WithoutRules, forbid_each
from exover.checks.causes.toward import toward
from exover.dataclass import dataclass
from exover.model.decision import BUSY, Reason
from exover.model.evaluate import holds
from exover.model.event import Args, Ask, Event
from exover.model.expression import Cond
from exover.model.model import Launch, Request
from exover.model.property import Assumption
from exover.model.reads import Read, reads
from exover.model.semantics import Reference
from exover.model.state import SlotId, State

TRIED = 4
"""The number of random arguments of a request that are tried besides the least."""
ENOUGH = 5
"""The number of states in which a rule is the only obstacle after which it is taken for the lasting one."""
BUSIER = 100
"""The number of obstacles for which it counts that all slots are taken: what else is in the way is not seen then."""


Mending = tuple[set[Read], Callable[[State], bool]]
"""What may be changed to mend something, and whether it is mended in a state."""
Rank = Literal["decides", "first", "besides"]
"""Of a reason: that it decides; that it decides first, but not for ever, and others would decide then; or that others
decide first, but not for ever."""


@dataclass(frozen=True, slots=True)
class Blocked:
    """A request that cannot start in a state with these arguments, and the reason.

    `waits`: it is in its waiting place; `refused`: it is rejected, not made to wait. `rank`: whether the reason decides
    and lasts, as far as it is known.
    """

    request: Request
    args: Args
    reason: Reason
    waits: bool
    refused: bool
    rank: Rank = "decides"


@dataclass(frozen=True, slots=True)
class Forbidden:
    """A request whose ask with these arguments would be launched in a state, but an assumption forbids the step."""

    request: Request
    args: Args
    assumption: Assumption


@dataclass(frozen=True, slots=True)
class Unended:
    """A request that is active in a state in which an assumption forbids each report of it."""

    request: Request
    assumption: Assumption


Link = Blocked | Forbidden | Unended | Launch
"""A cause in a chain of causes."""


@dataclass
class Obstacles:
    """Finds what keeps requests from launches; random runs take only steps after which the assumptions are true."""

    reference: Reference
    without: WithoutRules
    assumptions: Sequence[Assumption]
    is_late: Callable[[], bool] = lambda: False
    _lasting: dict[tuple[object, str], tuple[State, Blocked | None]] = field(default_factory=dict)
    _broken: dict[object, list[tuple[Assumption, ...]]] = field(default_factory=dict)

    def blocked(self, state: State, name: str) -> Blocked | None:
        """Return what keeps a request from a launch: with the waiting arguments if it waits, else with those that leave
        the fewest obstacles of the tried ones, the first of these. None if it would be launched.
        """
        return next(iter(self.objections(state, name)), None)

    def objections(self, state: State, name: str) -> tuple[Blocked, ...]:
        """Return all that keeps a request from a launch, with the arguments of `blocked`, the decisive one first."""
        request, place = self.reference.model.request[name], state.places[name]
        if place:
            return self._objections(state, request, place.args, waits=True)
        return min((self._objections(state, request, args, waits=False) for args in _tried(request)), key=len)

    def launchable(self, state: State, name: str) -> list[Args]:
        """Return those of the tried arguments with which an ask of the request would be launched."""
        request = self.reference.model.request[name]
        return [args for args in _tried(request) if not self._objections(state, request, args, waits=False)]

    def refusal(self, state: State, launch: Launch) -> Blocked | None:
        """Return for what the last step refused a required launch; None if it did not."""
        model, rule = self.reference.model, state.refused.get(launch.name)
        if rule is None:
            return None
        request = model.request[launch.request]
        texts = model.texts | {clause.resource: model.text(clause) for clause in reversed(request.consumptions)}
        return Blocked(request, launch.args, Reason(rule, texts.get(rule)), waits=False, refused=True)

    def _objections(self, state: State, request: Request, args: Args, waits: bool) -> tuple[Blocked, ...]:
        found = self.reference.objections(state, request, args)
        return tuple(Blocked(request, args, reason, waits, verdict == "reject") for verdict, reason in found)

    def lasting(self, state: State, name: str) -> tuple[State, Blocked | None]:
        """Return the rule that keeps a request from a launch from `state` on, as runs from there show it
        (`_found_lasting`), and a state in which it does; once it `is_late`, the rule that decides in `state`.
        """
        key = state.key(), name
        if key not in self._lasting and not self.is_late():
            self._lasting[key] = self._found_lasting(state, name)
        return self._lasting.get(key, (state, self.blocked(state, name)))

    def _found_lasting(self, begun: State, name: str) -> tuple[State, Blocked | None]:
        """Return the first of these that runs from a state show, with a state in which it is so: that nothing is in the
        way; the rule that is most often the only obstacle, of those that always are one if there are such; the first
        obstacle that is always one; else what decides first. Where all slots are taken, only that is seen.
        """
        alone, first = Counter[str](), dict[str, tuple[State, Blocked]]()
        there, at_first, steady = begun, self.objections(begun, name), set[Reason]()
        for state, found in self._later(begun, name):
            if not found:
                return state, None
            if found[0].reason == BUSY:
                continue
            reasons = {each.reason for each in found}
            if at_first[0].reason == BUSY:
                there, at_first = state, found
            steady = steady & reasons if steady or state is not there else reasons
            rule = found[0].reason.rule
            if all(each.rule == rule for each in reasons) and self.is_alone(found[0], state):
                alone[rule] += 1
                first.setdefault(rule, (state, found[0]))
                if alone[rule] >= ENOUGH:
                    break
        if alone:
            lasting = {each.rule for each in steady}
            return first[max(alone, key=lambda rule: (rule in lasting, alone[rule]))]
        if at_first[0].reason == BUSY or at_first[0].reason in steady:
            return there, at_first[0]
        last = next((each for each in at_first if each.reason in steady), None)
        return there, replace(last, rank="besides") if last else replace(at_first[0], rank="first")

    def _later(self, begun: State, name: str) -> Iterator[tuple[State, tuple[Blocked, ...]]]:
        """Yield a state and different ones on runs from it, each with what keeps the request from a launch there."""
        request, known = self.reference.model.request[name], dict[object, tuple[Blocked, ...]]()

        def found(state: State) -> tuple[Blocked, ...]:
            key = state.key()
            if key not in known:
                known[key] = self.objections(state, name)
            return known[key]

        def obstacles(state: State) -> int:
            return len(found(state)) + BUSIER * (found(state)[0].reason == BUSY if found(state) else 0)

        for state in toward(self.reference, begun, self.assumptions, request, obstacles):
            yield state, found(state)
        read = {each.name for guard in request.guards for each in reads(guard.condition)}
        often = [each for each in self.reference.model.requests if each.name in read]
        for state in onward(self.reference, begun, self.assumptions, often):
            if state.key() not in known:
                yield state, found(state)

    def forbidden(self, state: State, name: str) -> Forbidden | None:
        """Return the assumption that forbids the ask of a request that would be launched; None if with some of the
        tried arguments no assumption does, or if with none of them it would be launched.
        """
        forbids = [(args, self._asked(state, name, args).forbids) for args in self.launchable(state, name)]
        if not forbids or not all(broken for _, broken in forbids):
            return None
        args, broken = forbids[0]
        return Forbidden(self.reference.model.request[name], args, broken[0])

    def least_broken(self, state: State) -> list[tuple[Assumption, ...]]:
        """Return what steps from a state break of the assumptions, of those tried that break the fewest, in order."""
        key = state.key()
        if key not in self._broken:
            tried = (Tried(self.reference, self.assumptions, state, event) for event in self._events(state))
            found = list(dict.fromkeys(each.forbids for each in tried))
            fewest = min(map(len, found), default=0)
            ranked = sorted(found, key=lambda broken: [self.assumptions.index(each) for each in broken])
            self._broken[key] = [each for each in ranked if len(each) == fewest]
        return self._broken[key]

    def _events(self, state: State) -> Iterator[Event]:
        """Yield an ask of each request, reports of what is active, and observations near all constants."""
        model = self.reference.model
        yield from observations(model, (each for assumed in self.assumptions for each in conditions(assumed.formula)))
        yield from reports(model, state, Random(0))
        yield from (Ask(each.name, args) for each in model.requests for args in _tried(each))

    def _asked(self, state: State, name: str, args: Args) -> Tried:
        return Tried(self.reference, self.assumptions, state, Ask(name, args))

    def stays(self, state: State, name: str) -> tuple[State, Blocked | Forbidden | None]:
        """Return the lasting obstacle of a launch, and a state in which it is one: the rule that is (`lasting`), else
        the assumption, else what decides in `state`; None if there is nothing.
        """
        later, last = self._stays(state, name)
        return (later, last) if last is not None else (state, self.blocked(state, name))

    def _stays(self, state: State, name: str) -> tuple[State, Blocked | Forbidden | None]:
        """Return the lasting obstacle of a launch, as `stays`; None if a run comes to where it would be launched."""
        if state.places[name] and len(waits_by := self.objections(state, name)) == 1:
            return state, waits_by[0]
        later, last = self.lasting(state, name)
        return later, last or self.forbidden(later, name)

    def chain(self, state: State, name: str) -> Iterator[tuple[State, Link]]:
        """Yield the causes that keep a request from a launch, breadth first, each with a state in which it is one.

        After a rule come the requests that hold the request up and that assumptions keep from ending, the launch rules
        that launch them again, and the requests that would mend it but cannot start either, waiting ones first.
        """
        there, link = self.stays(state, name)
        if link is not None:
            yield from self._links({name}, deque([(there, link)]))

    def missing(self, state: State, conditions: Sequence[Cond]) -> Iterator[tuple[State, Link]]:
        """Yield the causes that keep those requests from a launch that would make one of the conditions true, if it is
        false, and their causes, as `chain` does.
        """
        model = self.reference.model
        wanted: list[Mending] = []
        for each in conditions:
            if not holds(model, state, each):
                starting = set(made_by(model, each, truth=True))
                read = {one for one in reads(each) if one.kind != "active" or one.name in starting}
                wanted.append((read, partial(self._is_true, each)))
        told = set[str]()
        yield from self._links(told, deque(self._stuck(state, wanted, told)))

    def _links(self, told: set[str], left: deque[tuple[State, Blocked | Forbidden]]) -> Iterator[tuple[State, Link]]:
        """Yield links and their causes, breadth first, without launch rules and requests that are `told` already."""
        known = set[Unended]()
        while left:
            there, link = left.popleft()
            yield there, link
            if not isinstance(link, Blocked):
                continue
            endless = [each for each in self._unended(there, link) if each not in known]
            known.update(endless)
            yield from ((there, each) for each in endless)
            again = [each for each in self.requiring(there, link) if each.name not in told]
            told.update(each.name for each in again)
            yield from ((there, each) for each in again)
            read = set(reason_reads(self.reference.model, there, link.request, link.reason))
            wanted: list[Mending] = [(read, partial(self.is_mended, link))]
            wanted += [(set(reads(each.condition)), partial(self._is_let_go, each)) for each in again]
            left += self._stuck(there, wanted, told)

    def _stuck(
        self, there: State, wanted: Sequence[Mending], told: set[str]
    ) -> list[tuple[State, Blocked | Forbidden]]:
        """Return the lasting obstacles of the idle requests that would mend what is wanted, those of waiting ones
        first; the requests are added to those that are `told`.
        """
        found = []
        for each in self.reference.model.requests:
            idle = each.name not in told and not there.active([each.name])
            if not idle or not any(self._mends(there, each, read, is_mended) for read, is_mended in wanted):
                continue
            if self.blocked(there, each.name) or self.forbidden(there, each.name):
                later, last = self._stays(there, each.name)
                if last is not None:
                    told.add(each.name)
                    found.append((later, last))
        return sorted(found, key=lambda pair: not there.places[pair[1].request.name])

    def _unended(self, state: State, link: Blocked) -> Iterator[Unended]:
        """Yield the requests that hold the request up in a state and of a slot of which an assumption forbids each
        report that is tried.
        """
        hinders = set(hindering(self.reference.model, link.request, link.reason))
        steps = dict[SlotId, list[Tried]]()
        for report in reports(self.reference.model, state, Random(0)) if self.assumptions else ():
            if report.request in hinders:
                tried = Tried(self.reference, self.assumptions, state, report)
                steps.setdefault((report.request, report.slot), []).append(tried)
        for (name, _), ended in steps.items():
            yield from (Unended(self.reference.model.request[name], each) for each in forbid_each(ended)[:1])

    def requiring(self, state: State, link: Blocked) -> list[Launch]:
        """Return the launch rules that require in a state what is active there and holds the request up."""
        model = self.reference.model
        hinders = set(hindering(model, link.request, link.reason))
        again = [each for each in model.launches if each.request in hinders and state.active([each.request])]
        return [each for each in again if holds(model, state, each.condition)]

    def is_mended(self, link: Blocked, state: State) -> bool:
        """Return whether in this state the reason of the link is none to keep the request from a launch."""
        found = self.reference.objections(state, link.request, link.args)
        return link.reason not in (reason for _, reason in found)

    def is_so(self, link: Blocked | Forbidden, state: State) -> bool:
        """Return whether the link is one in this state as well: blocked for this reason, or its launch forbidden."""
        if isinstance(link, Blocked):
            return self.reference.decide(state, link.request, link.args).reason == link.reason
        step = self._asked(state, link.request.name, link.args)
        return step.launches(link.request.name) and link.assumption in step.forbids

    def is_alone(self, link: Blocked, state: State) -> bool:
        """Return whether the rule is the only obstacle: without it an ask would be launched and not be forbidden."""
        ask = Ask(link.request.name, link.args)
        launch = self.without.launch(self.assumptions, state, ask, link.reason.rule)
        return launch is not None and not launch.forbids

    def _is_true(self, condition: Cond, state: State) -> bool:
        return holds(self.reference.model, state, condition)

    def _is_let_go(self, launch: Launch, state: State) -> bool:
        """Return whether the condition of a launch rule is false in a state."""
        return not holds(self.reference.model, state, launch.condition)

    def _mends(self, state: State, each: Request, read: set[Read], is_mended: Callable[[State], bool]) -> bool:
        """Return whether the start or end of a request changes something that is `read` so that a cause is mended."""
        if touches(each, read, {share.resource for share in each.productions}):
            return True
        return any(is_mended(changed(state, setting)) for setting in settings(self.reference.model, each, read))


def _tried(request: Request) -> Iterator[Args]:
    """Yield the least arguments of a request, then `TRIED` random ones."""
    random = Random(0)
    yield least_arguments(request)
    yield from (arguments(request, random) for _ in range(TRIED if request.params else 0))
