"""Which rules decide where a dead one would or in the place of a redundant one, and what keeps a request from any
launch: shown by steps near runs.

That a rule never acts is proved by engines. There are two causes: it is never called for, or an earlier one always
decides first. The second is seen near where runs come by: alone the rule speaks in a step, beside all others it does
not, and without one of them it does again (a counterfactual cause, Halpern, Pearl 2005). So it is with a request that
is never launched, and is without one of the rules that keep it from a launch. If it would act only in steps that
assumptions forbid, that is the cause, or is beside the rule. One of them is the cause if it forbids each of these
steps, and of a dead rule if without it the rule is seen to act.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import field, replace
from functools import cached_property
from random import Random

from exover.checks.causes.near_events import arguments, observations, onward, reports
from exover.checks.finding import Finding
from exover.dataclass import dataclass
from exover.model.decision import BUSY
from exover.model.event import Action, Ask, Event, Launched
from exover.model.model import Model, Request, interruption
from exover.model.property import Assumption
from exover.model.reads import in_question
from exover.model.run_moments import is_true
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import Answers, visited

RULES, STATES, ASKS, ENOUGH = 20, 40, 4, 12
"""So many dead rules are looked into, from so many states, with so many asks of every request, until enough is seen."""


@dataclass(frozen=True)
class WithoutRules:
    """Reference interpreters of a model without one of its rules, each made when it is first asked."""

    model: Model
    _made: dict[str, Reference] = field(default_factory=dict)

    def __getitem__(self, rule: str) -> Reference:
        """Return the interpreter of the model without the rules, guards, consumptions and launches of this name."""
        if rule not in self._made:
            self._made[rule] = Reference(_cut(self.model, rule.__ne__))
        return self._made[rule]

    def launch(self, assumptions: Sequence[Assumption], state: State, ask: Ask, rule: str) -> "Tried | None":
        """Return the step of an ask that would be launched but for the rule; None if it would not be."""
        other = self[rule]
        if other.decide(state, other.model.request[ask.request], ask.args).verdict != "launch":
            return None
        return Tried(other, assumptions, state, ask)


@dataclass(frozen=True)
class Shadows:
    """Looks for what decides before dead rules. `states`: some that runs come to."""

    reference: Reference
    without: WithoutRules
    states: Sequence[State]
    assumptions: Sequence[Assumption]
    _observed: dict[tuple[int, Event], "Tried"] = field(default_factory=dict)
    """Observations by the number of a state, each tried once for all that are looked into."""

    def of(self, name: str) -> "Shadowing":
        """Return which rules decide where a rule or guard would, the one that was seen most often first, `busy` among
        them; if there are none, the assumptions that forbid what it decides; if it is not seen to, which rules would
        decide where it would in steps that they forbid.
        """
        alone = Reference(_cut(self.reference.model, name.__eq__))
        seen, beside, acts = Counter[str](), Counter[str](), list[Tried]()
        asked = in_question(alone.model)
        requests = [each for each in alone.model.requests if each.guards or asked[each.name]]
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
            if seen.total() >= ENOUGH:
                break
        if seen:
            return Shadowing(_by_count(seen))
        if not acts:
            return Shadowing(unassumed=_by_count(beside))
        acts += (step for step in self._further(requests) if step.forbids and name in _rules(step.actions))
        return Shadowing(forbids=_alone_forbid(acts))

    def instead_of(self, name: str) -> tuple[str, ...]:
        """Return which rules decide where a rule does once it is taken out, the one that does so most often first."""
        only, seen = _cut(self.reference.model, name.__eq__), Counter[str]()
        asked = in_question(only)
        for step in self._steps(only, [each for each in only.requests if asked[each.name]]):
            named = Counter(_rules(step.actions))
            if name in named and not step.forbids:
                again = replace(step, reference=self.without[name])
                seen.update(Counter(_rules(again.actions)) - named if not again.forbids else ())
            if seen.total() >= ENOUGH:
                break
        return tuple(rule for rule, _ in seen.most_common())

    def before_launch(self, name: str) -> "Shadowing":
        """Return which rules keep a request from a launch where it is asked or waits, the one that does so most often
        first, and those of them that now and then stand alone in the way of a launch; if none does, the assumptions
        that forbid every launch, beside the rules that stand alone in the way of one that is forbidden.
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
            return Shadowing(rules, forbids=_forbid_each(forbidden))
        forbids = _forbid_each(forbidden_without) if forbidden_without else None
        return Shadowing(rules, tuple(rule for rule in rules if beside[rule]), forbids)

    def _steps(self, only: Model, requests: Sequence[Request]) -> Iterator["Tried"]:
        """Yield steps near what a rule speaks of: observations of what it reads, and asks of requests after these."""
        random = Random(0)
        seen = list(observations(only))
        for number, state in enumerate(self.states):
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

    def _further(self, requests: Sequence[Request]) -> Iterator["Tried"]:
        """Yield asks of requests, and reports, where random runs come to, if these may tell assumptions apart."""
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
    """A step, which is taken when it is asked what comes of it."""

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
        """What it answers."""
        return self._outcome[1]

    def launches(self, name: str) -> bool:
        """Return whether it launches a request."""
        return any(isinstance(each, Launched) and each.request == name for each in self.actions)

    @cached_property
    def _assumed(self) -> tuple[tuple[Assumption, bool | None], ...]:
        """The assumptions, with whether each is true after it, as far as actions tell."""
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
        """Whether actions tell of every assumption whether it breaks it."""
        return all(truth is not None for _, truth in self._assumed)


@dataclass(frozen=True, slots=True)
class Shadowing:
    """Which rules decide first, and which of them stand alone in the way; what assumptions have to do with it."""

    rules: tuple[str, ...] = ()
    alone: tuple[str, ...] = ()
    forbids: tuple[Assumption, ...] | None = None
    """Those that are known to forbid all steps in which it would happen; None if there are no such steps."""
    unassumed: tuple[str, ...] = ()
    """Rules that would decide first in steps that assumptions forbid."""


def _roomy(step: Tried) -> Tried:
    """Return the step from where nothing waits of what is asked and a slot more is idle: it is not busy."""
    state, event = step.state, step.event
    if not isinstance(event, Ask):
        return step
    state = state.with_place(event.request, None).with_slot((event.request, len(state.slots[event.request])), None)
    return replace(step, state=state)


def _by_count(counted: Counter[str]) -> tuple[str, ...]:
    """Return what was counted, what was counted most often first."""
    return tuple(each for each, _ in counted.most_common())


def _forbid_each(steps: Sequence[Tried]) -> tuple[Assumption, ...]:
    """Return the assumptions that forbid each of some steps."""
    return tuple(each for each in steps[0].forbids if all(each in step.forbids for step in steps))


def _alone_forbid(steps: Sequence[Tried]) -> tuple[Assumption, ...]:
    """Return the assumptions that forbid each of some steps, if without them one of these is seen to be allowed."""
    found = _forbid_each(steps)
    return found if any(step.is_settled and step.forbids == found for step in steps) else ()


def shadows(
    reference: Reference, without: WithoutRules, assumptions: Sequence[Assumption], findings: Iterable[Finding]
) -> Shadows:
    """Return what looks where the runs of findings come by."""
    found: dict[object, State] = {}
    for finding in findings:
        for state in visited(reference, finding.trace.events if finding.trace else ()):
            found.setdefault(state.key(), state)
    states = list(found.values())
    return Shadows(reference, without, states[:: -(-len(states) // STATES)], assumptions)


def _rules(actions: Sequence[Action]) -> list[str]:
    """Return the rules that actions name, one for each."""
    return [rule for action in actions if isinstance(rule := getattr(action, "rule", None), str)]


def _cut(model: Model, keep: Callable[[str], bool]) -> Model:
    """Return the model with those rules, guards, consumptions and launches alone whose names are to be kept.

    A request that no rule of its own interrupts any more is refused while it is active, as others are.
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
