"""What the checker of certificates takes for a step is what the reference interpreter does."""

from fractions import Fraction
from typing import Any

import pytest

from exover.certificate.check import Checker
from exover.certificate.table import decode
from exover.model.event import Invalid, Observe
from exover.model.trace import Moment, Trace, run
from exover.model.wire_reading import read_event
from exover.ocrd.compile import compile_model
from exover.ocrd.packing import pack
from exover.proofs.runs import RunWriter
from exover.proofs.statement import Statement
from tests.support.engines import DIGEST, model_of
from tests.support.events import Stream
from tests.support.fuzz import VARIED, spec_of


@pytest.mark.parametrize("seed", VARIED)
def test_answers_are_those_of_the_reference(seed: int) -> None:
    model = model_of(spec_of(seed))
    stream = Stream(model, seed)
    read = [read_event(model, line) for line, _ in stream.answered(40)]
    events = [event for event in read if not isinstance(event, Invalid)]
    table = decode(pack(compile_model(model, DIGEST).tables))
    trace = run(stream.reference, tuple(events))
    kept = [m for m in trace.moments if not _refused(m)]
    checker = Checker(table)
    state: dict[str, Any] = checker.initial
    for moment in RunWriter(Statement(model)).steps(Trace(tuple(kept))):
        now, enabled = checker.whole(_event(moment["event"]), state, [])
        assert enabled is True
        assert now.said() == moment["answers"], moment
        state = now.state


def _refused(moment: Moment) -> bool:
    """Return whether the event could not happen; a reading that is broken happens, as the worst value."""
    broken = isinstance(moment.event, Observe) and moment.event.broken
    return not broken and any(isinstance(action, Invalid) for action in moment.actions)


def _event(said: list[Any]) -> tuple[Any, ...]:
    return (*said[:3], [Fraction(value) if isinstance(value, str) else value for value in said[3]])
