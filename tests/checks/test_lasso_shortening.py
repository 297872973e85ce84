"""Lassos that are shortened by the reference: no step can be dropped, nor two, and nothing happens that need not."""

from random import Random

import pytest

from exover.checks.lasso_shortening import shortened
from exover.checks.questions import property as property_check
from exover.checks.questions import starvation
from exover.checks.run import check_all
from exover.checks.schedule.engines import Engines
from exover.checks.schedule.examination import Examination
from exover.checks.schedule.plan import CheckPlan
from exover.loop.claim import Claim
from exover.model.event import Abort, AbortWaiting, Ask, Event, Invalid, Observe, Report
from exover.model.expression import Status
from exover.model.model import Model
from exover.model.property import (
    NO_PROPERTIES,
    Atom,
    Formula,
    Happened,
    Negation,
    Occurrence,
    Until,
    all_always,
    all_finally,
    all_until,
    always,
    finally_,
    implies,
)
from exover.model.semantics import Reference
from exover.model.trace import Trace, run
from exover.pipeline import load_properties
from exover.source import Source
from tests.support.engines import model_of
from tests.support.events import Stream
from tests.support.small import compiled, small_spec_of
from tests.support.words import word_of

SPEC = """spec s; POSTERS
module m { state open: bool = false; request a() { wait until open; } request b() { check open; } request c(); }"""
WAIT, REFUSED, START, END = Ask("m.a"), Ask("m.b"), Ask("m.c"), Report("m.c", 0, "ok")
POSTER = "poster p: bool = true;"
REQUIRED = f"{POSTER} launch again: m.b() when not p;"
"""Whether b is rejected the answers do not always tell then."""
READ = Observe("p", True)


@pytest.mark.parametrize(
    ("posters", "assumed", "events", "loop", "wanted"),
    [
        ("poster p: int in 0 .. 9 = 4;", "", (WAIT, REFUSED), 1, (WAIT, Observe("p", 4))),
        ("", "", (WAIT, REFUSED), 1, (WAIT, REFUSED)),
        (POSTER, "assume always asked(m.a) or asked(m.b);", (WAIT, REFUSED), 1, (WAIT, REFUSED)),
        (POSTER, "assume never rejected(m.a);", (WAIT, REFUSED), 1, (WAIT, READ)),
        (POSTER, "assume always p;", (WAIT, REFUSED), 1, (WAIT, READ)),
        (POSTER, "", (WAIT, REFUSED, REFUSED), 1, (WAIT, READ)),
        (POSTER, "", (WAIT, START, END, START, END), 3, (WAIT, READ)),
        (POSTER, "", (*(START, END) * 7, WAIT, READ), 15, (WAIT, READ)),
        (POSTER, "", (WAIT, *(REFUSED, START, REFUSED, END) * 3, READ), 13, (WAIT, READ)),
        ("", "", (WAIT, WAIT), 1, (WAIT, WAIT)),
        (POSTER, "", (WAIT, WAIT), 1, (WAIT, READ)),
        ("", "", (START, END, WAIT, START, END), 3, (START, END, WAIT, START, END)),
        ("", "assume always active(m.c);", (START, WAIT, REFUSED), 2, (START, WAIT, REFUSED)),
    ],
)
def test_of_a_starvation_what_is_left_is_one(
    posters: str, assumed: str, events: tuple[Event, ...], loop: int, wanted: tuple[Event, ...]
) -> None:
    model = model_of(SPEC.replace("POSTERS", posters))
    properties = load_properties(Source("s.prop", f"for s; {assumed}"), model).properties
    assert properties is not None
    reference = Reference(model)
    given = run(reference, events, loop)
    found = shortened(given, reference, starvation.claim(model, properties, "m.a"), properties)
    assert found.events == wanted
    assert found == run(reference, found.events, found.loop_start)


@pytest.mark.parametrize(
    ("posters", "said", "events", "loop", "wanted"),
    [
        ("", "ltl G !rejected(m.b)", (START, REFUSED, END, START, END), 3, (START, REFUSED, START)),
        (POSTER, "ltl G !rejected(m.b)", (START, REFUSED, END, REFUSED), 3, (REFUSED, READ)),
        (
            POSTER,
            "ltl G (rejected(m.b) -> X !asked(m.c))",
            (REFUSED, START, END, REFUSED),
            3,
            (REFUSED, START, READ),
        ),
        (
            POSTER,
            "always (active(m.c) leads to waiting(m.a))",
            (REFUSED, START, REFUSED),
            2,
            (START, READ),
        ),
        (POSTER, "not active(m.c) until waiting(m.a)", (REFUSED, START, END, REFUSED), 3, (READ,)),
        (
            "poster p: int in 0 .. 9 = 4;",
            "ltl G (active(m.c) -> (running(m.c) U !active(m.c)))",
            (Observe("p", 7), START, Abort("m.c", 0), WAIT, AbortWaiting("m.a"), END, Observe("p", 7)),
            6,
            (START, Observe("p", 4)),
        ),
        (POSTER, "ctl AF EG active(m.c)", (REFUSED, REFUSED), 1, (REFUSED, REFUSED)),
        (REQUIRED, "ltl G (asked(m.c) -> rejected(m.b))", (REFUSED, START, REFUSED), 2, (REFUSED, START, REFUSED)),
    ],
)
def test_of_a_property_what_is_left_violates_it(
    posters: str, said: str, events: tuple[Event, ...], loop: int, wanted: tuple[Event, ...]
) -> None:
    model = model_of(SPEC.replace("POSTERS", posters))
    properties = load_properties(Source("s.prop", f"for s; property q: {said};"), model).properties
    assert properties is not None
    reference = Reference(model)
    given = run(reference, events, loop)
    claim = property_check.claim(model, properties, "q")
    found = shortened(given, reference, claim, properties)
    assert found.events == wanted
    assert found == run(reference, found.events, found.loop_start)
    if claim.linear:
        assert claim.formula is not None
        assert not word_of(model, found, [claim.formula]).satisfies(claim.formula)


def test_what_keeps_a_request_waiting_for_ever_comes_before_it_asks() -> None:
    """Then nothing else has to keep it waiting until that comes."""
    needs = "poster p: bool = true; module m { request a() { wait until p; } request b(); } mutex m.a, m.b by wait;"
    low = Observe("p", False)
    found = of_starvation(f"spec s; {needs}", (Ask("m.b"), WAIT, low, Report("m.b", 0, "ok"), low), 4, "m.a")
    assert (found.events, found.loop_start) == ((low, WAIT, low), 2)


def test_a_loop_begins_earlier_where_an_outcome_is_as_in_the_loop() -> None:
    a, b, c = Ask("m.a"), Ask("m.b"), Ask("m.c")
    a_ends, b_ends, b_fails = Report("m.a", 0, "ok"), Report("m.b", 0, "ok"), Report("m.b", 0, "failed")
    events = (b, c, a, b_fails, b, a_ends, *(a, b_ends, b, a_ends) * 2)
    spec = "spec s; module m { request a(); request b(); request c(); } mutex m.a, m.b, m.c by wait;"
    found = of_starvation(spec, events[:-2], 8, "m.c")
    assert (len(found.events), found.loop_start) == (10, 6)


RESTLESS = """spec s; poster p: bool = true;
module m {
    state high: bool = false;
    request up() { check not high; on ok set high = true; } request down() { check high; on ok set high = false; }
    request a(); request b();
}"""


def test_once_a_prefix_violates_a_property_what_is_active_is_reported_and_nothing_more_happens() -> None:
    """The loop of the given lasso violates it, too; in no moment of it all is idle."""
    model = model_of(RESTLESS)
    said = "for s; property q: ltl G !(launched(m.down) and active(m.a) and active(m.b)); assume fair reports;"
    properties = load_properties(Source("s.prop", said), model).properties
    assert properties is not None
    reference = Reference(model)
    a, b, up, down = (Ask(f"m.{name}") for name in ("a", "b", "up", "down"))
    a_ends, b_ends, up_ends, down_ends = (Report(each.request, 0, "ok") for each in (a, b, up, down))
    begun, turn = (a, b, up, up_ends, down), (a_ends, a, down_ends, b_ends, b, up, up_ends, down)
    given = run(reference, (*begun, *turn, *turn), len(begun + turn))
    found = shortened(given, reference, property_check.claim(model, properties, "q"), properties)
    assert (found.events[5:], found.loop_start) == ((down_ends, a_ends, b_ends, READ), 8)
    assert set(found.events[:5]) == set(begun)


@pytest.mark.parametrize(
    ("said", "begun", "wanted"),
    [
        ("ltl G p", (Observe("p", False),), (Observe("p", False), Observe("p", False))),
        ("ltl G !launched(m.c); assume fair reports", (START,), (START, END, READ)),
        ("ltl G !launched(m.c); assume always active(m.c)", (START, WAIT), (START, READ)),
        ("ltl G !launched(m.c); assume never (p and not asked(m.c))", (START,), (START,)),
    ],
)
def test_a_run_that_violates_a_formula_whatever_follows_goes_on_at_rest_if_it_may(
    said: str, begun: tuple[Event, ...], wanted: tuple[Event, ...]
) -> None:
    model = model_of(SPEC.replace("POSTERS", POSTER))
    properties = load_properties(Source("s.prop", f"for s; property q: {said};"), model).properties
    assert properties is not None
    ((check, question),) = CheckPlan({"property"}, properties).questions(model)
    finding = question.violated("it is false", run(Reference(model), begun))
    found = Examination(compiled(model), properties).confirmed(check, finding).trace
    assert found == run(Reference(model), wanted, None if wanted == begun else len(wanted) - 1)


def of_starvation(spec: str, events: tuple[Event, ...], loop: int, request: str) -> Trace:
    """Return what is left of a lasso on which a request starves."""
    model = model_of(spec)
    reference = Reference(model)
    claim = starvation.claim(model, NO_PROPERTIES, request)
    return shortened(run(reference, events, loop), reference, claim, NO_PROPERTIES)


def test_what_a_monitor_of_aig_has_guessed_is_left_out() -> None:
    model = model_of("spec s; poster e: bool = false; module m { request a(); request b(); }")
    said = "for s; property q: ctl AG (active(m.a) -> A [active(m.a) W ended(m.b)]);"
    properties = load_properties(Source("s.prop", said), model).properties
    assert properties is not None
    findings = check_all(
        compiled(model), lambda what: None, CheckPlan(properties=properties, engines=Engines(("aig",)))
    ).findings
    (trace,) = (each.trace for each in findings if each.check == "property")
    assert trace is not None and len(trace.moments) == 3


@pytest.mark.parametrize("seed", (1, 4, 6, 8, 16, 17, 19, 21, 28, 29))
def test_what_a_run_does_not_show_is_left_alone_and_what_it_shows_it_shows_still(seed: int) -> None:
    model = model_of(small_spec_of(seed))
    reference, random = Reference(model), Random(seed)
    given = lasso_of(model, seed)
    told = 0
    for _ in range(12):
        premise, conclusion = (atom_of(model, random) for _ in range(2))
        for formula, of_runs in (
            (all_always(implies(premise, all_finally(conclusion))), always(implies(premise, finally_(conclusion)))),
            (all_until(premise, conclusion), Until(premise, conclusion)),
        ):
            linear = random.random() < 0.5
            claim = Claim("property", "p", of_runs if linear else formula, linear)
            found = shortened(given, reference, claim, NO_PROPERTIES)
            if word_of(model, given, [of_runs]).satisfies(of_runs):
                assert found == given
            else:
                told += found != given
                assert len(found.moments) <= len(given.moments)
                assert not word_of(model, found, [of_runs]).satisfies(of_runs)
    assert told


def lasso_of(model: Model, seed: int) -> Trace:
    """Return a lasso of random events."""
    stream = Stream(model, seed)
    events: list[Event] = []
    places = [stream.state.key()]
    for event, actions in stream.events(400):
        if not any(isinstance(each, Invalid) for each in actions):
            events.append(event)
            places.append(stream.state.key())
            if len(events) > 8 and places[-1] in places[:-1]:
                return run(Reference(model), tuple(events), places.index(places[-1]))
    raise AssertionError("a small spec comes back to where it was")


def atom_of(model: Model, random: Random) -> Formula:
    """Return a predicate on a request, or its negation."""
    name = random.choice(model.requests).name
    occurrence: Occurrence = random.choice(("asked", "launched", "rejected", "ended"))
    found: Formula = Happened(occurrence, name) if random.random() < 0.5 else Atom(Status("active", name))
    return found if random.random() < 0.6 else Negation(found)
