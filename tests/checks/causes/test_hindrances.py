"""What is told of the rule that is in the way."""

from exover.checks.causes.hindrances import reason_reads
from exover.model.decision import Reason
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


def test_of_a_guard_no_idle_requests_are_told_that_would_be_in_the_way_but_those_that_would_help() -> None:
    model = model_of("""spec s; poster dark: bool = true; module m { request a(); request b(); request c();
    request go() { wait until not active(m.a, m.b); check lit: not dark and not active(m.b) or dark and active(m.c); }
    request up() { check both: active(m.a) and not dark or not active(m.a) and dark; } }""")
    reference = Reference(model)
    state = end_of(reference, (Ask("m.a", ()),))

    def told(name: str, rule: str) -> tuple[Read, ...]:
        return tuple(reason_reads(model, state, model.request[name], Reason(rule, None)))

    assert told("m.go", "m.go.wait.1") == (Read("active", "m.a"),)
    assert told("m.go", "m.go.lit") == (Read("active", "m.c"), Read("reading", "dark"))
    assert told("m.up", "m.up.both") == (Read("active", "m.a"), Read("reading", "dark"))
