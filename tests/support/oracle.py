"""The verdicts of docs/checks.md by plain enumeration: all states, one after the other, in sets.

It shares nothing with the engines but the model and the reference interpreter, and is written to be read beside
docs/checks.md, one function for each check.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

from exover.model.evaluate import Scope, bind, holds
from exover.model.event import (
    Abort,
    AbortWaiting,
    Action,
    Args,
    Ask,
    Event,
    Invalid,
    Killed,
    Launched,
    Observe,
    Rejected,
    Report,
    Violated,
    Waits,
)
from exover.model.model import Kill, KillSlot, Model, Reject, Rule, Wait
from exover.model.state import State
from tests.support.representatives import Representatives, TooLarge
from tests.support.watch import watched

Verdict = Literal["holds", "violated"]
Verdicts = dict[tuple[str, str], Verdict]
NEVER_AT_ALL = ("mutex", "over", "interrupts", "limit", "resource")
"""The kinds of rules whose F is false at every moment."""


@dataclass(frozen=True, slots=True)
class Edge:
    """A step: from one state by an event to another, with the names that its actions bear.

    A refusal of a required launch that is not answered again is among them no more than in the answers.
    """

    source: int
    target: int
    event: Event
    launched: frozenset[str]
    named: frozenset[str]
    violated: frozenset[str]


@dataclass
class Graph:
    """All reachable states and steps; state 0 is the initial one, `after` those that some step leads to."""

    model: Model
    states: list[State] = field(default_factory=list)
    edges: list[Edge] = field(default_factory=list)
    changed: set[str] = field(default_factory=set)
    """The rules without which something would be decided otherwise in some step."""
    decided: set[tuple[str, ...]] = field(default_factory=set)
    """Whose demands are taken in some step, as in `Watched`."""

    @cached_property
    def after(self) -> set[int]:
        """The states that stand after some step; read it when the graph is whole."""
        return {edge.target for edge in self.edges}

    @cached_property
    def number(self) -> dict[tuple[object, ...], int]:
        """The numbers of states by their keys; read it when the graph is whole."""
        return {state.key(): index for index, state in enumerate(self.states)}

    def backwards(self, goal: set[int], ends: Callable[[Edge], bool], allowed: Callable[[Edge], bool]) -> set[int]:
        """Return the states from which some path of allowed steps leads into `goal` or takes a step that ends it."""
        before: dict[int, list[int]] = {}
        found = set(goal)
        for edge in self.edges:
            if allowed(edge):
                before.setdefault(edge.target, []).append(edge.source)
                if ends(edge):
                    found.add(edge.source)
        queue = list(found)
        while queue:
            for source in before.get(queue.pop(), []):
                if source not in found:
                    found.add(source)
                    queue.append(source)
        return found


def explore(model: Model, most_states: int, most_steps: int) -> Graph:
    """Return the reachable states by breadth-first search; raises `TooLarge`."""
    reference, values = watched(model), Representatives(model)
    graph = Graph(model, changed=reference.changed, decided=reference.decided)
    start = values.canonical(reference.start())
    number = {start.key(): 0}
    graph.states.append(start)
    for source, state in enumerate(graph.states):
        for event in events_of(model, values, state):
            after, actions = reference.step(state, event)
            after = values.canonical(after)
            target = number.setdefault(after.key(), len(graph.states))
            if target == len(graph.states):
                graph.states.append(after)
            graph.edges.append(_edge(source, target, event, actions))
            if len(graph.states) > most_states or len(graph.edges) > most_steps:
                raise TooLarge("too many states or steps")
    return graph


def _edge(source: int, target: int, event: Event, actions: tuple[Action, ...]) -> Edge:
    launched: set[str] = set()
    named: set[str] = set()
    violated: set[str] = set()
    for action in actions:
        match action:
            case Launched(name, launch_rule=required):
                launched.add(name)
                named |= {required} if required else set()
            case Waits(_, rule, launch_rule=required) | Rejected(_, rule, launch_rule=required):
                named |= {rule, required} if required else {rule}
            case Killed(_, _, rule):
                named.add(rule)
            case Violated(rule):
                named.add(rule)
                violated.add(rule)
            case Invalid():
                raise AssertionError("every event of the search is valid")
    return Edge(source, target, event, frozenset(launched), frozenset(named), frozenset(violated))


def events_of(model: Model, values: Representatives, state: State) -> Iterable[Event]:
    """Yield the valid events of a state, by their representatives."""
    for request in model.requests:
        for args in values.arguments(state, request.name, request.params):
            yield Ask(request.name, args)
        if state.places[request.name]:
            yield AbortWaiting(request.name)
    for name, slot in state.active():
        for results in values.arguments(state, name, model.request[name].results):
            yield Report(name, slot, "ok", results)
        yield Report(name, slot, "failed")
        yield Report(name, slot, "interrupted")
        yield Abort(name, slot)
    for variable in model.variables:
        if variable.kind == "poster":
            for value in values.values(state, (None, variable.name)):
                yield Observe(variable.name, value)
    for resource in state.levels:
        for reading in range(model.resource[resource].capacity + 1):
            yield Observe(resource, reading)


# ---- the checks ----


def verdicts(graph: Graph) -> Verdicts:
    """Return the verdict of every check on every subject."""
    model, start = graph.model, graph.states[0]
    found = {key: not states for key, states in wrong(graph).items()}
    for name, copies in _rules(model).items():
        found["consistency", name] = not any(_broken(model, start, rule) for rule in copies)
    for name in model.request:
        found["reachability", name] = any(name in edge.launched for edge in graph.edges)
    for name in _speakers(model):
        found["rule-use", name] = _is_used(graph, name)
    for name in _rules(model):
        found["redundancy", name] = name in graph.changed
    for name, mark in _deciders(model):
        found["idle-guard", name] = found.get(("idle-guard", name), False) or mark in graph.decided
    return {key: "holds" if verdict else "violated" for key, verdict in found.items()}


def wrong(graph: Graph) -> dict[tuple[str, str], set[int]]:
    """Return by check and subject the states that are wrong: a run into one of them shows the violation."""
    model = graph.model
    found: dict[tuple[str, str], set[int]] = {}
    for name, copies in _rules(model).items():
        unsafe = {k for k in graph.after for rule in copies if not _safe(model, graph.states[k], rule)}
        found["safety", name] = unsafe
        found["completeness", name] = {edge.target for edge in graph.edges if name in edge.violated}
    for name in model.request:
        found["deadlock", name] = _stuck(graph, name)
        found["lockout", name] = _locked(graph, name)
    for launch in model.launches:
        required = {k for k in graph.after if holds(model, graph.states[k], launch.condition)}
        kept = {k for k in required if launch.args in _held(graph.states[k], launch.request)}
        found["obligation", launch.name] = required - kept
    return found


def _rules(model: Model) -> dict[str, list[Rule]]:
    """Return the rules by name: those of one name are one subject."""
    found: dict[str, list[Rule]] = {}
    for rule in model.rules:
        found.setdefault(rule.name, []).append(rule)
    return found


def _broken(model: Model, state: State, rule: Rule) -> bool:
    """Return whether the F of a rule holds."""
    if rule.slot_of is None:
        return holds(model, state, rule.condition)
    params = model.request[rule.slot_of].params
    scopes = [Scope(bind(params, slot.args)) for slot in state.slots[rule.slot_of] if slot]
    return any(holds(model, state, rule.condition, scope) for scope in scopes)


def _safe(model: Model, state: State, rule: Rule) -> bool:
    if not _broken(model, state, rule):
        return True
    return rule.kind not in NEVER_AT_ALL and not _broken(model, state.idle(state.stopping()), rule)


def _is_abort(edge: Edge) -> bool:
    return isinstance(edge.event, Abort | AbortWaiting)


def _stuck(graph: Graph, name: str) -> set[int]:
    """Return the states in which the request waits and from which nothing but aborts and asks of it ends that."""
    waiting = {number for number, state in enumerate(graph.states) if state.places[name]}
    free = set(range(len(graph.states))) - waiting

    def allowed(edge: Edge) -> bool:
        return not _is_abort(edge) and not (isinstance(edge.event, Ask) and edge.event.request == name)

    return waiting - graph.backwards(free, lambda edge: name in edge.launched, allowed)


def _locked(graph: Graph, name: str) -> set[int]:
    """Return the states from which no path without abort launches the request."""
    able = graph.backwards(set(), lambda edge: name in edge.launched, lambda edge: not _is_abort(edge))
    return set(range(len(graph.states))) - able


def _held(state: State, name: str) -> list[Args]:
    place = state.places[name]
    return [slot.args for slot in state.slots[name] if slot] + ([place.args] if place else [])


def _speakers(model: Model) -> list[str]:
    """Return what an action may name: rules, guards, resources, launch rules."""
    names = [rule.name for rule in model.rules]
    names += [guard.name for request in model.requests for guard in request.guards]
    names += [resource.name for resource in model.resources]
    return list(dict.fromkeys([*names, *(launch.name for launch in model.launches)]))


def _deciders(model: Model) -> Iterable[tuple[str, tuple[str, ...]]]:
    """Yield guards and remedies by name with what is noted of a step that they decide."""
    for request in model.requests:
        for guard in request.guards:
            yield guard.name, ("reject" if guard.kind == "check" else guard.kind, guard.name)
    stocks = [(resource.name, resource.remedies, "") for resource in model.resources if resource.consumable]
    for name, remedies, own in [*((r.name, r.remedies, r.slot_of or "") for r in model.rules), *stocks]:
        for remedy in remedies:
            match remedy:
                case Kill(requests):
                    yield from ((f"{name}.kill {request}", ("kill", name, request)) for request in requests)
                case KillSlot():
                    yield f"{name}.kill {own}", ("kill", name, own)
                case Reject():
                    yield f"{name}.reject", ("reject", name)
                case Wait():
                    yield f"{name}.wait", ("wait", name)


def _is_used(graph: Graph, name: str) -> bool:
    conditions = [launch.condition for launch in graph.model.launches if launch.name == name]
    named = any(name in edge.named for edge in graph.edges)
    return named or any(holds(graph.model, state, cond) for state in graph.states for cond in conditions)
