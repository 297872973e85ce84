"""Concrete events and states as values of variables, and back."""

from collections.abc import Mapping

from exover.model.event import Abort, AbortWaiting, Args, Ask, Event, Observe, Report
from exover.model.types import Bool, Enum, Int, Real, Type, Value
from exover.verify.smt.states import Layout, least
from exover.verify.smt.steps import Input, Kind, Step
from exover.verify.smt.term import Number, Term, Terms


def kind_of(layout: Layout, event: Event) -> Kind:
    """Return the kind of an event."""
    match event:
        case Ask(name):
            return Kind("ask", name)
        case Report(name, slot, outcome):
            return Kind("report", name, slot, outcome)
        case Abort(name, slot):
            return Kind("abort", name, slot)
        case AbortWaiting(name):
            return Kind("abort waiting", name)
        case Observe(name):
            return Kind("observe" if name in layout.model.variable else "observe level", name)


def inputs_of(layout: Layout, inputs: tuple[Input, ...], event: Event) -> dict[Term, Term]:
    """Return the values that an event brings."""
    match event:
        case Ask(_, args):
            values: Args = args
        case Report(_, _, _, results):
            values = results
        case Observe(_, value):
            values = (value,)
        case _:
            values = ()
    parameters = tuple(each.parameter for each in inputs)
    return dict(zip((each.var for each in inputs), layout.values(parameters, values), strict=True))


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


def after(terms: Terms, state: Mapping[Term, Term], inputs: Mapping[Term, Term], step: Step) -> dict[str, Term]:
    """Return what the variables that a step may change are after it, from these values."""
    values = {**state, **inputs}
    memory: dict[Term, Term] = {}
    return {name: terms.replaced(term, values, memory) for name, term in step.after.items()}
