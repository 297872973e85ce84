"""Properties cost the loop what they ask for and nothing else, and leave nothing behind."""

import gc

from exover.loop.finite.builder import ClosedLoop
from exover.model.model import Model
from exover.model.property import Properties
from exover.ocrd.compile import compile_model
from exover.pipeline import build, load_properties
from exover.source import Source
from tests.support.diagrams import check_by_diagrams
from tests.support.engines import DIGEST, model_of

SPEC = """spec s;
module m {
    request a(k: int in 0 .. 9) { interrupts self; }
    request b() { wait until not active(m.a); }
}"""
TEXT = """for s;
property one: never (asked(m.a with k == 3) and rejected(m.a with k == 3));
property two: always (asked(m.a with k == 3) implies not killed(m.b));
"""


def properties_of(model: Model, text: str) -> Properties:
    found = load_properties(Source("s.prop", text), model).properties
    assert found is not None
    return found


def test_a_loop_remembers_of_steps_what_properties_ask() -> None:
    model = model_of(SPEC)
    made = compile_model(model, DIGEST)
    plain = ClosedLoop(model, made.tables, made.entries)
    watched = ClosedLoop(model, made.tables, made.entries, properties_of(model, TEXT))
    assert not any(variable.key[0] == "happened" for variable in plain.variables)
    assert sum(variable.key[0] == "happened" for variable in watched.variables) == 3
    assert [len(each.cells) for each in plain.arguments] == [1, 1]
    assert [len(each.cells) for each in watched.arguments] == [2, 1], "3 and all others"


def test_no_set_is_left_in_a_circle_of_references() -> None:
    """CUDD complains of a manager that goes while its sets are still there, and the order in a circle is anyone's."""
    model = model_of(SPEC)
    compiled, properties = build(model).compiled, properties_of(model, TEXT)
    gc.collect()
    gc.disable()
    try:
        check_by_diagrams(compiled, properties=properties)
        gc.set_debug(gc.DEBUG_SAVEALL)
        gc.collect()
        left = {type(each).__name__ for each in gc.garbage}
    finally:
        gc.set_debug(0)
        gc.garbage.clear()
        gc.enable()
    assert not left & {"Function", "BDD", "Analysis", "Stepper", "Temporal", "Walker"}
