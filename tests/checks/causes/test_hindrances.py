"""What is told of the rule that is in the way."""

from exover.checks.causes.hindrances import reason_reads
from exover.model.event import Ask
from exover.model.reads import Read
from exover.model.semantics import Reference
from exover.model.trace import end_of
from tests.support.engines import model_of


def test_a_request_for_which_the_way_is_cleared_is_told_to_wait() -> None:
    model = model_of("spec s; module m { request a(); request b(); request stop() { interrupts m.a, m.b; } }")
    reference, request = Reference(model), model.request["m.b"]
    state = end_of(reference, (Ask("m.a", ()), Ask("m.stop", ())))
    reason = reference.decide(state, request, ()).reason
    assert reason is not None and reason.rule == "m.stop.interrupts.m.b"
    assert reason_reads(model, state, request, reason) == (Read("waiting", "m.stop"),)
