"""Which rules decide where a dead one would, and what keeps a request from any launch: shown by steps near runs.

That a rule never acts is proved by engines. There are two causes: it is never called for, or an earlier one always
decides first. The second is seen near where runs come by: alone the rule speaks in a step, beside all others it does
not, and without one of them it does again (a counterfactual cause, Halpern, Pearl 2005). So it is with a request that
is never launched, and is without one of the rules that decide where it is asked.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import field, replace
from random import Random

from exover.checks.finding import Finding
from exover.checks.near_events import arguments, observations
from exover.dataclass import dataclass
from exover.model.decision import BUSY
from exover.model.event import Action, Args, Ask, Event
from exover.model.model import Model, Request
from exover.model.reads import in_question
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import visited

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

    def launches(self, state: State, name: str, args: Args, rule: str) -> bool:
        """Return whether a request would start in a state but for the rule."""
        other = self[rule]
        return other.decide(state, other.model.request[name], args).verdict == "launch"


@dataclass(frozen=True)
class Shadows:
    """Looks for what decides before dead rules. `states`: some that runs come to."""

    reference: Reference
    without: WithoutRules
    states: Sequence[State]

    def of(self, name: str) -> tuple[str, ...]:
        """Return which rules decide where a rule or guard would, the one that was seen most often first."""
        alone, seen = Reference(_cut(self.reference.model, name.__eq__)), Counter[str]()
        asked = in_question(alone.model)
        requests = [each for each in alone.model.requests if each.guards or asked[each.name]]
        for state, event in self._steps(alone.model, requests):
            if name not in _rules(alone.step(state, event)[1]):
                continue
            for other in _rules(self.reference.step(state, event)[1]):
                seen[other] += name in _rules(self.without[other].step(state, event)[1])
            if seen.total() >= ENOUGH:
                break
        return tuple(rule for rule, count in seen.most_common() if count)

    def before_launch(self, name: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Return which rules decide where a request is asked, the one that does so most often first, and those of them
        that now and then stand alone in the way of a launch.
        """
        model, seen, alone = self.reference.model, Counter[str](), Counter[str]()
        request = model.request[name]
        for state, event in self._steps(model, [request]):
            if isinstance(event, Ask):
                reason = self.reference.decide(state, request, event.args).reason
                if reason is not None and reason != BUSY:
                    seen[reason.rule] += 1
                    if alone[reason.rule] < ENOUGH:
                        alone[reason.rule] += self.without.launches(state, name, event.args, reason.rule)
        rules = tuple(rule for rule, _ in seen.most_common())
        return rules, tuple(rule for rule in rules if alone[rule])

    def _steps(self, only: Model, requests: Sequence[Request]) -> Iterator[tuple[State, Event]]:
        """Yield steps near what a rule speaks of: observations of what it reads, and asks of requests after these."""
        random = Random(0)
        seen = list(observations(only))
        for state in self.states:
            for observation in (None, *seen):
                there = state if observation is None else self.reference.step(state, observation)[0]
                if observation is not None:
                    yield state, observation
                for request in requests:
                    for args in dict.fromkeys(arguments(request, random) for _ in range(ASKS)):
                        yield there, Ask(request.name, args)


def shadows(reference: Reference, without: WithoutRules, findings: Iterable[Finding]) -> Shadows:
    """Return what looks where the runs of findings come by."""
    found: dict[object, State] = {}
    for finding in findings:
        for state in visited(reference, finding.trace.events if finding.trace else ()):
            found.setdefault(state.key(), state)
    states = list(found.values())
    return Shadows(reference, without, states[:: -(-len(states) // STATES)])


def _rules(actions: Sequence[Action]) -> set[str]:
    """Return which rules actions name."""
    return {rule for action in actions if isinstance(rule := getattr(action, "rule", None), str)}


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
            interrupts_self=each.interrupts_self and f"{each.name}.interrupts.self" in names,
        )
        for each in model.requests
    )
    launches = tuple(launch for launch in model.launches if keep(launch.name))
    return replace(model, requests=requests, rules=rules, launches=launches)
