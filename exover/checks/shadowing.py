"""Which rules decide where a dead one would or in the place of a redundant one, and what keeps a request from any
launch: shown by steps near runs.

That a rule never acts is proved by engines. There are two causes: it is never called for, or an earlier one always
decides first. The second is seen near where runs come by: alone the rule speaks in a step, beside all others it does
not, and without one of them it does again (a counterfactual cause, Halpern, Pearl 2005). So it is with a request that
is never launched, and is without one of the rules that decide where it is asked. If it would act only in steps that an
assumption forbids, that is the cause, or is beside the rule.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import field, replace
from functools import cached_property
from random import Random

from exover.checks.finding import Finding
from exover.checks.near_events import arguments, observations
from exover.checks.run_moments import is_true
from exover.dataclass import dataclass
from exover.model.decision import BUSY
from exover.model.event import Action, Ask, Event
from exover.model.model import Model, Request, interruption
from exover.model.property import Assumption
from exover.model.reads import in_question
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
        them; if there are none, the assumption that forbids what it would decide.
        """
        alone, seen = Reference(_cut(self.reference.model, name.__eq__)), Counter[str]()
        asked = in_question(alone.model)
        requests = [each for each in alone.model.requests if each.guards or asked[each.name]]
        forbids = Counter[Assumption]()
        for step in self._steps(alone.model, requests):
            roomy = _roomy(step)
            if name not in _rules(alone.step(roomy.state, step.event)[1]):
                continue
            forbids.update(step.forbids)
            for other in dict.fromkeys(_rules(step.actions)) if not step.forbids else ():
                again = roomy if other == BUSY.rule else replace(step, reference=self.without[other])
                seen[other] += name in _rules(again.actions) and not again.forbids
            if seen.total() >= ENOUGH:
                break
        rules = tuple(rule for rule, count in seen.most_common() if count)
        return Shadowing(rules, (), None if rules else _most(forbids))

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
        """Return which rules decide where a request is asked, the one that does so most often first, and those of them
        that now and then stand alone in the way of a launch; if none does, the assumption that forbids a launch, beside
        the rules that stand alone in the way of one that it forbids.
        """
        model, seen, alone, beside = self.reference.model, Counter[str](), Counter[str](), Counter[str]()
        request, forbids, forbids_without = model.request[name], Counter[Assumption](), Counter[Assumption]()
        concerned = replace(model, requests=(request,), rules=self.reference.questions[name])
        for step in self._steps(concerned, [request]):
            if not isinstance(step.event, Ask):
                continue
            reason = self.reference.decide(step.state, request, step.event.args).reason
            if reason is None:
                forbids.update(step.forbids)
            elif reason != BUSY and not step.forbids:
                seen[reason.rule] += 1
                if alone[reason.rule] < ENOUGH:
                    launch = self.without.launch(self.assumptions, step.state, step.event, reason.rule)
                    if launch is not None:
                        (beside if launch.forbids else alone)[reason.rule] += 1
                        forbids_without.update(launch.forbids)
        rules = tuple(rule for rule, _ in seen.most_common())
        if alone.total():
            return Shadowing(rules, tuple(rule for rule in rules if alone[rule]))
        if forbids:
            return Shadowing(rules, (), _most(forbids))
        return Shadowing(rules, tuple(rule for rule in rules if beside[rule]), _most(forbids_without))

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
                for request in requests:
                    for args in dict.fromkeys(arguments(request, random) for _ in range(ASKS)):
                        yield Tried(self.reference, self.assumptions, there, Ask(request.name, args))


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

    @cached_property
    def forbids(self) -> tuple[Assumption, ...]:
        """The assumptions that it breaks."""
        model = self.reference.model
        return tuple(
            each
            for each in self.assumptions
            if is_true(model, self.event, self.after, self.actions, each.formula) is False
        )


@dataclass(frozen=True, slots=True)
class Shadowing:
    """Which rules decide first, which of them stand alone in the way, and the assumption that forbids all else."""

    rules: tuple[str, ...] = ()
    alone: tuple[str, ...] = ()
    assumption: Assumption | None = None


def _roomy(step: Tried) -> Tried:
    """Return the step from where nothing waits of what is asked and a slot more is idle: it is not busy."""
    state, event = step.state, step.event
    if not isinstance(event, Ask):
        return step
    state = state.with_place(event.request, None).with_slot((event.request, len(state.slots[event.request])), None)
    return replace(step, state=state)


def _most(counted: Counter[Assumption]) -> Assumption | None:
    """Return what was counted most often, if anything was."""
    return next((each for each, _ in counted.most_common(1)), None)


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
