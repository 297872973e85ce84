"""Symbolic execution of events (`update`, step 2 of docs/language.md section 4) and of the components of a pass
(`parts`, steps 3 to 5, in order)."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial

from exover.dataclass import dataclass
from exover.loop.exact.actions import Change, Newcomer, TableActions
from exover.loop.exact.layout import Layout, level_name
from exover.loop.exact.symbolic_state import SymbolicState
from exover.loop.exact.term import Number, Term
from exover.model.event import ENDINGS, Abort, AbortWaiting, Args, Ask, Ending, Event, Observe, Report
from exover.model.model import Model, Parameter
from exover.model.state import SlotId
from exover.model.types import Bool, Enum, Int, Real, Type, Value, resting_value
from exover.ocrd.tables import NONE

RESTORING = "restoring"
"""The name of the first part of a pass if there is an observer."""


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of event: an event without its values."""

    verb: str
    name: str
    slot: int = 0
    outcome: Ending = "ok"

    @property
    def reported(self) -> SlotId | None:
        """The slot that it reports; None if it is no report."""
        return (self.name, self.slot) if self.verb == "report" else None

    def __str__(self) -> str:
        """Return its text for readers."""
        slot = f"[{self.slot}]" if self.verb in ("report", "abort") else ""
        return f"{self.verb} {self.name}{slot}" + (f" {self.outcome}" if self.verb == "report" else "")


@dataclass(frozen=True, slots=True)
class Part:
    """A part of a pass: one rule, one required launch, or the settling of one request; `run` does it to a state."""

    name: str
    run: Callable[[SymbolicState], None]


def kinds(model: Model, may_wait: Sequence[bool]) -> Iterator[Kind]:
    """Yield the kinds of events; `may_wait`: by request whether some decision lets it wait."""
    for request in model.requests:
        yield Kind("ask", request.name)
    for request, waits in zip(model.requests, may_wait, strict=True):
        for slot in range(request.instances):
            yield from (Kind("report", request.name, slot, outcome) for outcome in ENDINGS)
            yield Kind("abort", request.name, slot)
        if waits:
            yield Kind("abort waiting", request.name)
    yield from (Kind("observe", each.name) for each in model.variables if each.kind == "poster")
    yield from (Kind("observe level", each.name) for each in model.resources if each.consumable)


def parameters(model: Model, kind: Kind) -> tuple[Parameter, ...]:
    """Return the parameters of the values that an event of this kind brings."""
    match kind.verb:
        case "ask":
            return model.request[kind.name].params
        case "report" if kind.outcome == "ok":
            return model.request[kind.name].results
        case "observe":
            return (Parameter("value", model.variable[kind.name].type),)
        case "observe level":
            return (Parameter("value", Int(0, model.resource[kind.name].capacity)),)
        case _:
            return ()


def update(actions: TableActions, frame: SymbolicState, kind: Kind, values: tuple[Term, ...]) -> Term:
    """Do the update of an event of this kind, and return the condition under which the event can happen."""
    flag = enabling(actions.layout, kind)
    possible = actions.terms.true if flag is None else actions.layout.vars[flag]
    _change(actions, kind, values)(frame, actions.terms.true)
    return possible


def _change(actions: TableActions, kind: Kind, values: tuple[Term, ...]) -> Change:
    """Return the update of an event of this kind, where it can happen."""
    request = actions.number.get(kind.name, -1)
    match kind.verb:
        case "ask":
            asked = actions.noted_of("asked", Newcomer(request, values))
            return actions.sequence(asked, actions.asked(request, values))
        case "report":
            released = actions.released(request, kind.slot, kind.outcome, values)
            return actions.report(request, kind.slot, kind.outcome, released)
        case "abort":
            return actions.sequence(actions.marked("abort"), actions.kill(request, kind.slot, None))
        case "abort waiting":
            return actions.sequence(actions.marked("abort"), actions.if_waiting(request, actions.given_up(request)))
        case _:
            name = kind.name if kind.verb == "observe" else level_name(kind.name)
            return actions.sequence(actions.assigned_term(name, values[0]), actions.latched(NONE))


def enabling(layout: Layout, kind: Kind) -> str | None:
    """Return the flag that is true where an event of this kind can happen, None if it always can."""
    match kind.verb:
        case "report" | "abort":
            return layout.slots[kind.name, kind.slot].active
        case "abort waiting":
            return layout.places[kind.name].taken
        case _:
            return None


def parts(actions: TableActions) -> Iterator[Part]:
    """Yield the parts of a pass, in order; if there is an observer, first the part that calls its `restores`."""
    if actions.observer is not None:
        yield Part(RESTORING, partial(actions.observer.restores, actions))
    for number in range(len(actions.tables.rules)):
        yield _part(f"rule {number}", actions, actions.restored(number))
    for number in range(len(actions.tables.launches)):
        yield _part(f"launch {number}", actions, actions.tried(number))
    for request in range(len(actions.tables.requests)):
        if actions.may_wait[request]:
            yield _part(f"settle {request}", actions, actions.settled(request))


def _part(name: str, actions: TableActions, change: Change) -> Part:
    return Part(name, lambda frame: change(frame, actions.terms.true))


def event_of(kind: Kind, args: Args) -> Event:
    """Return the event of a kind with these values."""
    match kind.verb:
        case "ask":
            return Ask(kind.name, args)
        case "report":
            return Report(kind.name, kind.slot, kind.outcome, args)
        case "abort":
            return Abort(kind.name, kind.slot)
        case "abort waiting":
            return AbortWaiting(kind.name)
        case _:
            return Observe(kind.name, args[0])


def value_of(kind: Type, number: bool | Number | None) -> Value:
    """Return the value of a type that a number stands for, of a real the double; for None the resting value."""
    if number is None:
        return resting_value(kind)
    match kind:
        case Bool():
            return bool(number)
        case Int():
            return int(number)
        case Enum(values):
            return values[int(number)]
        case Real():
            return float(number)
