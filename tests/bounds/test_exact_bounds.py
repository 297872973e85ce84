"""The bounds of small specs beside what their events take at most, found by trying every event in every state."""

from collections.abc import Iterator
from statistics import median

import pytest

from exover.bounds.events import Bound, EventBounds, bounds
from exover.engines.aig import costs as graph_costs
from exover.engines.aig.costs import tightened
from exover.model.semantics import Reference
from exover.model.state import State
from exover.ocrd.compile import Compiled
from exover.pipeline import Build, EmitTarget, build, emit
from tests.bounds.counting import Counting, bound_of, copied
from tests.runtime.compiling import model_of
from tests.support.constructs import seldom
from tests.support.oracle import events_of
from tests.support.representatives import Representatives, TooLarge
from tests.support.small import small_spec_of

STATES = 150
SEEDS = (3, 4, 6, 15, 16, 17, 26, 27, 28, 29, 30, 34, 38, 40, 41, 42, 45, 51, 56, 57)
"""Of specs that have every construct of the first 60; some have more states than are looked at."""
LOOSE = {"tests": 2.0, "answers": 1.5, "passes": 1.0}
"""How many times more the bounds of the worst event are than it takes, by the median of the specs, at most."""


def costs(found: Build, known: EventBounds) -> Iterator[tuple[Bound, Bound]]:
    """Yield what every event takes in every state that can be reached, and its bound; raises `TooLarge`."""
    model, machine = found.model, Counting(found.model, found.tables)
    reference, values = Reference(model), Representatives(model)
    pending: list[tuple[State, dict[str, object]]] = [(reference.start(), copied(machine))]
    seen = {values.canonical(reference.start()).key()}
    for state, held in pending:
        for event in events_of(model, values, state):
            vars(machine).update(held)
            vars(machine).update(copied(machine))
            machine.tests = machine.passes = 0
            said = machine.step(event)
            after, answers = reference.step(state, event)
            assert said == answers
            yield Bound(machine.tests, len(said), machine.passes), bound_of(model, known, event)
            key = values.canonical(after).key()
            if key not in seen:
                seen.add(key)
                pending.append((after, copied(machine)))
        if len(seen) > STATES:
            raise TooLarge(f"more than {STATES} states")


def looseness(seed: int) -> tuple[float, float, float] | None:
    """Return how many times more the bounds of the worst events are than they take; None for a spec too large."""
    found, most = build(model_of(small_spec_of(seed))), Bound(0, 0, 0)
    known = tightened(found.compiled)
    try:
        for taken, bound in costs(found, known):
            assert taken.tests <= bound.tests and taken.answers <= bound.answers
            assert taken.passes <= max(bound.passes, 1)
            most = Bound(*map(max, zip(figures_of(most), figures_of(taken), strict=True)))
    except TooLarge:
        return None
    tests, answers, passes = figures_of(known.worst)
    return tests / max(most.tests, 1), answers / max(most.answers, 1), max(passes, 1) / max(most.passes, 1)


def figures_of(bound: Bound) -> tuple[int, int, int]:
    return bound.tests, bound.answers, bound.passes


def test_the_specs_have_every_construct() -> None:
    few, many = ([(model_of(small_spec_of(seed)),) for seed in seeds] for seeds in (SEEDS, range(60)))
    assert not seldom(few, many, 1)


def test_bounds_are_kept_and_not_far_from_what_is_taken() -> None:
    found = [each for seed in SEEDS if (each := looseness(seed)) is not None]
    assert len(found) > len(SEEDS) // 2
    for column, most in zip(zip(*found, strict=True), LOOSE.values(), strict=True):
        assert median(column) <= most, sorted(column)


def test_no_graph_is_made_of_tables_that_are_too_large(monkeypatch: pytest.MonkeyPatch) -> None:
    found = build(model_of(small_spec_of(3)))
    by_steps, by_paths = tightened(found.compiled), bounds(found.tables)
    assert by_steps != by_paths
    for limit, size in ("MOST_ENTRIES", len(found.tables.entries)), ("MOST_NODES", len(found.tables.nodes)):
        with monkeypatch.context() as smaller:
            smaller.setattr(graph_costs, "MOST_ENTRIES", len(found.tables.entries))
            smaller.setattr(graph_costs, "MOST_NODES", len(found.tables.nodes))
            assert tightened(found.compiled) == by_steps
            smaller.setattr(graph_costs, limit, size - 1)
            assert tightened(found.compiled) == by_paths


def test_targets_that_write_bounds_share_them(monkeypatch: pytest.MonkeyPatch) -> None:
    found = build(model_of("spec s; module m { request a(); request b(); } mutex m.a, m.b by wait;"))
    asked: list[Compiled] = []

    def counted(compiled: Compiled) -> EventBounds:
        asked.append(compiled)
        return tightened(compiled)

    monkeypatch.setattr(graph_costs, "tightened", counted)
    targets: tuple[EmitTarget, ...] = ("c", "rust", "json")
    assert all(emit(found, target) for target in targets)
    assert asked == [found.compiled]
