"""What the run of a finding, the model and the properties add to what its check says of every subject."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

from exover.checks.finding import Finding
from exover.checks.property import BROKEN, VIOLATED, named
from exover.checks.remedy import advice
from exover.checks.shadowing import RULES, Shadows, shadows
from exover.dataclass import dataclass
from exover.loop.claim import CONTRADICTORY
from exover.model.decision import Reason
from exover.model.evaluate import bind
from exover.model.event import Args
from exover.model.expression import Cond, Param, operands
from exover.model.model import Model, Request
from exover.model.property import Atom, Formula, Properties, atoms
from exover.model.ranges import FixedComparison, decided
from exover.model.reads import Read, reads, rule_reads, users
from exover.model.semantics import Reference
from exover.model.state import Place, State
from exover.model.trace import visited
from exover.model.types import least
from exover.model.wording import named_text, value_text

MOST = 6
"""So many values are told of a moment."""
SHADOWS = 3
"""So many rules are named that decide before another."""
SEARCHED = ("rule-use", "reachability")
"""Checks whose causes are looked for in steps near the runs of other findings."""


def detailed(
    model: Model, properties: Properties, findings: Sequence[Finding], is_late: Callable[[], bool] = lambda: False
) -> Iterator[Finding]:
    """Yield the findings, those that are violated with all that is known of their causes in their messages.

    What decides before dead rules and launches is not looked for once `is_late`.
    """
    reference = Reference(model)
    dead = [each for each in findings if each.check in SEARCHED and each.verdict == "violated"][:RULES]
    looking = shadows(reference, findings) if dead and not is_late() else None
    for finding in findings:
        add = DETAILS.get(finding.check)
        if add is None or finding.verdict != "violated":
            yield finding
        else:
            near = looking if finding in dead and not is_late() else None
            yield replace(finding, message=add(_Broken(reference, properties, finding, near)))


@dataclass(frozen=True)
class _Broken:
    """A finding that is violated, with what its message can be made of."""

    reference: Reference
    properties: Properties
    finding: Finding
    near: Shadows | None
    """Looks for what decides first in steps near runs, if it is to be looked for."""

    @property
    def model(self) -> Model:
        return self.reference.model

    @cached_property
    def end(self) -> State | None:
        """The state at the end of the run, if there is one."""
        trace = self.finding.trace
        return None if trace is None else deque(visited(self.reference, trace.events), maxlen=1).pop()


def out_of_range(model: Model, properties: Properties) -> Iterator[str]:
    """Yield, in words, which comparisons of properties and assumptions ranges decide, whatever happens."""
    stated = [(f"property `{each.name}`", each.formula, each.location) for each in properties.properties]
    stated += [("an assumption", each.formula, each.location) for each in properties.assumptions]
    for what, formula, where in stated:
        for each in _decided(model, formula):
            yield f"{where.file}:{where.line}:{where.column}: in {what}, {each}"


def _decided(model: Model, formula: Formula) -> Iterator[FixedComparison]:
    yield from dict.fromkeys(each for condition in _conditions(formula) for each in decided(model, condition))


def _conditions(formula: Formula) -> Iterator[Cond]:
    return (atom.condition for atom in atoms(formula) if isinstance(atom, Atom))


# ---- by check ----


def _completeness(broken: _Broken) -> str:
    state = broken.end
    if state is None:
        return broken.finding.message
    return f"{broken.finding.message}; {advice(broken.reference, state.once_stopped(), broken.finding.subject)}"


def _property(broken: _Broken) -> str:
    """Return what the form means, beside the text of the property, and what it reads in the last moment of a run."""
    finding = broken.finding
    if CONTRADICTORY in finding.message:
        return finding.message
    prop = named(broken.properties, finding.subject)
    message = finding.message.replace(VIOLATED, BROKEN[prop.form], 1)
    parts = [f'"{prop.text}": {message}' if prop.text else message]
    state = broken.end if finding.trace is not None and finding.trace.loop_start is None else None
    if state is not None:
        parts += _there(state, (read for each in _conditions(prop.formula) for read in sorted(reads(each))))
    else:
        parts += map(str, _decided(broken.model, prop.formula))
    return "; ".join(parts)


def _rule_use(broken: _Broken) -> str:
    """Return why it never acts, if ranges tell, or what decides first."""
    model, name = broken.model, broken.finding.subject
    guards = [(request, guard) for request in model.requests for guard in request.guards if guard.name == name]
    found = [each for request, guard in guards for each in decided(model, guard.condition, request.params)]
    for rule in model.rules:
        if rule.name == name:
            found += decided(model, rule.condition, model.request[rule.slot_of].params if rule.slot_of else ())
    for launch in model.launches:
        if launch.name == name:
            found += decided(model, launch.condition)
    parts = [broken.finding.message, *map(str, dict.fromkeys(found))]
    shadowing = broken.near.of(name) if broken.near else ()
    if shadowing:
        parts.append(f"where it would, {_decide(shadowing)}")
    return "; ".join(parts)


def _reachability(broken: _Broken) -> str:
    """Return what decides where it is asked."""
    deciding, alone = broken.near.before_launch(broken.finding.subject) if broken.near else ((), ())
    parts = [broken.finding.message]
    if deciding:
        parts.append(f"where it is asked, {_decide(deciding)}")
    if alone:
        without = " or without ".join(f"`{each}`" for each in alone[:SHADOWS])
        parts.append(f"without {without} it would be launched there")
    return "; ".join(parts)


def _decide(rules: Sequence[str]) -> str:
    """Return that these rules decide."""
    first, others = ", ".join(f"`{each}`" for each in rules[:SHADOWS]), len(rules) - SHADOWS
    return f"{first} and {others} more decide" if others > 0 else f"{first} decide{'s' * (len(rules) == 1)}"


def _waiting(broken: _Broken) -> str:
    """Return by what the request waits at the end of its run."""
    state, name = broken.end, broken.finding.subject
    place = state.places[name] if state else None
    if state is None or place is None:
        return broken.finding.message
    return f"{broken.finding.message}; {_waits(broken, state, name, place)}"


def _deadlock(broken: _Broken) -> str:
    """Return by what the request waits at the end of its run, and all that wait beside it."""
    state, name = broken.end, broken.finding.subject
    others = [] if state is None else [each for each in state.places.items() if each[0] != name]
    waits = [_waits(broken, state, other, place) for other, place in others if state and place]
    return "; ".join([_waiting(broken), *waits])


def _lockout(broken: _Broken) -> str:
    """Return by what the request waits at the end of its run, or what refuses an ask of it there."""
    state, request = broken.end, broken.model.request[broken.finding.subject]
    if state is None or state.places[request.name]:
        return _waiting(broken)
    args = tuple(least(param.type) for param in request.params)
    decision = broken.reference.decide(state, request, args)
    ask = f"`{request.name}({named_text(request.params, args)})`"
    if decision.reason is None:
        return f"{broken.finding.message}; {ask} would be launched, but the assumptions leave no such step"
    word = "refused" if decision.verdict == "reject" else "kept waiting"
    return (
        f"{broken.finding.message}; {ask} is {word} by {_reason(broken.model, state, request, args, decision.reason)}"
    )


DETAILS: Mapping[str, Callable[[_Broken], str]] = {
    "completeness": _completeness,
    "property": _property,
    "rule-use": _rule_use,
    "reachability": _reachability,
    "deadlock": _deadlock,
    "lockout": _lockout,
    "starvation": _waiting,
}


# ---- moments in words ----


def _waits(broken: _Broken, state: State, name: str, place: Place) -> str:
    """Return by which rule a request waits, and what the state has of it."""
    request = broken.model.request[name]
    reason = broken.reference.decide(state, request, place.args).reason
    by = f" by {_reason(broken.model, state, request, place.args, reason)}" if reason else ""
    return f"`{name}` waits{by}"


def _reason(model: Model, state: State, request: Request, args: Args, reason: Reason) -> str:
    """Return a rule, its text, and what there is of it: all that a guard of the request reads, of a rule who is active.

    Of a consumable it is the level.
    """
    because = f" ({reason.because})" if reason.because else ""
    given: list[str] = []
    read: dict[Read, None] = {}
    for guard in request.guards:
        if guard.name == reason.rule:
            asked = dict.fromkeys(term.name for term in operands(guard.condition) if isinstance(term, Param))
            values = bind(request.params, args)
            given += [f"{name} == {value_text(values[name])}" for name in asked]
            read |= dict.fromkeys(sorted(reads(guard.condition)))
    spoken_of = [each for rule in model.rules if rule.name == reason.rule for each in sorted(rule_reads(rule))]
    for each in spoken_of:
        holders = [Read("active", name) for name in users(model, each.name)] if each.kind == "used" else [each]
        read |= dict.fromkeys(holder for holder in holders if holder.kind != "active" or state.active([holder.name]))
    if any(clause.resource == reason.rule for clause in request.consumptions):
        read[Read("level", reason.rule)] = None
    return ", ".join([f"`{reason.rule}`{because}", *_there(state, read, given)])


def _there(state: State, read: Iterable[Read], given: Sequence[str] = ()) -> list[str]:
    """Return what is given, and what a state has of what is read, as one part of a sentence, if there is anything."""
    told = [*given, *filter(None, (_text(state, each) for each in dict.fromkeys(read)))]
    more = [f"{len(told) - MOST} more"] if len(told) > MOST else []
    return [f"there {', '.join([*told[:MOST], *more])}"] if told else []


def _text(state: State, read: Read) -> str:
    match read.kind:
        case "active":
            return f"active({read.name})" if state.active([read.name]) else f"not active({read.name})"
        case "waiting":
            return f"waiting({read.name})" if state.places[read.name] else f"not waiting({read.name})"
        case "past":
            return f"past({read.name})" if state.past[read.name] is not None else f"not past({read.name})"
        case "last":
            return f"last({read.name}) == {state.last[read.name]}"
        case "level":
            return f"level({read.name}) == {state.levels[read.name]}"
        case "reading":
            return f"{read.name} == {value_text(state.readings[read.name])}"
        case "used":
            return ""
