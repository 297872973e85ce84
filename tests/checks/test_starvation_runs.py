"""The loop of a run on which a request starves: an observation of what is read already, where it is one idle ask."""

import pytest

from exover.checks.starvation import observing
from exover.model.event import Ask, Event, Observe, Report
from exover.model.semantics import Reference
from exover.model.trace import run
from exover.pipeline import load_properties
from exover.source import Source
from tests.support.engines import model_of

SPEC = """spec s; POSTERS
module m { state open: bool = false; request a() { wait until open; } request b() { check open; } request c(); }"""
WAIT, REFUSED = Ask("m.a"), Ask("m.b")


@pytest.mark.parametrize(
    ("posters", "assumed", "events", "loop", "last"),
    [
        ("poster p: int in 0 .. 9 = 4;", "", (WAIT, REFUSED), 1, Observe("p", 4)),
        ("", "", (WAIT, REFUSED), 1, REFUSED),
        ("poster p: bool = true;", "assume always asked(m.a) or asked(m.b);", (WAIT, REFUSED), 1, REFUSED),
        ("poster p: bool = true;", "assume never rejected(m.a);", (WAIT, REFUSED), 1, REFUSED),
        ("poster p: bool = true;", "assume always p;", (WAIT, REFUSED), 1, Observe("p", True)),
        ("poster p: bool = true;", "", (WAIT, REFUSED, REFUSED), 1, REFUSED),
        (
            "poster p: bool = true;",
            "",
            (WAIT, Ask("m.c"), Report("m.c", 0, "ok"), Ask("m.c"), Report("m.c", 0, "ok")),
            3,
            None,
        ),
    ],
)
def test_an_idle_ask_is_an_observation(
    posters: str, assumed: str, events: tuple[Event, ...], loop: int, last: Event | None
) -> None:
    model = model_of(SPEC.replace("POSTERS", posters))
    properties = load_properties(Source("s.prop", f"for s; {assumed}"), model).properties
    assert properties is not None
    reference = Reference(model)
    given = run(reference, events, loop)
    found = observing(given, reference, properties)
    assert found == run(reference, (*events[:-1], last or events[-1]), loop)
