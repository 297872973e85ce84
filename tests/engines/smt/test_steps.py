"""The steps of the formulas are those of the reference interpreter, from every state that random events lead to."""

import pytest

from exover.engines.smt.concretize import inputs_of
from exover.engines.smt.solver import Clock, Prover
from exover.engines.smt.steps import SymbolicStep, SymbolicSteps
from exover.loop.exact.actions import TableActions
from exover.loop.exact.events import Kind
from exover.loop.exact.layout import Layout
from exover.loop.exact.table_encoding import TableEncoding
from exover.loop.exact.term import Term, Terms
from exover.model.event import Abort, AbortWaiting, Ask, Event, Invalid, Launched, Observe, Rejected, Report
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.wire_reading import read_event
from exover.ocrd.compile import Compiled
from tests.support.engines import model_of
from tests.support.events import Stream
from tests.support.generate import random_spec
from tests.support.scene import Size
from tests.support.small import VARIED, compiled, small_spec_of

EVENTS = 120


def steps_of(made: Compiled) -> SymbolicSteps:
    """Return the steps of a loop."""
    return SymbolicSteps(TableActions(TableEncoding(Layout(made.model, Terms()), made.tables)), Prover(Clock()))


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


def walked(spec: str, seed: int) -> int:
    """Take random steps, and the same ones by the formulas; return how many there were."""
    made = compiled(model_of(spec))
    steps, reference = steps_of(made), Reference(made.model)
    by_kind = {step.kind: step for step in steps.all}
    state, taken = reference.start(), 0
    for line in Stream(made.model, seed).lines(EVENTS):
        event = read_event(made.model, line)
        if not isinstance(event, Invalid):
            step = by_kind.get(kind_of(steps.layout, event))
            before, (state, _) = state, reference.step(state, event)
            if step is not None:  # else nothing ever waits there
                taken += compared(steps.layout, step, before, event, reference)
    return taken


def compared(layout: Layout, step: SymbolicStep, state: State, event: Event, reference: Reference) -> bool:
    """Compare one step; return whether the event can happen."""
    terms = layout.terms
    target, actions = reference.step(state, event)
    present = {layout.vars[name]: value for name, value in layout.of_state(state).items()}
    values = {**present, **inputs_of(layout, step.inputs, event)}

    def now(term: Term) -> Term:
        return terms.replaced(term, values)

    faults = {action.code for action in actions if isinstance(action, Invalid)}
    possible = not faults & {"not-active", "nothing-to-abort"}
    assert now(step.enabled) is terms.truth(possible), event
    if not possible:
        return False
    wanted = layout.of_state(target)
    found = {name: now(step.after[name]) if name in step.after else present[layout.vars[name]] for name in wanted}
    different = {n: (found[n], wanted[n]) for n in wanted if found[n] is not wanted[n] and layout.counts(n, wanted)}
    assert not different, f"{state}\n{event}\n{different}"
    launches = {label[1] for label, where in step.marks.items() if label[0] == "launch" and now(where) is terms.true}
    assert launches == {action.request for action in actions if isinstance(action, Launched)}
    rejections = {
        note.request for note in step.notes if note.occurrence == "rejected" and now(note.guard) is terms.true
    }
    answered = {action.request for action in actions if isinstance(action, Rejected)}
    # A required launch that stays refused is rejected, and not answered again.
    assert answered <= rejections <= answered | {launch.request for launch in layout.model.launches}
    return True


@pytest.mark.parametrize("seed", VARIED)
def test_small_specs(seed: int) -> None:
    assert walked(small_spec_of(seed), seed)


def test_what_is_produced_fills_no_more_than_there_is_room_for() -> None:
    requests = "request r() { produces p 2; } request s() { consumes p 2; }"
    assert walked(f"spec full;\nresource p: 3 consumable = 2;\nmodule m {{ {requests} }}", 0)


@pytest.mark.parametrize("seed", (0, 2))
def test_larger_specs(seed: int) -> None:
    size = Size(requests=4, rules=4, clauses=3, instances=2, readings=4)
    assert walked(random_spec(seed, size), seed)
