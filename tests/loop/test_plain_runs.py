"""Runs of plain numbers are answered as the given ones, and say of a number on which side of constants it lies."""

import pytest

from exover.loop.plain_runs import PlainRuns
from exover.model.evaluate import holds
from exover.model.event import Ask, Event, Observe, Report
from exover.model.property import NO_PROPERTIES
from exover.model.semantics import Reference
from exover.model.trace import run, visited
from exover.pipeline import load_properties
from exover.source import Source
from tests.support.engines import model_of
from tests.support.events import Stream
from tests.support.generate import random_spec
from tests.support.scene import Size

SPEC = """spec s; poster wind: int in 0 .. 99 = 12; poster gust: int in 0 .. 99 = 0; poster t: real in -20 .. 120 = 20;
poster free: real = 0; poster hot: int in 0 .. 99 = 0 else 7;
module m {
    request a(x: int in -9 .. 9, v: real in 0 .. 2) returns (y: int in 5 .. 90) { check wind < 45; check v < 0.75; }
    request b(x: int in -9 .. 9) { check gust <= wind and gust > 30; check warm: t > 40; fail when hot == 50; }
    request c() { check done: past(m.a with y > 60 and x <= -3); }
}
"""


def plain(*events: Event, properties: str = "", loop_start: int | None = None) -> tuple[Event, ...]:
    model = model_of(SPEC)
    reference = Reference(model)
    asked = load_properties(Source("s.prop", f"for s; {properties}"), model).properties
    assert asked is not None
    return PlainRuns(model, asked).of(run(reference, events, loop_start), reference).events


@pytest.mark.parametrize(
    ("given", "wanted"),
    [
        (Ask("m.a", (7, 0.5)), Ask("m.a", (0, 0.0))),
        (Ask("m.a", (-7, 1.875)), Ask("m.a", (-3, 0.75))),
        (Ask("m.a", (-7, 0.75)), Ask("m.a", (-3, 0.75))),
        (Ask("m.b", (7,)), Ask("m.b", (0,))),
        (Observe("wind", 80), Observe("wind", 80)),
        (Observe("gust", 31), Observe("gust", 31)),
        (Observe("t", 113.5), Observe("t", 41.0)),
        (Observe("t", 40.0), Observe("t", 20.0)),
        (Observe("t", -3.5), Observe("t", 20.0)),
        (Observe("free", 1e300), Observe("free", 0.0)),
        (Observe("hot", 90), Observe("hot", 51)),
        (Observe("hot", 50), Observe("hot", 50)),
        (Observe("hot", 7, broken=True), Observe("hot", 7, broken=True)),
    ],
)
def test_a_number_is_the_nearest_of_those_that_nothing_tells_apart(given: Event, wanted: Event) -> None:
    assert plain(given) == (wanted,)


@pytest.mark.parametrize(("said", "wanted"), [("hot > 70", 71), ("70 <= hot", 70), ("hot < 70", 70), ("70 >= hot", 71)])
def test_properties_tell_numbers_apart(said: str, wanted: int) -> None:
    assert plain(Observe("hot", 90), properties=f"property p: never {said};") == (Observe("hot", wanted),)


def test_values_keep_their_types() -> None:
    (ask,) = plain(Ask("m.a", (7, 0.5)))
    assert isinstance(ask, Ask) and [type(value) for value in ask.args] == [int, float]
    assert all(
        type(event.value) is float
        for event in plain(Observe("t", 113.5), Observe("t", -3.5))
        if isinstance(event, Observe)
    )


@pytest.mark.parametrize(
    ("said", "given", "wanted"),
    [
        ("t > 0.5", 0.2, 0.5),
        ("t >= 0.5", 0.2, 0.4),
        ("t >= 0.5 and t > 0.45", 0.47, 0.49),
        ("t > 40.25 and t >= 40.26", 40.253, 40.251),
        ("t == 100", 100.0, 100.0),
        ("t != 1.2", 0.0, 1.1),
    ],
)
def test_a_real_has_the_digits_of_the_constant_that_it_lies_beyond(said: str, given: float, wanted: float) -> None:
    assert plain(Observe("t", given), properties=f"property p: never {said};") == (Observe("t", wanted),)


def test_a_real_has_few_digits() -> None:
    assert plain(Observe("t", -3.5), properties="property p: always t > -3;")[0] == Observe("t", -3.0)


def test_results_and_what_is_remembered_of_them_are_plain() -> None:
    events = (Ask("m.a", (4, 0.5)), Report("m.a", 0, "ok", (88,)), Ask("m.c"))
    assert plain(*events) == (Ask("m.a", (0, 0.0)), Report("m.a", 0, "ok", (61,)), Ask("m.c"))


def test_a_lasso_stays_one() -> None:
    events = (Observe("hot", 80), Ask("m.b", (3,)), Observe("hot", 90), Ask("m.b", (4,)))
    assert plain(*events[:1], *events[2:3], *events[:1], loop_start=1) == (Observe("hot", 51),) * 3


@pytest.mark.parametrize("seed", (1, 2, 6, 8, 10, 12, 15))
def test_random_runs_are_answered_alike_and_no_condition_tells_their_states_apart(seed: int) -> None:
    model = model_of(random_spec(seed, Size(launches=2)))
    reference = Reference(model)
    given = run(reference, tuple(event for event, _ in Stream(model, seed).events(80)))
    found = PlainRuns(model, NO_PROPERTIES).of(given, reference)
    conditions = [rule.condition for rule in model.rules if rule.slot_of is None]
    for one, other in zip(visited(reference, given.events), visited(reference, found.events), strict=True):
        assert [holds(model, one, each) for each in conditions] == [holds(model, other, each) for each in conditions]
