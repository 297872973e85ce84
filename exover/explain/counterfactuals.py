"""Counterfactuals: the smallest changes that change an answer, found by trial: of one quantity, then of two.

Every change is run on the reference interpreter, so each counterfactual is true. A changed state that breaks a rule
which the actual state does not break is skipped: the checker would not have reached it.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import groupby, islice, pairwise

from exover.dataclass import dataclass
from exover.explain.intervals import Interval
from exover.explain.interventions import Intervention, Interventions, at_sample, merged
from exover.explain.paths import Surroundings
from exover.explain.relevance import (
    Factor,
    Mention,
    Relevance,
    compared_anywhere,
    concern_of,
    concern_of_names,
    quantities,
)
from exover.model.event import Action, Ask, Event, Invalid, Killed, Launched, Rejected, Violated, Waits
from exover.model.explanation import Counterfactual, CounterfactualSearch
from exover.model.expression import operands
from exover.model.model import Model
from exover.model.semantics import Reference
from exover.model.state import State

MOST = 2
"""The most quantities that are changed together."""
WORK = 400_000
"""The budget, trials times rules and requests, of some seconds: a large spec gets fewer trials."""
TERMS = 1_200_000
"""The budget, trials times terms of the conditions in question, of some seconds as well."""
LEAST = 200
"""The trials that a spec of any size gets."""
SHOWN = 6
"""The most changes that are told."""

AnswerOutcome = frozenset[tuple[str, ...]]


def outcome_of(event: Event, actions: Iterable[Action]) -> AnswerOutcome:
    """Return what counts of an answer: of an ask what became of its request, else each action without its reason."""
    found: set[tuple[str, ...]] = set()
    for action in actions:
        match action:
            case Launched(name, slot):
                found.add(("launch", name, str(slot)))
            case Waits(name):
                found.add(("wait", name))
            case Rejected(name, rule):
                if rule != "superseded":
                    found.add(("reject", name))
            case Killed(name, slot):
                found.add(("kill", name, str(slot)))
            case Violated(rule):
                found.add(("violation", rule))
            case Invalid():
                pass
    if isinstance(event, Ask):
        return frozenset(
            (word, name) for word, name, *_ in found if name == event.request and word in ("launch", "wait", "reject")
        )
    return frozenset(found)


def turned(event: Event, before: AnswerOutcome, after: AnswerOutcome) -> bool:
    """Return whether an answer is changed.

    Of an ask: iff the outcomes differ; of another event: iff an action is gone or, where there was none, one is there.
    """
    if isinstance(event, Ask) or not before:
        return after != before
    return not before <= after


class CounterfactualReference(Reference):
    """The reference interpreter, for states that an intervention has changed."""

    def latched(self, state: State) -> State:
        """Return the state with every latch set whose condition holds there."""
        return self._latch(state, cleared_by=None)

    def broken(self, state: State) -> set[Action]:
        """Return a violation for each rule that is broken in a state."""
        return set(self.violations(state))


@dataclass
class Trials:
    """The trials of interventions on one answer, at most `limit`; `tried`: how many were made."""

    reference: CounterfactualReference
    state: State
    event: Event
    actions: tuple[Action, ...]
    mentions: tuple[Mention, ...]
    limit: int
    tried: int = 0

    def __post_init__(self) -> None:
        self._compared = compared_anywhere(self.reference.model)
        self._outcome = outcome_of(self.event, self.actions)
        self._broken = self.reference.broken(self.state)

    @property
    def spent(self) -> bool:
        """Whether all trials are used."""
        return self.tried >= self.limit

    def options(self, quantity: Factor, after: "Intervention | None" = None) -> Iterator[Intervention]:
        """Yield the interventions on a quantity, in the actual state or after a first intervention."""
        state, event = (after.state, after.event) if after else (self.state, self.event)
        model = self.reference.model
        return Interventions(model, state, event, self.mentions, self._compared, self._answer).of(quantity)

    def answer(self, option: Intervention) -> tuple[Action, ...] | None:
        """Return the answer after a change if it is changed and the change breaks no more rules; else None."""
        self.tried += 1
        return self._answer(option.state, option.event)

    def _answer(self, state: State, event: Event) -> tuple[Action, ...] | None:
        state = self.reference.latched(state)
        if self.reference.validate(state, event):
            return None
        _, actions = self.reference.step(state, event)
        if not turned(self.event, self._outcome, outcome_of(event, actions)):
            return None
        return actions if self.reference.broken(state) <= self._broken else None

    def independent(self, one: Intervention, other: Intervention) -> bool:
        """Return whether all numbers of one option have one answer with all of another, which is taken after it."""
        state, event = other.state, other.event
        noted: list[tuple[Surroundings, Interval]] = []
        for option in (one, other):
            if option.interval and option.put:
                near = Surroundings(option.interval.sample)
                noted.append((near, option.interval))
                state, event = option.put(state, event, near.probe())
        self._answer(state, event)
        return all(
            not near.joint and near.hold(each.low, each.high, each.low_closed, each.high_closed) for near, each in noted
        )


def said(actions: Iterable[Action]) -> tuple[Action, ...]:
    """Return what is said of an answer, whatever the values are with which something is launched."""
    return tuple(replace(action, args=()) if isinstance(action, Launched) else action for action in actions)


def search(reference: Reference, state: State, event: Event, first: Iterable[str]) -> CounterfactualSearch:
    """Return the smallest changes that change the answer; `first`: rules whose quantities are tried before others.

    A refusal that is not answered again counts as answered; another reason for it is no changed answer.
    """
    model = reference.model
    state = state.unrefused()
    _, actions = reference.step(state, event)
    concern = concern_of(reference, state, event, actions)
    near = set(quantities(state, event, concern_of_names(model, state, first)))
    found = sorted(quantities(state, event, concern), key=lambda quantity: quantity not in near)
    limit = _limit(model, concern)
    trials = Trials(CounterfactualReference(model), state, event, actions, concern.mentions(), limit)
    most = 1
    turns = list(_singles(trials, found))
    if not turns and not trials.spent:
        most = MOST
        turns = list(islice(_pairs(trials, found), SHOWN))
    # An ask is meant to launch: a change with which something is launched is told first.
    turns.sort(key=lambda turn: not any(isinstance(action, Launched) for action in turn.actions))
    return CounterfactualSearch(tuple(turns[:SHOWN]), trials.tried, most, not trials.spent)


def _limit(model: Model, concern: Relevance) -> int:
    """Return how many trials there may be for an answer: the fewer, the more a trial takes."""
    size = len(model.rules) + len(model.requests) + len(model.launches)
    terms = sum(1 for condition, _ in concern.conditions for _ in operands(condition))
    return max(LEAST, min(WORK // size, TERMS // max(terms, 1)))


Result = tuple[Intervention, tuple[Action, ...] | None]


def _singles(trials: Trials, found: list[Factor]) -> Iterator[Counterfactual]:
    """Yield the counterfactuals of one changed quantity."""
    for quantity in found:
        results: list[Result] = []
        for option in trials.options(quantity):
            if trials.spent:
                break
            results.append((option, trials.answer(option)))
        for whole, group in groupby(results, key=lambda result: result[0].whole):
            yield from _told("" if trials.spent else whole, list(group))


def _told(whole: str, results: list[Result]) -> Iterator[Counterfactual]:
    """Yield the counterfactuals among the results for one quantity.

    Adjacent intervals of a number with one answer make one, and so do all results of a `whole` with one answer.
    """
    outcomes = [None if answer is None else said(answer) for _, answer in results]
    if whole and len(set(outcomes)) == 1:
        yield from (Counterfactual((whole,), answer) for _, answer in results[:1] if answer is not None)
        return
    start = 0
    for index, (option, answer) in enumerate(results):
        last = index + 1 == len(results)
        if not last and outcomes[index] == outcomes[index + 1] and option.meets(results[index + 1][0]):
            continue
        if answer is not None:
            yield Counterfactual((merged(results[start][0], option),), answer)
        start = index + 1


def _pairs(trials: Trials, found: list[Factor]) -> Iterator[Counterfactual]:
    """Yield the first counterfactual of each pair of quantities."""
    for later, second in enumerate(found):
        for first in found[:later]:
            turn = _pair(trials, first, second)
            if turn:
                yield turn
            if trials.spent:
                return


def _pair(trials: Trials, first: Factor, second: Factor) -> Counterfactual | None:
    ones = list(trials.options(first))
    for place, one in enumerate(ones):
        others = list(trials.options(second, after=one))
        for number, other in enumerate(others):
            if trials.spent:
                return None
            answer = trials.answer(other)
            if answer is not None:
                together = trials.independent(one, other)
                alike = _Alike(trials, said(answer), second, together)
                beside = list(alike.grown(one, others[number:]))
                last = alike.last_with(ones[place:], beside) if together else one
                text = merged(one, last) if together else at_sample(one).text
                return Counterfactual((text, merged(other, beside[-1])), answer)
    return None


@dataclass(frozen=True, slots=True)
class _Alike:
    """Finds a rectangle of intervals of two numbers in which all combinations have one answer.

    Unless `together`: an interval of the second number, for the value of the first that was tried.
    """

    trials: Trials
    said: tuple[Action, ...]
    second: Factor
    together: bool

    def _has(self, one: Intervention, other: Intervention) -> bool:
        answer = None if self.trials.spent else self.trials.answer(other)
        same = answer is not None and said(answer) == self.said
        return same and (not self.together or self.trials.independent(one, other))

    def grown(self, one: Intervention, others: Sequence[Intervention]) -> Iterator[Intervention]:
        """Yield the first of the options of the second number, and those adjacent that follow with the same answer."""
        yield others[0]
        for before, option in pairwise(others):
            if not (before.meets(option) and self._has(one, option)):
                return
            yield option

    def last_with(self, ones: Sequence[Intervention], beside: Sequence[Intervention]) -> Intervention:
        """Return the last adjacent option of the first number with the answer for each option in `beside`."""
        last = ones[0]
        wanted = [each.interval for each in beside]
        for option in ones[1:]:
            if not last.meets(option):
                break
            others = [each for each in self.trials.options(self.second, after=option) if each.interval in wanted]
            same = [each.text for each in others] == [each.text for each in beside]
            if not (same and all(self._has(option, other) for other in others)):
                break
            last = option
        return last
