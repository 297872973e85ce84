"""What an answer may depend on: the conditions that decided it, and the quantities that they read."""

from collections.abc import Collection, Iterable, Iterator
from fractions import Fraction
from typing import Literal, assert_never

from exover.dataclass import dataclass
from exover.model.conditions import conditions
from exover.model.evaluate import Scope, bind, value_of
from exover.model.event import Action, Ask, Event, Invalid, Killed, Launched, Observe, Rejected, Report, Violated, Waits
from exover.model.expression import (
    Compare,
    Cond,
    Const,
    Level,
    ModelTerm,
    Own,
    Param,
    Past,
    Reading,
    Status,
    Sum,
    atoms,
    leaves,
)
from exover.model.model import Model
from exover.model.reads import Read, reads, rule_reads
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.types import Value

Kind = Literal["given", "reading", "level", "slot", "place", "past", "last"]
ValueKey = tuple[str, str]
"""The request and the name of a parameter or result; "" and the name of a reading or level."""


Conditions = list[tuple[Cond, str]]
"""Each with the request whose parameters it reads, or ""."""


@dataclass(frozen=True, slots=True)
class Factor:
    """A quantity on which an answer may depend; `index`: of a slot, or of a value that the event carries."""

    kind: Kind
    name: str
    index: int = 0


@dataclass(frozen=True, slots=True)
class Mention:
    """A comparison in a condition over the parameters of request `subject`; `self` refers to request `own`."""

    compare: Compare
    subject: str
    own: str


@dataclass(frozen=True)
class Relevance:
    """Conditions, each with the request whose parameters it reads (or ""), and all that they and their rules read."""

    conditions: tuple[tuple[Cond, str], ...]
    reads: frozenset[Read]

    def mentions(self) -> tuple[Mention, ...]:
        """Return the comparisons of all conditions, those inside a `where` too."""
        return tuple(mention for cond, subject in self.conditions for mention in _mentions(cond, subject, ""))


def _mentions(cond: Cond, subject: str, own: str) -> Iterator[Mention]:
    for atom in atoms(cond):
        match atom:
            case Compare():
                yield Mention(atom, subject, own)
            case Status(_, name, where) | Past(name, where) if where:
                yield from _mentions(where, name, subject)
            case _:
                pass


def compared(mentions: Iterable[Mention]) -> frozenset[ValueKey]:
    """Return the parameters and results that comparisons read."""
    sides = [(mention, side) for mention in mentions for side in (mention.compare.left, mention.compare.right)]
    keys = {_key(mention, term) for mention, side in sides for term in leaves(side)}
    return frozenset(key for key in keys if key and key[0])


def compared_anywhere(model: Model) -> frozenset[ValueKey]:
    """Return the parameters and results with which anything in a model is compared: arguments of required launches
    are with those that are active or wait.
    """
    every = ((condition, subject or "") for subject, condition in conditions(model))
    return compared(mention for condition, subject in every for mention in _mentions(condition, subject, ""))


# ---- what was in question ----


def concern_of(reference: Reference, state: State, event: Event, actions: Iterable[Action]) -> Relevance:
    """Return what the answer to an event may depend on.

    For an ask: what decides its request. Otherwise what the rules and requests of the actions read; if there are none,
    what any rule, launch rule or waiting request reads.
    """
    model = reference.model
    requests, rules = _spoken(actions)
    if isinstance(event, Ask):
        requests, rules = {event.request}, set()
    elif not requests and not rules:
        requests = {name for name, place in state.places.items() if place}
        rules = {rule.name for rule in model.rules} | {launch.name for launch in model.launches}
    conditions, named = _of_names(model, rules)
    for name in requests:
        request = model.request[name]
        conditions += [(guard.condition, name) for guard in request.guards]
        conditions += [(clause.when, name) for clause in request.consumptions if clause.when]
        conditions += [(share.when, name) for share in request.shares if share.when]
        conditions += [(rule.condition, rule.slot_of or "") for rule in reference.questions[name]]
        named |= {Read("active", name), Read("waiting", name)}
        named |= {Read("level", clause.resource) for clause in request.consumptions}
        named |= {read for rule in reference.questions[name] for read in rule_reads(rule)}
    return _concern(model, state, conditions, named)


def concern_of_names(model: Model, state: State, names: Iterable[str]) -> Relevance:
    """Return the conditions of the rules, guards, resources and launch rules of these names, and what they read."""
    return _concern(model, state, *_of_names(model, frozenset(names)))


def _of_names(model: Model, names: Collection[str]) -> tuple[Conditions, set[Read]]:
    """Return the conditions of the items of these names, and what the rules and resources among them read besides."""
    launches = [launch for launch in model.launches if launch.name in names]
    found: Conditions = [(launch.condition, "") for launch in launches]
    for request in model.requests:
        found += [(guard.condition, request.name) for guard in request.guards if guard.name in names]
    rules = [rule for rule in model.rules if rule.name in names]
    found += [(rule.condition, rule.slot_of or "") for rule in rules]
    named = {read for rule in rules for read in rule_reads(rule)}
    named |= {Read(kind, launch.request) for launch in launches for kind in ("active", "waiting")}
    return found, named | {Read("level", name) for name in model.resource if name in names}


def _concern(model: Model, state: State, conditions: Conditions, named: set[Read]) -> Relevance:
    named = named | {read for cond, _ in conditions for read in reads(cond)}
    conditions = conditions + [(latch.condition, "") for latch in model.latches if Read("reading", latch.name) in named]
    return Relevance(tuple(dict.fromkeys(conditions)), frozenset(_spread(model, state, named)))


def _spoken(actions: Iterable[Action]) -> tuple[set[str], set[str]]:
    """Return the requests that were decided, and the rules that the actions name."""
    requests: set[str] = set()
    rules: set[str] = set()
    for action in actions:
        match action:
            case Launched(name, launch_rule=required):
                requests.add(name)
                rules |= {required} if required else set()
            case Waits(name, rule, launch_rule=required) | Rejected(name, rule, launch_rule=required):
                requests.add(name)
                rules |= {rule, required} if required else {rule}
            case Killed(_, _, rule) | Violated(rule):
                rules.add(rule)
            case Invalid():
                pass
            case _:
                assert_never(action)
    return requests, rules


def _spread(model: Model, state: State, named: set[Read]) -> set[Read]:
    """Return the reads, and those on which they depend: users of resources, conditions of latches, clearing places."""
    found = set(named)
    for latch in model.latches:
        if Read("reading", latch.name) in found:
            found |= reads(latch.condition)
    for request in model.requests:
        if any(Read("used", share.resource) in found for share in request.shares):
            found.add(Read("active", request.name))
        place = state.places[request.name]
        if place and place.clearing and Read("active", request.name) in found:
            found.add(Read("waiting", request.name))
    return found


def quantities(state: State, event: Event, concern: Relevance) -> tuple[Factor, ...]:
    """Return the quantities that are read: first the values of the event, then each kind in the order of the spec."""
    found: list[Factor] = []
    match event:
        case Ask(name, args):
            found += [Factor("given", name, index) for index in range(len(args))]
        case Observe(name):
            found.append(Factor("given", name))
        case Report(name, _, "ok", results):
            found += [Factor("given", name, index) for index in range(len(results))]
        case _:
            pass
    observed = event.name if isinstance(event, Observe) else None
    wanted = concern.reads
    found += [
        Factor("reading", name) for name in state.readings if name != observed and Read("reading", name) in wanted
    ]
    found += [Factor("level", name) for name in state.levels if name != observed and Read("level", name) in wanted]
    for name in state.slots:
        if Read("active", name) in wanted:
            found += [Factor("slot", name, index) for index in range(len(state.slots[name]))]
    found += [Factor("place", name) for name in state.places if Read("waiting", name) in wanted]
    found += [Factor("past", name) for name in state.past if Read("past", name) in wanted]
    found += [Factor("last", name) for name in state.last if Read("last", name) in wanted]
    return tuple(found)


# ---- where a number makes a difference ----


def cuts(model: Model, state: State, event: Event, mentions: Iterable[Mention], key: ValueKey) -> set[Fraction]:
    """Return the values of a number at which the truth of some comparison changes, all else being equal.

    A comparison with parameters of a request has a cut for each tuple of arguments that the request holds. The value
    that the event observes is taken as read already.
    """
    if isinstance(event, Observe):
        state = state.with_observed(event.name, event.value)
    found: set[Fraction] = set()
    for mention in mentions:
        terms = [*_linear(mention.compare.left, 1), *_linear(mention.compare.right, -1)]
        slope = sum(factor for factor, term in terms if _key(mention, term) == key)
        if slope == 0:
            continue
        others = [(factor, term) for factor, term in terms if _key(mention, term) != key]
        for params in _held(model, state, event, mention.subject):
            for own in _held(model, state, event, mention.own):
                rest = sum(factor * _number(model, state, term, Scope(params, own)) for factor, term in others)
                found.add(Fraction(-rest, slope))
    return found


def _held(model: Model, state: State, event: Event, name: str) -> list[dict[str, Value]]:
    """Return the arguments that a request has in the event, in slots, in its waiting place and in its past."""
    if not name:
        return [{}]
    request, place, past = model.request[name], state.places[name], state.past[name]
    held = [event.args] if isinstance(event, Ask) and event.request == name else []
    held += [slot.args for slot in state.slots[name] if slot]
    held += [place.args] if place else []
    found = [bind(request.params, args) for args in held]
    found += [] if past is None else [bind(request.params + request.results, past)]
    return found or [{}]


def _linear(term: ModelTerm, sign: int) -> Iterator[tuple[int, ModelTerm]]:
    """Yield the leaves of a linear term with their factors; the constant summand is a leaf."""
    match term:
        case Sum(constant, terms):
            yield sign, Const(constant)
            for factor, part in terms:
                yield from _linear(part, sign * factor)
        case _:
            yield sign, term


def _key(mention: Mention, term: ModelTerm) -> ValueKey | None:
    match term:
        case Param(name):
            return mention.subject, name
        case Own(name):
            return mention.own, name
        case Reading(name) | Level(name):
            return "", name
        case _:
            return None


def _number(model: Model, state: State, term: ModelTerm, scope: Scope) -> Fraction:
    """Return the value of a leaf as a number; 0 if it has none in this scope, or is no number."""
    if (isinstance(term, Param) and term.name not in scope.params) or (
        isinstance(term, Own) and term.name not in scope.own
    ):
        return Fraction(0)
    value = value_of(model, state, term, scope)
    return Fraction(value) if isinstance(value, int | float) else Fraction(0)
