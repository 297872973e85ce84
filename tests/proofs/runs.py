"""Random runs whose events can happen, and a spec of reals."""

from exover.model.event import Invalid, Observe
from exover.model.trace import Moment, run
from exover.model.wire_reading import read_event
from tests.support.engines import model_of
from tests.support.events import Stream

REALS = """spec reals;
poster limit: real in 0 .. 10 = 5;
poster speed: real in 0 .. 10 = 0;
module m {
    request ahead(v: real in 0 .. 10) { wait until v <= limit; fail late: when v > speed; }
    request back(v: real in 0 .. 10, w: real in 0 .. 10) { wait until speed <= limit; }
    request rest() { check past(m.back with v < 3) and speed < 8; wait until not active(m.back with v < w); }
}
"""


def steps(text: str, seed: int) -> list[Moment]:
    """Return the moments of a random run whose events can happen; a reading that is broken does, as the worst value."""
    stream = Stream(model_of(text), seed)
    read = [read_event(stream.model, line) for line, _ in stream.answered(60)]
    moments = run(stream.reference, tuple(event for event in read if not isinstance(event, Invalid))).moments
    return [
        moment
        for moment in moments
        if (isinstance(moment.event, Observe) and moment.event.broken)
        or not any(isinstance(action, Invalid) for action in moment.actions)
    ]
