"""The moments of the runs of a small model, one by one (docs/language.md section 8).

A moment is a state and what the step that led to it did, as far as the formulas at hand ask for it. Nothing is shared
with the engines but the model and the reference interpreter.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain

from exover.model.evaluate import Scope, bind, holds
from exover.model.event import AbortWaiting, Action, Args, Ask, Event, Killed, Launched, Rejected, Report
from exover.model.expression import FALSE, And, Cond, Status
from exover.model.model import Launch, Model, Reject, Rule
from exover.model.property import (
    Atom,
    Conjunction,
    Disjunction,
    Formula,
    Happened,
    Negation,
    Occurrence,
    Properties,
    atoms,
)
from exover.model.semantics import Reference, Step
from exover.model.state import SlotId, State
from tests.support.oracle import Graph, explore

Fact = tuple[Occurrence, str, Args]
"""An occurrence, the request, and the arguments it had."""


@dataclass(frozen=True, slots=True)
class Moment:
    """A state by its number, which of the formulas' step predicates hold, and which slots were reported."""

    state: int
    happened: frozenset[Happened] = frozenset()
    reported: frozenset[SlotId] = frozenset()


@dataclass(frozen=True, slots=True)
class Move:
    """A step: what it asks for to be seen, and the state after it."""

    event: Event
    target: int
    happened: frozenset[Happened]
    reported: frozenset[SlotId]


@dataclass
class Moments:
    """All moments of the runs that the assumptions leave, the start first; `after[k]`: those one step behind k."""

    model: Model
    states: list[State]
    fair: bool
    moments: list[Moment] = field(default_factory=list)
    after: list[list[int]] = field(default_factory=list)
    events: dict[tuple[int, int], Event] = field(default_factory=dict)
    """An event that leads from one moment to another."""

    @property
    def everything(self) -> set[int]:
        """The numbers of all moments."""
        return set(range(len(self.moments)))

    @property
    def dead(self) -> set[int]:
        """The moments that no step leaves: the assumptions contradict each other there."""
        return {number for number, after in enumerate(self.after) if not after}

    @cached_property
    def before(self) -> list[list[int]]:
        """The moments one step before each."""
        found: list[list[int]] = [[] for _ in self.moments]
        for source, targets in enumerate(self.after):
            for target in targets:
                found[target].append(source)
        return found

    @cached_property
    def constraints(self) -> list[set[int]]:
        """Sets of moments, each of which a fair run visits again and again: a slot is idle or just reported."""
        if not self.fair:
            return []
        return [
            {
                number
                for number, moment in enumerate(self.moments)
                if self.states[moment.state].slots[request.name][slot] is None
                or (request.name, slot) in moment.reported
            }
            for request in self.model.requests
            for slot in range(request.instances)
        ]

    def true(self, formula: Formula) -> set[int]:
        """Return the moments in which a formula without temporal operators is true."""
        return {number for number, moment in enumerate(self.moments) if _true(self, moment, formula)}


def _true(of: Moments, moment: Moment, formula: Formula) -> bool:
    match formula:
        case Atom(condition):
            return holds(of.model, of.states[moment.state], condition)
        case Happened():
            return formula in moment.happened
        case Negation(part):
            return not _true(of, moment, part)
        case Conjunction(parts):
            return all(_true(of, moment, part) for part in parts)
        case Disjunction(parts):
            return any(_true(of, moment, part) for part in parts)
        case _:
            raise AssertionError(f"{formula} has a temporal operator")


def moments_of(model: Model, properties: Properties, most_states: int, most_steps: int) -> Moments:
    """Return the moments of a model under the assumptions; raises `TooLarge` if there are too many states or steps.

    All atoms of the properties and assumptions can be evaluated in them.
    """
    formulas = [each.formula for each in (*properties.properties, *properties.assumptions)]
    formulas += [each.premise for each in properties.properties if each.premise is not None]
    asked = list(dict.fromkeys(chain.from_iterable(atoms(formula) for formula in formulas)))
    graph = explore(looked_at(model, asked), most_states, most_steps)
    moves = _moves(graph, [atom for atom in asked if isinstance(atom, Happened)])
    found = Moments(model, graph.states, properties.fair)
    number = {Moment(0): 0}
    found.moments.append(Moment(0))
    for source, moment in enumerate(found.moments):
        targets: dict[int, Event] = {}
        for move in moves[moment.state]:
            after = Moment(move.target, move.happened, move.reported if properties.fair else frozenset())
            if all(_true(found, after, each.formula) for each in properties.assumptions):
                target = number.setdefault(after, len(found.moments))
                if target == len(found.moments):
                    found.moments.append(after)
                targets.setdefault(target, move.event)
        found.after.append(list(targets))
        found.events |= {(source, target): event for target, event in targets.items()}
    return found


def looked_at(model: Model, asked: Iterable[Atom | Happened]) -> Model:
    """Return the model with a rule that is never broken and names all atoms, so that the search tells them apart."""
    conditions: list[Cond] = [
        atom.condition if isinstance(atom, Atom) else Status("active", atom.request, atom.where) for atom in asked
    ]
    place = 1 + max((rule.place for rule in model.rules), default=0)
    rule = Rule("looked at", "forbid", And((FALSE, *conditions)), (Reject(),), None, place)
    return replace(model, rules=(*model.rules, rule))


# ---- what a step did ----


def _moves(graph: Graph, predicates: list[Happened]) -> list[list[Move]]:
    """Return the steps out of each state."""
    found: list[list[Move]] = [[] for _ in graph.states]
    for edge in graph.edges:
        event = edge.event
        happened = happening(graph.model, graph.states[edge.source], event, predicates)
        reported = frozenset({(event.request, event.slot)}) if isinstance(event, Report) else frozenset()
        found[edge.source].append(Move(event, edge.target, happened, reported))
    return found


def happening(model: Model, before: State, event: Event, predicates: Iterable[Happened]) -> frozenset[Happened]:
    """Return those of the predicates that the step by this event makes true."""
    facts, start = list(_facts(model, before, event)), Reference(model).start()
    return frozenset(each for each in predicates if any(_is(model, start, each, fact) for fact in facts))


def _is(model: Model, start: State, predicate: Happened, fact: Fact) -> bool:
    occurrence, request, args = fact
    if (predicate.occurrence, predicate.request) != (occurrence, request):
        return False
    scope = Scope(bind(model.request[request].params, args))
    return predicate.where is None or holds(model, start, predicate.where, scope)


def _facts(model: Model, before: State, event: Event) -> Iterator[Fact]:
    """Yield everything that one step asked, launched, rejected, killed or ended."""
    reference = _Watched(model)
    _, actions = reference.step(before.unrefused(), event)
    if isinstance(event, Ask):
        yield "asked", event.request, event.args
    if isinstance(event, Report):
        ended = before.slots[event.request][event.slot]
        assert ended is not None, "the event is valid"
        yield "ended", event.request, ended.args
    yield from (("rejected", name, args) for name, args in reference.rejected)
    launched: dict[SlotId, Args] = {}
    for action in actions:
        match action:
            case Launched(name, slot, args):
                launched[name, slot] = args
                yield "launched", name, args
            case Killed(name, slot):
                old = before.slots[name][slot]
                args = launched.get((name, slot)) or (old.args if old else ())
                yield "killed", name, args


@dataclass(frozen=True)
class _Watched(Reference):
    """The reference interpreter, which notes the arguments of what it rejects: the answers do not carry them.

    They are those of the newcomer, unless the waiting place was emptied: then those that stood there.
    """

    rejected: list[tuple[str, Args]] = field(default_factory=list)

    def _update(self, step: Step, event: Event) -> Step:
        if isinstance(event, AbortWaiting):
            self._note(step, Rejected(event.request, "aborted"), None)
        return super()._update(step, event)

    def _ask(self, step: Step, name: str, args: Args, required: Launch | None = None) -> Step:
        after = super()._ask(step, name, args, required)
        for action in after.actions[len(step.actions) :]:
            is_newcomer = isinstance(action, Rejected) and action.request == name and action.rule != "superseded"
            self._note(step, action, args if is_newcomer else None)
        return after

    def _settle(self, step: Step) -> Step:
        after = super()._settle(step)
        for action in after.actions[len(step.actions) :]:
            self._note(step, action, None)
        return after

    def _note(self, step: Step, action: Action, args: Args | None) -> None:
        """Note a rejection; without arguments it is that of what stood in the waiting place before."""
        if isinstance(action, Rejected):
            place = step.state.places[action.request]
            assert args is not None or place is not None, "what is rejected asked or waited"
            self.rejected.append((action.request, args if args is not None or place is None else place.args))
