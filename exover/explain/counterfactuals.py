"""The smallest change that would have turned an answer, found by trying: one quantity at a time, then two.

Every change is run on the reference interpreter, so what is told is true. A state that breaks a rule which held is not
told: the checker would not have come there.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby, islice, pairwise

from exover.dataclass import dataclass
from exover.explain.interventions import Intervention, Interventions, merged
from exover.explain.relevance import Factor, Mention, concern_of, concern_of_names, quantities
from exover.model.event import Action, Ask, Event, Invalid, Killed, Launched, Rejected, Violated, Waits
from exover.model.explanation import Counterfactual, CounterfactualSearch
from exover.model.semantics import Reference
from exover.model.state import State

MOST = 2
"""Quantities that are changed together at most."""
WORK = 400_000
"""Rules and requests that are looked at in all, some seconds; the trials of a large spec are fewer."""
LEAST = 200
"""Trials that are made whatever the size."""
SHOWN = 6
"""Changes that are told at most."""

AnswerOutcome = frozenset[tuple[str, ...]]


def outcome_of(event: Event, actions: Iterable[Action]) -> AnswerOutcome:
    """Return what an answer comes down to: of an ask what became of its request, else what was done to whom."""
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
    """Return whether an answer is another one.

    That of an event other than an ask is if some action is gone or, where there was none, some has come.
    """
    if isinstance(event, Ask) or not before:
        return after != before
    return not before <= after


class CounterfactualReference(Reference):
    """The reference interpreter for states that are imagined."""

    def latched(self, state: State) -> State:
        """Return the state with every latch set whose condition holds: it follows what is imagined."""
        return self._latch(state, cleared_by=None)

    def broken(self, state: State) -> set[Action]:
        """Return what is broken in a state, as violations."""
        return set(self._violations(state))


@dataclass
class Trials:
    """A search around one answer, which counts its trials."""

    reference: CounterfactualReference
    state: State
    event: Event
    actions: tuple[Action, ...]
    mentions: tuple[Mention, ...]
    limit: int
    tried: int = 0

    def __post_init__(self) -> None:
        self._verdict = self._decided(self.state, self.event)
        self._outcome = outcome_of(self.event, self.actions)
        self._broken = self.reference.broken(self.state)

    @property
    def spent(self) -> bool:
        """Whether no further trial may be made."""
        return self.tried >= self.limit

    def options(self, quantity: Factor, after: "Intervention | None" = None) -> Iterator[Intervention]:
        """Yield the options of a quantity, here or after a first change."""
        state, event = (after.state, after.event) if after else (self.state, self.event)
        return Interventions(self.reference.model, state, event, self.mentions).of(quantity)

    def answer(self, option: Intervention) -> tuple[Action, ...] | None:
        """Return the answer after a change if it is another one and the change is no breach of a rule; else None."""
        self.tried += 1
        state = self.reference.latched(option.state)
        if self.reference.validate(state, option.event):
            return None
        if self._verdict is not None and self._decided(state, option.event) == self._verdict:
            return None  # decided as before: no need to take the whole step
        _, actions = self.reference.step(state, option.event)
        if not turned(self.event, self._outcome, outcome_of(option.event, actions)):
            return None
        return actions if self.reference.broken(state) <= self._broken else None

    def _decided(self, state: State, event: Event) -> str | None:
        """Return what is decided on the newcomer of an ask; None for another event."""
        if not isinstance(event, Ask):
            return None
        request = self.reference.model.request[event.request]
        if state.places[event.request] and not request.interrupts_self:
            return "reject"
        verdict = self.reference.decide(state, request, event.args).verdict
        return "wait" if verdict in ("clear", "settle") else verdict


def search(reference: Reference, state: State, event: Event, first: Iterable[str]) -> CounterfactualSearch:
    """Return the smallest changes that turn the answer; `first`: rules whose quantities are looked at before others.

    A refusal that is not answered again counts as one that is: another reason for it is no turn.
    """
    model = reference.model
    state = state.unrefused()
    _, actions = reference.step(state, event)
    concern = concern_of(reference, state, event, actions)
    near = set(quantities(model, state, event, concern_of_names(model, state, first)))
    found = sorted(quantities(model, state, event, concern), key=lambda quantity: quantity not in near)
    size = len(model.rules) + len(model.requests) + len(model.launches)
    trials = Trials(CounterfactualReference(model), state, event, actions, concern.mentions(), max(LEAST, WORK // size))
    most = 1
    turns = list(_singles(trials, found))
    if not turns and not trials.spent:
        most = MOST
        turns = list(islice(_pairs(trials, found), SHOWN))
    # Launching is what an ask is for: a change that brings that about is told first.
    turns.sort(key=lambda turn: not any(isinstance(action, Launched) for action in turn.actions))
    return CounterfactualSearch(tuple(turns[:SHOWN]), trials.tried, most, not trials.spent)


Result = tuple[Intervention, tuple[Action, ...] | None]


def _singles(trials: Trials, found: list[Factor]) -> Iterator[Counterfactual]:
    """Yield what one changed quantity turns."""
    for quantity in found:
        results: list[Result] = []
        for option in trials.options(quantity):
            if trials.spent:
                break
            results.append((option, trials.answer(option)))
        for whole, group in groupby(results, key=lambda result: result[0].whole):
            yield from _told(trials.event, whole, list(group))


def _told(event: Event, whole: str, results: list[Result]) -> Iterator[Counterfactual]:
    """Yield the results that are turns.

    Neighbouring intervals of a number with one outcome are one turn, and so are all results if they have one outcome.
    """
    outcomes = [None if answer is None else outcome_of(event, answer) for _, answer in results]
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
    """Yield what two changed quantities turn, of each pair of quantities the first."""
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
                alike = _Alike(trials, outcome_of(other.event, answer), second)
                beside = list(alike.grown(others[number:]))
                last = alike.last_with(ones[place:], beside)
                return Counterfactual((merged(one, last), merged(other, beside[-1])), answer)
    return None


@dataclass(frozen=True, slots=True)
class _Alike:
    """Options of two numbers that bring about one outcome, whichever of them are taken together."""

    trials: Trials
    outcome: AnswerOutcome
    second: Factor

    def _has(self, option: Intervention) -> bool:
        answer = None if self.trials.spent else self.trials.answer(option)
        return answer is not None and outcome_of(option.event, answer) == self.outcome

    def grown(self, others: Sequence[Intervention]) -> Iterator[Intervention]:
        """Yield options of the second number, the first of which has the outcome, as long as neighbours have it too."""
        yield others[0]
        for before, option in pairwise(others):
            if not (before.meets(option) and self._has(option)):
                return
            yield option

    def last_with(self, ones: Sequence[Intervention], beside: Sequence[Intervention]) -> Intervention:
        """Return the last neighbour of an option of the first number that has the outcome beside all of these."""
        last = ones[0]
        wanted = [each.interval for each in beside]
        for option in ones[1:]:
            if not last.meets(option):
                break
            others = [each for each in self.trials.options(self.second, after=option) if each.interval in wanted]
            same = [each.text for each in others] == [each.text for each in beside]
            if not (same and all(map(self._has, others))):
                break
            last = option
        return last
