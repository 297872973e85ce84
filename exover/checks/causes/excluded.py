"""What keeps a condition from being true in any run, by its form and that of the rules, without a run."""

from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import partial

from exover.checks.causes.broken_finding import listed
from exover.loop.formula_classes import conjuncts
from exover.model.evaluate import holds
from exover.model.expression import And, Compare, Cond, Const, Count, ModelTerm, Not, Param, Status, Used
from exover.model.kleene import truth
from exover.model.model import Model, Rule, SetState
from exover.model.property import Atom, Formula, Happened, Negation, Properties
from exover.model.reads import Read, excess, reads
from exover.model.shares import most_held
from exover.model.state import State, resting
from exover.model.types import Value
from exover.model.waiting import may_wait
from exover.model.wording import condition_text, value_text

MOST_TAKING = 16
"""The greatest number of requests of a resource or a limit of which all sets are looked at."""


def facts(parts: Iterable[Formula]) -> list[Cond]:
    """Return what is true of the state where these parts of a formula are: what was launched is active."""
    found = list[Cond]()
    for part in parts:
        match part:
            case Atom(condition):
                found.append(condition)
            case Happened("launched", request):
                found.append(Status("active", request))
            case _:
                pass
    return found


def forbidden(model: Model, known: Sequence[Cond]) -> list[str]:
    """Return, as at most one part of a sentence, the rules whose conditions are true wherever all of these are."""
    true = partial(_known, model, known, _slots(known))
    rules = [each for each in model.rules if each.slot_of is None and truth(each.condition, true)]
    names = tuple(dict.fromkeys(each.name for each in rules))
    return [f"{listed(names)} forbid{'s' * (len(names) == 1)} it"] if names else []


def crowded(model: Model, known: Iterable[Cond]) -> Iterator[str]:
    """Yield, in words, the slots of the requests of which more with different arguments are to be active than that."""
    slots_of = {(each.request, each.where): None for each in known if isinstance(each, Status) and _is_slot(each)}
    for name, slots in Counter(request for request, _ in slots_of).items():
        instances = model.request[name].instances
        if slots > instances:
            yield f"`{name}` has {'one slot' if instances == 1 else f'{instances} slots'}"


def _is_slot(status: Status) -> bool:
    return status.phase != "waiting" and status.where is not None


def _slots(known: Iterable[Cond]) -> Counter[str]:
    """Return how many slots of each request are active at least: as many as one parameter has values in them."""
    slots, values = Counter[str](), defaultdict[tuple[str, ModelTerm], set[Value]](set)
    for each in known:
        if isinstance(each, Status) and each.phase != "waiting":
            slots[each.request] = max(1, slots[each.request])
            for part in each.where.parts if isinstance(each.where, And) else (each.where,):
                match part:
                    case Compare("==", Param() as term, Const(value)):
                        values[each.request, term].add(value)
                        slots[each.request] = max(len(values[each.request, term]), slots[each.request])
                    case _:
                        pass
    return slots


def unwaiting(model: Model, known: Iterable[Cond]) -> Iterator[str]:
    """Yield, in words, the requests that are to wait, but that no guard, resource or rule makes wait."""
    waiting = dict.fromkeys(each.request for each in known if isinstance(each, Status) and each.phase == "waiting")
    yield from (f"nothing makes `{name}` wait" for name in waiting if name not in may_wait(model))


def _known(model: Model, known: Sequence[Cond], slots: Counter[str], condition: Cond) -> bool | None:
    match condition:
        case _ if condition in known or Not(condition) in known:
            return condition in known
        case Status("active", request, None):
            return True if slots[request] else None
    match excess(condition):
        case Count(requests), most:
            return True if sum(slots[each] for each in requests) > most else None
        case Used(resource), most:
            return True if _held(model, slots, resource) > most else None
        case _:
            return None


def _held(model: Model, slots: Counter[str], resource: str) -> int:
    """Return the least that these slots hold of a resource together while they are active."""
    shares = ((slots[each.name], share) for each in model.requests for share in each.shares)
    return sum(count * share.amount for count, share in shares if share.resource == resource and share.when is None)


def kept(model: Model, name: str) -> Iterator[str]:
    """Yield, in words, how much of a resource or of a limit is taken at most at a time since rules exclude pairs of
    requests, if that keeps it.
    """
    for rule in model.rules_named(name):
        match excess(rule.condition):
            case Used(resource), most:
                weights = {each.name: each.instances * most_held(model, each, resource) for each in model.requests}
            case Count(requests), most:
                weights = {each: model.request[each].instances for each in requests}
            case _:
                continue
        taking = {each: weight for each, weight in weights.items() if weight}
        pairs = {pair: other.name for other, pair in _pairs(model) if pair <= taking.keys()}
        taken = _heaviest(taking, pairs.keys()) if len(taking) <= MOST_TAKING else most + 1
        if pairs and taken <= most:
            names = tuple(dict.fromkeys(pairs.values()))
            yield f"{listed(names)} leave{'s' * (len(names) == 1)} at most {taken} of {most} taken at a time"


def _pairs(model: Model) -> Iterator[tuple[Rule, frozenset[str]]]:
    """Yield the rules that exclude two requests whatever else holds, each with the two."""
    for rule in model.rules:
        match rule.condition:
            case And((Status("active", one, None), Status("active", other, None))) if rule.slot_of is None:
                yield rule, frozenset((one, other))
            case _:
                pass


def _heaviest(weights: Mapping[str, int], pairs: Collection[frozenset[str]]) -> int:
    """Return the greatest weight of requests of which no two are a pair."""
    if not weights:
        return 0
    name, *others = weights
    apart = {each: weights[each] for each in others if frozenset((name, each)) not in pairs}
    rest = {each: weights[each] for each in others}
    return max(weights[name] + _heaviest(apart, pairs), _heaviest(rest, pairs) if len(apart) < len(rest) else 0)


def unset(model: Model, known: Iterable[Cond], unlaunched: Collection[str]) -> Iterator[str]:
    """Yield the requests that alone set a module state so that one of these conditions is true, if no run launches
    any of them.
    """
    start = resting(model)
    for condition in known:
        match list(reads(condition)):
            case [Read("reading", name)] if _is_state(model, name) and not holds(model, start, condition):
                makers = [
                    request.name
                    for request in model.requests
                    for each in request.effects
                    if isinstance(each, SetState) and each.state == name
                    if holds(model, start.with_reading(name, each.value), condition)
                ]
                yield from makers if set(makers) <= set(unlaunched) else ()
            case _:
                pass


def _is_state(model: Model, name: str) -> bool:
    return name in model.variable and model.variable[name].kind == "state"


def never_fair(properties: Properties) -> Iterator[str]:
    """Yield, in words, the assumptions under which no run is fair on which some request is active."""
    for assumption in properties.assumptions if properties.fair else ():
        for each in conjuncts(assumption.formula):
            match each:
                case Negation(Happened("ended", name, where) as ended):
                    active = f"{name} is active{f' with {condition_text(where)}' if where is not None else ''}"
                    both = f"`never {condition_text(ended)}` and `assume fair reports` leave no run on which {active}"
                    yield f"{assumption.location}: {both}: if it may run for ever, leave out one of them"
                case _:
                    pass


def never_broken(model: Model, properties: Properties) -> Iterator[str]:
    """Yield, in words, the assumptions that are false wherever a poster reads its `else` value, whatever else holds."""
    start = resting(model)
    for assumption in properties.assumptions:
        wrong = list(_excluded(assumption.formula))
        read = {each.name for condition in wrong for each in reads(condition) if each.kind == "reading"}
        for poster in model.variables:
            if poster.name in read and poster.fallback is not None:
                broken = start.with_reading(poster.name, poster.fallback)
                if any(truth(each, partial(_read_alone, model, broken, poster.name)) for each in wrong):
                    then = f"`{poster.name}` is broken: then it reads {value_text(poster.fallback)}"
                    yield f"{assumption.location}: the assumption leaves no run on which {then}"


def _excluded(assumed: Formula) -> Iterator[Cond]:
    """Yield conditions on states that are false wherever a formula is true."""
    for each in conjuncts(assumed):
        match each:
            case Atom(condition):
                yield Not(condition)
            case Negation(Atom(condition)):
                yield condition
            case _:
                pass


def _read_alone(model: Model, state: State, variable: str, condition: Cond) -> bool | None:
    return holds(model, state, condition) if set(reads(condition)) == {Read("reading", variable)} else None
