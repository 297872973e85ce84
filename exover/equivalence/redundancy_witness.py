"""A short run at whose end a decision differs without a rule, found by bounded search."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

from exover.loop.finite.builder import ClosedLoop
from exover.model.decision import Decision, Decisions
from exover.model.event import Ask, Event, Observe
from exover.model.index import ModelIndex
from exover.model.model import Request, Rule
from exover.model.reads import rule_reads
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import Trace, run

MOST = 60
"""How many steps are made and decisions compared: enough for a rule that two or three events show to matter."""


@dataclass(frozen=True)
class _Without(Decisions):
    """The decisions of a model on some requests as they are without the rules of one name."""

    asked: dict[str, tuple[Rule, ...]]

    @cached_property
    def questions(self) -> dict[str, tuple[Rule, ...]]:
        """The rules in question that are left, by request."""
        return self.asked


def contrast(loop: ClosedLoop, reference: Reference, rules: Sequence[Rule]) -> Trace | None:
    """Return a run whose last event is an ask that would be decided otherwise without these rules, all of one name.

    None if within `MOST` there is no such run, which says nothing.
    """
    name = rules[0].name
    left = {
        request: tuple(rule for rule in asked if rule.name != name)
        for request, asked in reference.questions.items()
        if any(rule.name == name for rule in asked)
    }
    asks = [Ask(each, cell.args) for each in left for cell in loop.arguments[loop.request_number[each]].cells]
    matters = partial(_differ, reference, _Without(loop.model, left), name)
    found = _nearest(reference, asks, list(_observations(loop, rules)), matters)
    found = found or _in_turn(reference, asks[:MOST], matters)
    return run(reference, found) if found else None


def _nearest(
    reference: Reference, asks: list[Ask], observations: list[Event], matters: Callable[[State, Ask], bool]
) -> tuple[Event, ...] | None:
    """Return a shortest run of these events that ends with an ask that matters."""
    start = reference.start()
    queue: list[tuple[State, tuple[Event, ...]]] = [(start, ())]
    seen, spent = {start.key()}, 0
    for state, before in queue:
        spent += 2 * len(asks) + len(observations)
        if spent > MOST:
            break
        for ask in asks:
            if matters(state, ask):
                return (*before, ask)
        for event in (*asks, *observations):
            after, _ = reference.step(state, event)
            if after.key() not in seen:
                seen.add(after.key())
                queue.append((after, (*before, event)))
    return None


def _in_turn(reference: Reference, asks: list[Ask], matters: Callable[[State, Ask], bool]) -> tuple[Event, ...] | None:
    """Return the run of the asks, one after the other, up to one that matters: it reaches limits."""
    state = reference.start()
    for number, ask in enumerate(asks):
        if matters(state, ask):
            return tuple(asks[: number + 1])
        state, _ = reference.step(state, ask)
    return None


def _observations(loop: ClosedLoop, rules: Sequence[Rule]) -> Iterator[Event]:
    """Yield the observations of what rules read, one for each that is told apart."""
    named = {read.name for rule in rules for read in rule_reads(rule) if read.kind == "reading"}
    for number, variable in ModelIndex(loop.model).posters:
        if variable.name in named:
            for value in loop.samples.get(number, ()):
                yield Observe(variable.name, value)


def _differ(reference: Reference, without: _Without, name: str, state: State, ask: Ask) -> bool:
    """Return whether an ask is decided otherwise without the rules, reasons left aside."""
    request = reference.model.request[ask.request]
    if state.places[request.name]:
        return False  # mostly nothing is decided then, and longer runs are for others to look at
    mine = reference.decide(state, request, ask.args)
    its = without.decide(state, _without(request, name), ask.args)
    return _effects(mine, state) != _effects(its, state)


def _without(request: Request, name: str) -> Request:
    """Return a request as it is without the rule: it may be the one by which it interrupts itself."""
    return replace(request, interrupts_self=False) if name == f"{request.name}.interrupts.self" else request


def _effects(decision: Decision, state: State) -> tuple[object, ...]:
    """Return what a decision does, without its reasons."""
    dismissed = {name for name, _ in decision.dismissed if state.places[name]}
    return decision.verdict, {slot for slot, _ in decision.kills}, dismissed
