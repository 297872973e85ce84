"""The bounds that are emitted hold: no event takes more tests, answers or passes than its own bound says."""

from collections.abc import Iterable

import pytest

from benchmarks.families import queues
from exover.bounds.costs import Costs
from exover.bounds.events import Bound, bounds
from exover.bounds.sizes import sizes, state_bytes
from exover.engines.aig.costs import tightened
from exover.model.event import Ask, Event, Observe
from exover.pipeline import Build, build
from tests.bounds.counting import Counting, bound_of, most_of, random_events
from tests.runtime.compiling import ROOT, built, model_of
from tests.support.constructs import seldom
from tests.support.fuzz import VARIED, spec_of

EVENTS = 300
SEEDS = (2, 25, 66, 72, 104, 108)
"""Of specs that have every construct of a hundred."""


def most_taken(found: Build, events: Iterable[Event]) -> Bound:
    """Return what the events take at most; each keeps its bound."""
    return most_of(found, tightened(found.compiled), events)


@pytest.mark.parametrize("seed", SEEDS)
def test_no_event_of_a_random_spec_exceeds_its_bound(seed: int) -> None:
    found = build(model_of(spec_of(seed)))
    most_taken(found, random_events(found.model, seed, EVENTS))


def test_the_random_specs_have_every_construct() -> None:
    few, many = ([(model_of(spec_of(seed)),) for seed in seeds] for seeds in (SEEDS, VARIED))
    assert not seldom(few, many, 1)


def test_what_only_rejects_takes_no_more_than_its_longest_path() -> None:
    """Where nothing waits the bounds are attained."""
    model = model_of("spec s; module m { request a(); request b(); request c(); } mutex m.a, m.b; mutex m.a, m.c;")
    found = build(model)
    assert most_taken(found, random_events(model, 1, 200)) == Bound(3, 1, 1)
    assert bounds(found.tables).worst == Bound(3, 1, 0)
    assert [bound.tests for bound in bounds(found.tables).asks] == [3, 2, 2]


def test_a_request_that_waits_wakes_what_hangs_together_with_it_and_nothing_else() -> None:
    text = "spec s; module m {{ request a(); request b(); request c(); {} }} mutex m.a over m.b;"
    alone = bounds(build(model_of(text.format(""))).tables)
    beside = bounds(build(model_of(text.format("request d() { wait until not active(m.c); }"))).tables)
    assert [(bound.tests, bound.answers, bound.passes) for bound in alone.asks] == [(6, 3, 2), (7, 2, 2), (3, 1, 1)]
    assert [(bound.answers, bound.passes) for bound in beside.asks] == [(3, 2), (2, 2), (1, 1), (2, 2)]


@pytest.mark.parametrize(("requests", "passes"), [("abc", 3), ("cba", 2)])
def test_what_wakes_one_after_another_takes_a_pass_each_unless_it_stands_in_their_order(
    requests: str, passes: int
) -> None:
    """Here a waits for b and b for c: what is decided after what it waits for is decided in the same pass."""
    clauses = {"a": "{ wait until active(m.b); }", "b": "{ wait until active(m.c); }", "c": ";"}
    model = model_of(f"spec s; module m {{ {' '.join(f'request {r}() {clauses[r]}' for r in requests)} }}")
    found = build(model)
    assert bounds(found.tables).worst.passes == passes
    most = most_taken(found, [Ask("m.a", ()), Ask("m.b", ()), Ask("m.c", ())])
    assert (most.answers, most.passes) == (3, passes)


def test_requests_that_only_wait_for_each_other_are_woken_by_what_ends() -> None:
    """A launch lets nobody go who waits for it to end, however many wait."""
    found = build(model_of(queues(24)))
    assert bounds(found.tables).worst.passes == 2
    assert most_taken(found, random_events(found.model, 5, 200)).passes == 2


@pytest.mark.parametrize(("bound", "expected"), [(100, 4), (32_767, 4), (40_000, 8), (2**40, 8)])
def test_entries_have_room_for_sums(bound: int, expected: int) -> None:
    domain = f"int in 0 .. {bound}"
    model = model_of(f"spec s; poster a: {domain} = 0; module m {{ request r(x: {domain}) {{ check x + a < 9; }} }}")
    assert state_bytes(build(model).tables) == expected


def test_figures_are_those_of_the_tables() -> None:
    found = built(ROOT / "specs" / "diligent.exo")
    figures, worst = sizes(found.tables), bounds(found.tables).worst
    assert (figures.tests, figures.actions, figures.passes) == (worst.tests, worst.answers, worst.passes)
    assert figures.rom == len(found.data)


BROKEN = """spec s; poster b: bool = true; module m { request a(); request c(); } forbid f: b and active(m.a);"""
LATCHED = """spec s; poster b: bool = false; latch l: when b until m.a; module m { request a() { check not l; } }"""
COMPARED = """spec s; poster p: real in 0 .. 2 = 0;
module m { request a(v: real in 0 .. 2) instances 2 { check not active(m.a with v > 1); fail f: when p > v; } }"""
TURNING = """spec s; poster b: bool = false;
module m { request a() { wait until not b; interrupts m.c; } request c(); request d() { wait until not b; } }"""
AGAIN = """spec s; poster b: bool = false; module m { request a() { wait until b; interrupts self; } }"""


RISE, FALL = Observe("b", True), Observe("b", False)


@pytest.mark.parametrize(
    ("text", "events", "tests", "answers"),
    [
        # In the first step the rule is looked at; while it is broken each step says so.
        (BROKEN, [Ask("m.c"), FALL, Ask("m.a"), RISE, Ask("m.c")], 3, 2),
        # The condition of the latch is looked at.
        (LATCHED, [RISE], 1, 0),
        (LATCHED, [RISE, Ask("m.a"), FALL, Ask("m.a")], 2, 1),
    ],
    ids=["rule", "latch", "latch-ask"],
)
def test_small_bounds_are_attained(text: str, events: list[Event], tests: int, answers: int) -> None:
    model = model_of(text)
    found = build(model)
    bound, machine = bound_of(model, bounds(found.tables), events[-1]), Counting(model, found.tables)
    costs = []
    for event in events:
        machine.tests = 0
        said = len(machine.step(event))
        costs.append((machine.tests, said) if type(event) is type(events[-1]) else (0, 0))
    assert (bound.tests, bound.answers) == (tests, max(answers, 1))
    assert [max(column) for column in zip(*costs, strict=True)] == [tests, answers]


def test_a_bound_counts_what_may_happen() -> None:
    """A kill is an answer, and so is what leaves a waiting place; what turns is counted out and in."""
    turning, again = (bounds(build(model_of(text)).tables) for text in (TURNING, AGAIN))
    assert [(bound.answers, bound.passes) for bound in turning.asks] == [(3, 2), (2, 2), (3, 2)]
    assert [(bound.answers, bound.passes) for bound in again.asks] == [(3, 2)]
    cost = Costs(build(model_of(COMPARED)).tables)
    # Three predicates, of the check, of the clause, and of what the clause leaves: out; out and in; for two slots.
    assert [doing.tests for doing in (cost.report(0), cost.kill(0), cost.reading(0))] == [3, 6, 12]
