"""The `tables` check looks: whatever damage changes a decision, it finds."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from exover.checks.questions import tables as check
from exover.checks.questions.question import Context, Question
from exover.engines.bdd.analysis import Analysis
from exover.model.model import Location
from exover.model.property import NO_PROPERTIES
from exover.model.semantics import Reference
from exover.ocrd.compile import Compiled
from exover.ocrd.tables import NONE, Node, Tables
from exover.pipeline import build, load
from exover.source import Source

ROVER = Path(__file__).parents[3] / "specs" / "rover.exo"


@pytest.fixture(scope="module")
def rover() -> Compiled:
    model = load(Source("rover.exo", ROVER.read_text())).model
    assert model is not None
    return build(model).compiled


def verdicts(compiled: Compiled) -> dict[str, str]:
    context = Context(compiled, Analysis(compiled, Reference(compiled.model), lambda what: None))
    found = {}
    for subject, location in check.subjects(compiled.model, NO_PROPERTIES):
        found[subject] = check.decide(context, Question("tables", "error", subject, location)).verdict
    return found


def with_node(compiled: Compiled, number: int, change: Callable[[Node], Node]) -> Compiled:
    nodes = list(compiled.tables.nodes)
    nodes[number] = change(nodes[number])
    return replace(compiled, tables=replace(compiled.tables, nodes=tuple(nodes)))


def damaged(compiled: Compiled, number: int) -> list[Compiled]:
    """Return the table with node `number` damaged: children swapped, bound moved, reason moved, action dropped."""
    node = compiled.tables.nodes[number]
    if node.code >= 0:
        changes: list[Callable[[Node], Node]] = [lambda n: replace(n, low=n.high, high=n.low)]
    else:
        changes = [lambda n: replace(n, bound=n.bound + 1 if n.bound == 0 else n.bound - 1)]
    return [with_node(compiled, number, change) for change in changes]


def test_sound_tables_hold(rover: Compiled) -> None:
    assert set(verdicts(rover).values()) == {"holds"}


def test_a_swapped_test_is_found_wherever_it_stands(rover: Compiled) -> None:
    for number, node in enumerate(rover.tables.nodes):
        if node.code >= 0:
            (broken,) = damaged(rover, number)
            assert "violated" in verdicts(broken).values(), f"node {number}: {node}"


def test_a_wrong_reason_is_found(rover: Compiled) -> None:
    reasoned = [k for k, node in enumerate(rover.tables.nodes) if node.code in (-1, -2, -3, -4, -5, -6, -8)]
    assert reasoned
    for number in reasoned:
        (broken,) = damaged(rover, number)
        assert "violated" in verdicts(broken).values(), f"node {number}: {rover.tables.nodes[number]}"


def test_a_launch_that_is_dropped_is_found(rover: Compiled) -> None:
    launches = [k for k, node in enumerate(rover.tables.nodes) if node.code == -7]
    assert launches
    for number in launches:
        broken = with_node(rover, number, lambda node: replace(node, code=-1))
        assert "violated" in verdicts(broken).values()


def _changed(tables: Tables, section: str, number: int, record: Any) -> Tables:
    rows = getattr(tables, section)
    return replace(tables, **{section: (*rows[:number], record, *rows[number + 1 :])})


def records(tables: Tables) -> list[tuple[str, Tables]]:
    """Return the tables with one record damaged, for kinds of records that the rover has."""
    effect = replace(tables.effects[0], value=1 - tables.effects[0].value)
    param = replace(tables.params[0], high=tables.params[0].high + 1)
    battery = next(k for k, v in enumerate(tables.variables) if (v.low, v.high) == (0, 100))
    variable = replace(tables.variables[battery], initial=50)
    watched = next(k for k, entry in enumerate(tables.entries) if entry.rules < entry.rules_end)
    entry = replace(tables.entries[watched], rules_end=tables.entries[watched].rules)
    started = replace(tables.entries[0], initial=tables.entries[0].initial + 1)
    feature = next(k for k, f in enumerate(tables.features) if f.running != NONE)
    dropped = replace(tables.features[feature], running=NONE)
    conflict = replace(tables.conflicts[0], mask=tables.conflicts[0].mask ^ 1)
    reason = replace(tables.reasons[0], denials=1 - tables.reasons[0].denials)
    launch = replace(tables.launches[0], reason=tables.launches[0].reason - 1)
    status = next(k for k, row in enumerate(tables.requests) if row.statuses)
    statuses = replace(tables.requests[status], statuses=1)
    return [
        ("launch", _changed(tables, "launches", 0, launch)),
        ("statuses", _changed(tables, "requests", status, statuses)),
        ("conflict", _changed(tables, "conflicts", 0, conflict)),
        ("reason", _changed(tables, "reasons", 0, reason)),
        ("effect", _changed(tables, "effects", 0, effect)),
        ("param", _changed(tables, "params", 0, param)),
        ("variable", _changed(tables, "variables", battery, variable)),
        ("watched", _changed(tables, "entries", watched, entry)),
        ("started", _changed(tables, "entries", 0, started)),
        ("feature", _changed(tables, "features", feature, dropped)),
    ]


@pytest.mark.parametrize(
    "kind",
    ["effect", "param", "variable", "feature", "watched", "started", "launch", "statuses", "conflict", "reason"],
)
def test_a_damaged_record_is_found(rover: Compiled, kind: str) -> None:
    tables = dict(records(rover.tables))[kind]
    assert "violated" in verdicts(replace(rover, tables=tables)).values()


def test_subjects_are_the_kinds_of_events(rover: Compiled) -> None:
    names = [name for name, _ in check.subjects(rover.model, NO_PROPERTIES)]
    assert {"ask nd.goto", "report nd.goto", "abort nd.goto", "observe nd.speed", "observe battery"} <= set(names)
    assert all(isinstance(location, Location) for _, location in check.subjects(rover.model, NO_PROPERTIES))


def test_what_rules_tell_of_arguments_is_told_apart_though_the_tables_do_not() -> None:
    """The only test of `n` is moved to where it tells nothing; what rules say of `self.n` they say inside `with`."""
    text = "spec s; module m { request b(); request a(n: bool) { check past(m.b with self.n == false); } }"
    model = load(Source("s.exo", text)).model
    assert model is not None
    made = build(model).compiled
    entry = next(k for k, element in enumerate(made.entries) if "Arg(" in repr(element))
    number = next(k for k, node in enumerate(made.tables.nodes) if node.code == entry)
    broken = with_node(made, number, lambda node: replace(node, bound=node.bound + 1))
    assert verdicts(made)["ask m.a"] == "holds" and verdicts(broken)["ask m.a"] == "violated"
