"""What can happen and what the checker does then, executed symbolically: events, and the parts of a pass.

`update` is step 2 of docs/language.md section 4; `parts` are steps 3 to 5, in order.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

from exover.loop.exact.actions import TableActions, tried
from exover.loop.exact.layout import Layout, least, level_name
from exover.loop.exact.symbolic_state import SymbolicState
from exover.loop.exact.term import Number, Term
from exover.model.event import Abort, AbortWaiting, Args, Ask, Ending, Event, Observe, Report
from exover.model.model import Parameter
from exover.model.types import Bool, Enum, Int, Real, Type, Value
from exover.ocrd import tables as t

ENDINGS: tuple[Ending, ...] = ("ok", "failed", "interrupted")
RESTORING = "restoring"
"""The part of a pass before all others, where someone looks on."""


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of event: of which request, slot, poster or consumable."""

    verb: str
    name: str
    slot: int = 0
    outcome: Ending = "ok"

    def __str__(self) -> str:
        """Return what a reader calls it."""
        slot = f"[{self.slot}]" if self.verb in ("report", "abort") else ""
        return f"{self.verb} {self.name}{slot}" + (f" {self.outcome}" if self.verb == "report" else "")


@dataclass(frozen=True, slots=True)
class Part:
    """A part of a pass: one rule, one required launch, or the settling of one request; `run` does it to a frame."""

    name: str
    run: Callable[[SymbolicState], None]


def kinds(acts: TableActions) -> Iterator[Kind]:
    """Yield the kinds of events."""
    for request in acts.model.requests:
        yield Kind("ask", request.name)
    for number, request in enumerate(acts.model.requests):
        for slot in range(request.instances):
            yield from (Kind("report", request.name, slot, outcome) for outcome in ENDINGS)
            yield Kind("abort", request.name, slot)
        if acts.may_wait[number]:
            yield Kind("abort waiting", request.name)
    yield from (Kind("observe", each.name) for each in acts.model.variables if each.kind == "poster")
    yield from (Kind("observe level", each.name) for each in acts.model.resources if each.consumable)


def parameters(layout: Layout, kind: Kind) -> tuple[Parameter, ...]:
    """Return what values an event of this kind brings."""
    match kind.verb:
        case "ask":
            return layout.model.request[kind.name].params
        case "report" if kind.outcome == "ok":
            return layout.model.request[kind.name].results
        case "observe":
            return (Parameter("value", layout.model.variable[kind.name].type),)
        case "observe level":
            return (Parameter("value", layout.types[level_name(kind.name)]),)
        case _:
            return ()


def update(acts: TableActions, frame: SymbolicState, kind: Kind, values: tuple[Term, ...]) -> Term:
    """Do what an event of this kind does at once, and return where it can happen."""
    yes, layout = acts.terms.true, acts.layout
    request = acts.number.get(kind.name, -1)
    match kind.verb:
        case "ask":
            frame.note(yes, "asked", kind.name, values)
            acts.ask(frame, yes, request, values)
        case "report":
            acts.report(frame, request, kind.slot, kind.outcome, values)
            return layout.vars[layout.slots[kind.name, kind.slot].active]
        case "abort":
            frame.mark(yes, "abort")
            acts.kill(frame, yes, request, kind.slot, None)
            return layout.vars[layout.slots[kind.name, kind.slot].active]
        case "abort waiting":
            frame.mark(yes, "abort")
            taken = layout.vars[layout.places[kind.name].taken]
            acts.give_up(frame, taken, request)
            return taken
        case _:
            name = kind.name if kind.verb == "observe" else level_name(kind.name)
            frame.put(yes, name, values[0])
            acts.latch(frame, t.NONE)
    return yes


def parts(acts: TableActions) -> Iterator[Part]:
    """Yield the parts of a pass, in order; first, if someone looks on, that rules are about to be restored."""
    if acts.observer is not None:
        yield Part(RESTORING, partial(acts.observer.restores, acts))
    for number in range(len(acts.tables.rules)):
        yield Part(f"rule {number}", partial(_restore, acts, number))
    for number in range(len(acts.tables.launches)):
        yield Part(f"launch {number}", partial(_require, acts, number))
    for request in range(len(acts.tables.requests)):
        if acts.may_wait[request]:
            yield Part(f"settle {request}", partial(acts.settle, request))


def _restore(acts: TableActions, number: int, frame: SymbolicState) -> None:
    for node, here in acts.vector.walk(frame, acts.terms.true, acts.tables.rules[number].root, None):
        if node.code == -t.KILL:
            acts.kill_target(frame, here, node)


def _require(acts: TableActions, number: int, frame: SymbolicState) -> None:
    launch, rule = acts.tables.launches[number], acts.model.launches[number]
    request = acts.model.requests[launch.request]
    due = acts.vector.agrees(frame, launch.condition, None)
    guard = acts.terms.both((due, acts.terms.negation(frame[tried(number)])))
    frame.put(guard, tried(number), acts.terms.true)
    acts.ask(frame, guard, launch.request, acts.layout.values(request.params, rule.args), number)


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
    """Return the value of a type that a number stands for; of a real the double. None: any."""
    if number is None:
        return least(kind)
    match kind:
        case Bool():
            return bool(number)
        case Int():
            return int(number)
        case Enum(values):
            return values[int(number)]
        case Real():
            return float(number)
