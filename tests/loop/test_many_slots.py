"""The parts that programs share are followed once, however many slots a request has."""

from exover.engines.bdd.analysis import Analysis
from exover.engines.bdd.image import Image
from exover.loop.finite.builder import ClosedLoop
from exover.model.event import Ask
from exover.model.semantics import Reference
from exover.ocrd.memory import IDLE, RUNNING
from tests.support.engines import model_of
from tests.support.small import compiled

SPEC = """spec s;
module m {
    request a(n: int in 0 .. 3) instances %d { check not active(m.b with k > 4); }
    request b(k: int in 0 .. 9);
}
forbid f: active(m.a with n > 2) and active(m.b) by kill m.b;"""


def test_what_slots_have_in_common_is_done_once() -> None:
    """Of the ways through 40 slots, each of which is idle or not, there are too many to go them all."""
    made = compiled(model_of(SPEC % 40))
    analysis = Analysis(made, Reference(made.model), lambda what: None)
    space, loop, image = analysis.space, analysis.loop, Image(analysis.space)
    [event] = [each for each in loop.events if each.event == Ask("m.a", (0,))]
    slots = [loop.phase_index(0, slot) for slot in range(40)]
    states = space.initial
    for slot in slots:
        assert states & ~space.is_value(slot, IDLE) == space.none
        states = image.post(states, event.program)
        assert states != space.none and states & ~space.is_value(slot, RUNNING) == space.none
    assert image.post(states, event.program) == states


def test_programs_of_many_slots_are_told_apart() -> None:
    made = compiled(model_of(SPEC % 3000))
    loop = ClosedLoop(made.model, made.tables, made.entries)
    asked = [each.event for each in loop.events if isinstance(each.event, Ask)]
    assert {event.request for event in asked} == {"m.a", "m.b"}
    assert len({hash(each.program) for each in loop.events}) == len(loop.events)
