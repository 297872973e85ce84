"""Concrete events and states as values of variables, and back."""

from collections.abc import Mapping

from exover.engines.smt.steps import Input, SymbolicStep
from exover.loop.exact.events import Kind
from exover.loop.exact.layout import Layout
from exover.loop.exact.term import Term, Terms
from exover.model.event import Abort, AbortWaiting, Args, Ask, Event, Observe, Report


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


def after(terms: Terms, state: Mapping[Term, Term], inputs: Mapping[Term, Term], step: SymbolicStep) -> dict[str, Term]:
    """Return what the variables that a step may change are after it, from these values."""
    values = {**state, **inputs}
    memory: dict[Term, Term] = {}
    return {name: terms.replaced(term, values, memory) for name, term in step.after.items()}
