"""Short runs near a rule or a guard, with all else idle: cheap witnesses, without sets of states.

A rule is about few requests and posters. The runs consist of asks of these requests and observations of these posters,
one for all values that the conditions of the rule do not tell apart; each is a run of the whole model on the reference
interpreter. What none of them shows is left open.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from functools import cached_property

from exover.dataclass import dataclass
from exover.loop.finite.builder import ClosedLoop
from exover.model.decision import BUSY, Decision, Decisions
from exover.model.evaluate import holds
from exover.model.event import Ask, Event, Killed, Observe
from exover.model.expression import Compare, Cond, Const, Reading, atoms, operands
from exover.model.index import ModelIndex
from exover.model.model import Rule
from exover.model.property import Label
from exover.model.reads import Read, reads
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.types import Value

MOST = 60
"""The budget of steps and compared decisions: enough for rules that matter after two or three events."""
Run = tuple[Event, ...]


@dataclass(frozen=True, slots=True)
class Shown:
    """What short runs show of a rule or guard: the marks that steps pass for it, and a run that it makes differ.

    `contrast`: its last event is an ask that would be decided otherwise without the rules of this name.
    """

    marks: frozenset[Label]
    contrast: Run | None


@dataclass(frozen=True, slots=True)
class _Near:
    """The events near a rule or guard, and the decisions without the rules of that name, if there are any."""

    name: str
    asks: tuple[Ask, ...]
    observations: tuple[Observe, ...]
    without: "_Without | None"


@dataclass(frozen=True, slots=True)
class _LastStep:
    """The last step of a run, from this state: an ask with its decision, or which slots it kills."""

    run: Run
    state: State
    decision: Decision | None
    killed: tuple[Killed, ...] = ()


@dataclass(frozen=True)
class _Without(Decisions):
    """The decisions of a model on some requests without the rules of one name."""

    asked: dict[str, tuple[Rule, ...]]

    @cached_property
    def questions(self) -> dict[str, tuple[Rule, ...]]:
        """The rules in question that are left, by request."""
        return self.asked


@dataclass
class NearbyRuns:
    """Searches short runs; `wanted`: maps a rule or guard to the marks that are asked about."""

    loop: ClosedLoop
    reference: Reference
    wanted: Mapping[str, frozenset[Label]]
    _shown: dict[str, Shown] = field(default_factory=dict)

    def shown(self, name: str) -> Shown:
        """Return what short runs show of the rules, or of the guard, of a name; searched once."""
        if name not in self._shown:
            self._shown[name] = self._search(self._near(name))
        return self._shown[name]

    def _search(self, near: _Near) -> Shown:
        marks: set[Label] = set()
        missing, contrast = self.wanted.get(near.name, frozenset()) | {("rule", near.name)}, None
        for step in self._last_steps(near):
            marks |= _marks(step)
            if contrast is None and near.without and self._differ(near.without, near.name, step):
                contrast = step.run
            if missing <= marks and (contrast or not near.without):
                break
        return Shown(frozenset(mark for mark in marks if mark[1] == near.name), contrast)

    # ---- runs ----

    def _last_steps(self, near: _Near) -> Iterator[_LastStep]:
        """Yield the last steps of runs, breadth first, then those of one run of all asks, which reaches limits."""
        queue: list[tuple[State, Run]] = [(self.reference.start(), ())]
        seen, spent = {self.reference.start().key()}, 0
        for state, before in queue:
            spent += 2 * len(near.asks) + len(near.observations)
            if spent > MOST:
                break
            yield from (self._asked(state, before, ask) for ask in near.asks)
            events: tuple[Event, ...] = (*near.asks, *near.observations)
            for event in events:
                after, actions = self.reference.step(state, event)
                killed = tuple(action for action in actions if isinstance(action, Killed))
                if killed:
                    yield _LastStep((*before, event), state, None, killed)
                if after.key() not in seen:
                    seen.add(after.key())
                    queue.append((after, (*before, event)))
        yield from self._in_turn(near.asks[:MOST])

    def _in_turn(self, asks: Sequence[Ask]) -> Iterator[_LastStep]:
        state = self.reference.start()
        for number, ask in enumerate(asks):
            yield self._asked(state, asks[:number], ask)
            state, _ = self.reference.step(state, ask)

    def _asked(self, state: State, before: Sequence[Event], ask: Ask) -> _LastStep:
        """Return the step of an ask; where something waits already mostly nothing is decided."""
        taken = state.places[ask.request]
        decision = None if taken else self.reference.decide(state, self.reference.model.request[ask.request], ask.args)
        return _LastStep((*before, ask), state, decision)

    def _differ(self, without: _Without, name: str, step: _LastStep) -> bool:
        """Return whether an ask is decided otherwise without the rules, reasons left aside."""
        ask = step.run[-1]
        if step.decision is None or not isinstance(ask, Ask) or ask.request not in without.asked:
            return False
        request = self.reference.model.request[ask.request].without_rules({name})
        its = without.decide(step.state, request, ask.args)
        return _effects(step.decision, step.state) != _effects(its, step.state)

    # ---- what is near ----

    @cached_property
    def _questions(self) -> dict[str, list[str]]:
        """By rule the requests whose decision it is in question for; by guard and consumable those that have it."""
        found: dict[str, dict[str, None]] = {}
        for request in self.reference.model.requests:
            names = [rule.name for rule in self.reference.questions[request.name]]
            names += [guard.name for guard in request.guards] + [each.resource for each in request.consumptions]
            for name in names:
                found.setdefault(name, {})[request.name] = None
        return {name: list(requests) for name, requests in found.items()}

    @cached_property
    def _guards(self) -> dict[str, list[Cond]]:
        return {guard.name: [guard.condition] for each in self.reference.model.requests for guard in each.guards}

    def _near(self, name: str) -> _Near:
        rules = self.reference.model.rules_named(name)
        conditions = [rule.condition for rule in rules] + self._guards.get(name, [])
        named = {read for condition in conditions for read in reads(condition)}
        requests = dict.fromkeys(self._questions.get(name, ()))
        requests |= dict.fromkeys(sorted(read.name for read in named if read.kind in ("active", "waiting")))
        cells = (
            (each, cell) for each in requests for cell in self.loop.arguments[self.loop.request_number[each]].cells
        )
        asks = tuple(Ask(each, cell.args) for each, cell in cells)
        without = self._left(name, requests) if rules else None
        return _Near(name, asks, tuple(self._observations(conditions, named)), without)

    def _left(self, name: str, requests: Iterable[str]) -> _Without:
        """Return the decisions without the rules of a name on the requests that they are in question for."""
        questions = self.reference.questions
        left = {each: tuple(rule for rule in questions[each] if rule.name != name) for each in requests}
        return _Without(
            self.loop.model, {each: rules for each, rules in left.items() if len(rules) < len(questions[each])}
        )

    def _observations(self, conditions: Sequence[Cond], named: Iterable[Read]) -> Iterator[Observe]:
        """Yield the observations of what conditions read, one for all values that they do not tell apart."""
        names = {read.name for read in named if read.kind == "reading"}
        compared = [atom for condition in conditions for atom in atoms(condition)]
        for number, variable in ModelIndex(self.loop.model).posters:
            if variable.name in names:
                told = [atom for atom in compared if Read("reading", variable.name) in reads(atom)]
                yield from self._told_apart(variable.name, self.loop.samples.get(number, ()), told)

    def _told_apart(self, poster: str, values: Sequence[Value], told: Sequence[Cond]) -> Iterator[Observe]:
        """Yield observations of a poster, where its value alone decides these atoms one for each of their truths."""
        terms = [term for atom in told for term in operands(atom)]
        alone = all(isinstance(term, Const) or term == Reading(poster) for term in terms)
        alone = alone and all(isinstance(atom, Compare) for atom in told)
        seen: set[object] = set()
        for value in values:
            state = self.reference.start().with_reading(poster, value)
            sign = tuple(holds(self.loop.model, state, atom) for atom in told) if alone else value
            if sign not in seen:
                seen.add(sign)
                yield Observe(poster, value)


def _marks(step: _LastStep) -> set[Label]:
    """Return the marks that the step passes for rules and guards: for whom it decides, and kills."""
    decision, found = step.decision, set[Label]()
    slots = [(killed.request, killed.rule) for killed in step.killed]
    if decision and decision.reason and decision.reason is not BUSY:
        found |= {("rule", decision.reason.rule), (decision.verdict, decision.reason.rule)}
        slots += [(name, reason.rule) for (name, _), reason in decision.kills]
    return found | {mark for name, rule in slots for mark in (("rule", rule), ("kill", rule, name))}


def _effects(decision: Decision, state: State) -> tuple[object, ...]:
    """Return what a decision does, without its reasons."""
    dismissed = {name for name, _ in decision.dismissed if state.places[name]}
    return decision.verdict, {slot for slot, _ in decision.kills}, dismissed
