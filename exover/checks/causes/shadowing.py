"""The rules that shadow a dead or redundant rule, and those that keep a request from any launch, found by steps near
runs.

Engines prove that a rule never acts. There are two causes: its condition is never met, or another rule always decides
first. The second is found in steps near runs: the rule acts if it is the only one, does not act beside all others, and
acts if one of them is taken out (a counterfactual cause, Halpern, Pearl 2005). The same is done for a request that is
never launched, but is once a rule is taken out. If the rule acts only in steps that assumptions forbid, these are the
cause, alone or together with the other rule. An assumption is the cause if it forbids each of these steps and, for a
dead rule, if the rule acts in some step that would be allowed without it.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import field, replace
from functools import cached_property
from random import Random

from exover.checks.causes.near_events import arguments, objecting, observations, onward, reports
from exover.checks.finding import Finding
from exover.dataclass import dataclass
from exover.model.decision import BUSY
from exover.model.event import Action, Ask, Event, Launched
from exover.model.expression import Cond
from exover.model.model import Model, Request, interruption
from exover.model.property import Assumption
from exover.model.reads import active_reads, in_question, reads
from exover.model.run_moments import is_true
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import Answers, visited

RULES, STATES, ASKS, ENOUGH, SEVERAL = 20, 40, 4, 12, 3
"""Limits: dead rules that are examined, states, asks of each request in each state, sightings that are enough, and
rules that decide in turn.
"""


@dataclass(frozen=True)
class WithoutRules:
    """Reference interpreters of a model without one of its rules, each made when it is first needed."""

    model: Model
    _made: dict[frozenset[str], Reference] = field(default_factory=dict)

    def __getitem__(self, rule: str) -> Reference:
        """Return the interpreter of the model without the rules, guards, consumptions and launches of this name."""
        return self.all_of([rule])

    def all_of(self, rules: Iterable[str]) -> Reference:
        """Return the interpreter of the model without those of any of these names."""
        names = frozenset(rules)
        if names not in self._made:
            self._made[names] = Reference(_cut(self.model, lambda name: name not in names))
        return self._made[names]

    def launch(self, assumptions: Sequence[Assumption], state: State, ask: Ask, rule: str) -> "Tried | None":
        """Return the step of an ask without the rule if the request is launched then, else None."""
        other = self[rule]
        if other.decide(state, other.model.request[ask.request], ask.args).verdict != "launch":
            return None
        return Tried(other, assumptions, state, ask)


@dataclass(frozen=True)
class Shadows:
    """Finds the rules that decide before dead rules; `states`: some reachable states, from which steps are tried."""

    reference: Reference
    without: WithoutRules
    states: Sequence[State]
    assumptions: Sequence[Assumption]
    _observed: dict[tuple[int, Event], "Tried"] = field(default_factory=dict)
    """Steps by the number of a state and an observation: each is tried once for all rules."""

    def of(self, name: str) -> "Shadowing":
        """Return the rules (or `busy`) that decide where a rule or guard would, the most frequent first.

        If there are none, the assumptions that forbid the steps in which it acts; if it is not seen to act either, the
        rules that decide in its place in steps that assumptions forbid.
        """
        alone = Reference(_cut(self.reference.model, name.__eq__))
        seen, beside, acts = Counter[str](), Counter[str](), list[Tried]()
        joint = Counter[tuple[str, ...]]()
        asked = in_question(alone.model)
        concerned = (each for each in alone.model.requests if each.guards or each.consumptions or asked[each.name])
        requests = list(concerned)
        for step in self._steps(alone.model, requests):
            if step.forbids and name in _rules(step.actions):
                acts.append(step)
            roomy = _roomy(step)
            if name not in _rules(alone.step(roomy.state, step.event)[1]):
                continue
            for other in dict.fromkeys(_rules(step.actions)):
                again = roomy if other == BUSY.rule else replace(step, reference=self.without[other])
                if name in _rules(again.actions) and (step.forbids or not again.forbids):
                    (beside if step.forbids else seen)[other] += 1
            if not seen and not step.forbids and joint.total() < ENOUGH and (several := self._several(step, name)):
                joint[several] += 1
            if seen.total() >= ENOUGH:
                break
        if seen:
            return Shadowing(_by_count(seen))
        if joint:
            return Shadowing(in_turn=joint.most_common(1)[0][0])
        if not acts:
            return Shadowing(unassumed=_by_count(beside))
        acts += (step for step in self._further(requests) if step.forbids and name in _rules(step.actions))
        return Shadowing(forbids=_alone_forbid(acts))

    def _several(self, step: "Tried", name: str) -> tuple[str, ...]:
        """Return two to `SEVERAL` rules without which a rule acts in a step: each decides without those before it; none
        if there are not so many, or a step without them is forbidden.
        """
        cut, again = list[str](), step
        while len(cut) < SEVERAL and name not in _rules(again.actions):
            other = next((each for each in _rules(again.actions) if each != BUSY.rule), None)
            if other is None:
                return ()
            cut.append(other)
            again = replace(step, reference=self.without.all_of(cut))
        return tuple(cut) if len(cut) > 1 and name in _rules(again.actions) and not again.forbids else ()

    def instead_of(self, name: str) -> tuple[str, ...]:
        """Return the rules that decide in the place of a rule once it is taken out, the most frequent first."""
        only, seen = _cut(self.reference.model, name.__eq__), Counter[str]()
        asked = in_question(only)
        requests = [each for each in only.requests if asked[each.name]]
        for number in self._nearest(only):
            found = dict[str, None]()
            for step in map(_unplaced, self._steps(only, requests, [number])):
                named = Counter(_rules(step.actions))
                if name in named and not step.forbids:
                    again = replace(step, reference=self.without[name])
                    found.update(dict.fromkeys(Counter(_rules(again.actions)) - named if not again.forbids else ()))
            seen.update(list(found))
            if seen.total() >= ENOUGH:
                break
        return _by_count(seen)

    def before_launch(self, name: str) -> "Shadowing":
        """Return the rules that keep a request from a launch where it is asked or waits, the most frequent first.

        `alone`: those that are the only obstacle in some step. If there are none, `forbids`: the assumptions that
        forbid every launch; then `alone` are rules without which a forbidden step would launch it.
        """
        model, seen, alone, beside = self.reference.model, Counter[str](), Counter[str](), Counter[str]()
        request, forbidden, forbidden_without = model.request[name], list[Tried](), list[Tried]()
        concerned = replace(model, requests=(request,), rules=self.reference.questions[name])
        for step in self._steps(concerned, [request]):
            if step.forbids and step.launches(name):
                forbidden.append(step)
            if not isinstance(step.event, Ask):
                continue
            place = step.state.places[name]
            args = place.args if place and not request.interrupts_self else step.event.args
            reason = self.reference.decide(step.state, request, args).reason
            if reason is not None and reason != BUSY and not step.forbids:
                seen[reason.rule] += 1
                if alone[reason.rule] < ENOUGH:
                    launch = self.without.launch(self.assumptions, step.state, Ask(name, args), reason.rule)
                    if launch is not None:
                        (beside if launch.forbids else alone)[reason.rule] += 1
                        forbidden_without += [launch] if launch.forbids else []
        rules = _by_count(seen)
        if alone.total():
            return Shadowing(rules, tuple(rule for rule in rules if alone[rule]))
        if forbidden:
            forbidden += (step for step in self._further([request]) if step.forbids and step.launches(name))
            return Shadowing(rules, forbids=forbid_each(forbidden))
        forbids = forbid_each(forbidden_without) if forbidden_without else None
        return Shadowing(rules, tuple(rule for rule in rules if beside[rule]), forbids)

    def _steps(
        self, only: Model, requests: Sequence[Request], numbers: Sequence[int] | None = None
    ) -> Iterator["Tried"]:
        """Yield steps from states: observations of what the rules of `only` read, and asks after each of them.

        `numbers`: those of the states, else those of some from everywhere.
        """
        random = Random(0)
        seen = list(observations(only, _latched(only)))
        for number in numbers or self._everywhere:
            state = self.states[number]
            for observation in (None, *seen):
                there = state
                if observation is not None:
                    fresh = Tried(self.reference, self.assumptions, state, observation)
                    tried = self._observed.setdefault((number, observation), fresh)
                    yield tried
                    if tried.forbids:
                        continue
                    there = tried.after
                yield from self._asks(there, requests, random)

    @property
    def _everywhere(self) -> Sequence[int]:
        """The numbers of about `STATES` states, as far apart from each other as there are states."""
        return range(0, len(self.states), -(-len(self.states) // STATES))

    def _nearest(self, only: Model) -> Sequence[int]:
        """Return numbers of states: first a few in which most requests are active of which the rules of `only` read
        that they are, or what they use; then some from everywhere.
        """
        read = sorted(active_reads(only, only.rules))
        nearest = sorted(range(len(self.states)), key=lambda number: -len(self.states[number].active(read)))
        return tuple(dict.fromkeys([*nearest[: STATES // 2], *self._everywhere]))

    def _further(self, requests: Sequence[Request]) -> Iterator["Tried"]:
        """Yield asks and reports in states of random runs, to tell two or more assumptions apart; else nothing."""
        random, seen = Random(0), set[object]()
        for state in onward(self.reference, self.reference.start(), self.assumptions) if self.assumptions[1:] else ():
            if state.key() not in seen:
                seen.add(state.key())
                yield from self._asks(state, requests, random)
                for report in reports(self.reference.model, state, random):
                    yield Tried(self.reference, self.assumptions, state, report)

    def _asks(self, state: State, requests: Sequence[Request], random: Random) -> Iterator["Tried"]:
        for request in requests:
            for args in dict.fromkeys(arguments(request, random) for _ in range(ASKS)):
                yield Tried(self.reference, self.assumptions, state, Ask(request.name, args))


@dataclass(frozen=True)
class Tried:
    """A step, which is computed when its outcome is first needed."""

    reference: Reference
    assumptions: Sequence[Assumption]
    state: State
    event: Event

    @cached_property
    def _outcome(self) -> tuple[State, Answers]:
        return self.reference.step(self.state, self.event)

    @property
    def after(self) -> State:
        """The state after it."""
        return self._outcome[0]

    @property
    def actions(self) -> Answers:
        """The actions of the step."""
        return self._outcome[1]

    def launches(self, name: str) -> bool:
        """Return whether it launches a request."""
        return any(isinstance(each, Launched) and each.request == name for each in self.actions)

    @cached_property
    def _assumed(self) -> tuple[tuple[Assumption, bool | None], ...]:
        """The assumptions, each with whether it is true after the step; None if actions do not tell."""
        model = self.reference.model
        return tuple(
            (each, is_true(model, self.event, self.after, self.actions, each.formula)) for each in self.assumptions
        )

    @property
    def forbids(self) -> tuple[Assumption, ...]:
        """The assumptions that it breaks."""
        return tuple(each for each, truth in self._assumed if truth is False)

    @property
    def is_settled(self) -> bool:
        """Whether actions tell of every assumption if the step breaks it."""
        return all(truth is not None for _, truth in self._assumed)


@dataclass(frozen=True, slots=True)
class Shadowing:
    """The rules that decide first, those of them that are the only obstacle (`alone`), and assumptions involved."""

    rules: tuple[str, ...] = ()
    alone: tuple[str, ...] = ()
    forbids: tuple[Assumption, ...] | None = None
    """The assumptions that forbid all seen steps in which it would happen; None if no such step was seen."""
    in_turn: tuple[str, ...] = ()
    """Two or more rules of which each decides first, without those before it; only if no single rule does."""
    unassumed: tuple[str, ...] = ()
    """Rules that would decide first in steps that assumptions forbid."""


def _unplaced(step: Tried) -> Tried:
    """Return the step from the state with an empty waiting place of the asked request."""
    event = step.event
    return replace(step, state=step.state.with_place(event.request, None)) if isinstance(event, Ask) else step


def _roomy(step: Tried) -> Tried:
    """Return the step from the state with an empty waiting place and one more idle slot of the asked request."""
    event, state = step.event, _unplaced(step).state
    if not isinstance(event, Ask):
        return step
    return replace(step, state=state.with_slot((event.request, len(state.slots[event.request])), None))


def _by_count(counted: Counter[str]) -> tuple[str, ...]:
    """Return the counted names, the most frequent first."""
    return tuple(each for each, _ in counted.most_common())


def forbid_each(steps: Sequence[Tried]) -> tuple[Assumption, ...]:
    """Return the assumptions that forbid each of some steps."""
    return tuple(each for each in steps[0].forbids if all(each in step.forbids for step in steps))


def _alone_forbid(steps: Sequence[Tried]) -> tuple[Assumption, ...]:
    """Return the assumptions that forbid each of some steps, if one step is known to break no other; else none."""
    found = forbid_each(steps)
    return found if any(step.is_settled and step.forbids == found for step in steps) else ()


def shadows(
    reference: Reference, without: WithoutRules, assumptions: Sequence[Assumption], findings: Iterable[Finding]
) -> Shadows:
    """Return `Shadows` that try steps from states on the traces of the findings."""
    found: dict[object, State] = {}
    for finding in findings:
        for state in visited(reference, finding.trace.events if finding.trace else ()):
            found.setdefault(state.key(), state)
    return Shadows(reference, without, list(found.values()), assumptions)


def _latched(model: Model) -> list[Cond]:
    """Return the conditions of the latches that rules and guards read, themselves or by other latches."""
    read = {each.name for condition in objecting(model) for each in reads(condition)}
    latched = list[Cond]()
    for latch in reversed(model.latches):
        if latch.name in read:
            latched.append(latch.condition)
            read |= {each.name for each in reads(latch.condition)}
    return latched


def _rules(actions: Sequence[Action]) -> list[str]:
    """Return the rule that each action names, if it names one."""
    return [rule for action in actions if isinstance(rule := getattr(action, "rule", None), str)]


def _cut(model: Model, keep: Callable[[str], bool]) -> Model:
    """Return the model with only those rules, guards, consumptions and launches whose names satisfy `keep`.

    A request whose rule to interrupt itself is cut is refused while it is active, as others are.
    """
    rules = tuple(rule for rule in model.rules if keep(rule.name))
    names = {rule.name for rule in rules}
    requests = tuple(
        replace(
            each,
            guards=tuple(guard for guard in each.guards if keep(guard.name)),
            consumptions=tuple(clause for clause in each.consumptions if keep(clause.resource)),
            interrupts_self=each.interrupts_self and interruption(each.name, each.name) in names,
        )
        for each in model.requests
    )
    launches = tuple(launch for launch in model.launches if keep(launch.name))
    return replace(model, requests=requests, rules=rules, launches=launches)
