"""Who does what to whom: edges of small specs, and what runs of the reference interpreter show of larger ones."""

from pathlib import Path

import pytest

import exover
from exover.graph.interactions import Interaction, InteractionGraph, interactions
from exover.model.event import Killed, Waits
from exover.model.model import Model
from exover.model.wire_reading import read_event
from tests.support.events import Stream

ROOT = Path(__file__).resolve().parents[2]
SPECS = sorted([*(ROOT / "specs").glob("*.exo"), *(ROOT / "tests" / "specs").glob("*.exo")])
MODULE = "module m { request a(); request b(); request c(n: int in 0 .. 9) instances 2; }"


def edges(text: str) -> set[tuple[str, str, str, str, bool]]:
    """Return the edges of a spec, each of their rules apart; both ends of each are participants."""
    graph = interactions(exover.loads(f"spec s; {text}").model)
    assert {end for e in graph.interactions for end in (e.source, e.target)} <= {each.id for each in graph.participants}
    return {(e.kind, e.source, e.target, rule, e.sometimes) for e in graph.interactions for rule in e.rules}


RULES = [
    ("mutex x: m.a, m.b;", {("excludes", "m.a", "m.b", "x", False)}),
    (
        "mutex x: m.a, m.b by wait;",
        {
            ("excludes", "m.a", "m.b", "x", False),
            ("wakes", "m.a", "m.b", "x", False),
            ("wakes", "m.b", "m.a", "x", False),
        },
    ),
    ("mutex x: m.a over m.b;", {("interrupts", "m.a", "m.b", "x", False), ("wakes", "m.b", "m.a", "x", False)}),
    ("limit x: at most 1 of m.a, m.b;", {("excludes", "m.a", "m.b", "x", False)}),
    (
        "limit x: at most 2 of m.a, m.b, m.c;",
        {("shares", f"m.{each}", "limit x", "1", False) for each in "abc"},
    ),
    ("limit x: at most 1 of m.c;", {("excludes", "m.c", "m.c", "x", False)}),
    (
        "resource r: 5; context m.a { uses r 3; } context m.b { uses r 2; } "
        "context m.c { uses r 2; uses r 1 when n > 3; }",
        {
            ("excludes", "m.a", "m.c", "r", True),
            ("excludes", "m.c", "m.c", "r", True),
            ("shares", "m.a", "resource r", "3", False),
            ("shares", "m.b", "resource r", "2", False),
            ("shares", "m.c", "resource r", "up to 3", False),
        },
    ),
    (
        "resource r: 9; context m.a { uses r 3; } context m.b { uses r 3; } forbid x: used(r) > 5;",
        {
            ("excludes", "m.a", "m.b", "x", False),
            ("shares", "m.a", "resource r", "3", False),
            ("shares", "m.b", "resource r", "3", False),
        },
    ),
    (
        "resource r: 9; context m.a { uses r 3; } context m.b { uses r 3; } poster p: bool = false; "
        "forbid x: used(r) > 5 and p;",
        {
            ("excludes", "m.a", "m.b", "x", True),
            ("constrains", "poster p", "m.a", "x", False),
            ("constrains", "poster p", "m.b", "x", False),
            ("shares", "m.a", "resource r", "3", False),
            ("shares", "m.b", "resource r", "3", False),
        },
    ),
    ("forbid x: active(m.a) and active(m.c with n > 3);", {("excludes", "m.a", "m.c", "x", True)}),
    (
        "forbid x: active(m.a) and (active(m.b) or active(m.c));",
        {("excludes", "m.a", f"m.{o}", "x", True) for o in "bc"},
    ),
    (
        "poster p: bool = false; forbid x: active(m.a) and p by kill m.a;",
        {("constrains", "poster p", "m.a", "x", False)},
    ),
    (
        "context m.a { fail x: when active(m.b); }",
        {("interrupts", "m.b", "m.a", "m.a.x", True), ("wakes", "m.a", "m.b", "m.a.x", False)},
    ),
    (
        "context m.a { interrupts self; }",
        {(k, "m.a", "m.a", "m.a.interrupts.self", False) for k in ("interrupts", "wakes")},
    ),
    ("context m.a { after m.b; }", {("constrains", "m.b", "m.a", "m.a.after.m.b", False)}),
    ("context m.a { wait until not active(m.b); }", {("wakes", "m.b", "m.a", "m.a.wait.1", False)}),
    ("launch go: m.a() when past(m.b);", {("launches", "m.b", "m.a", "go", False)}),
    ("launch go: m.a() when true;", {("launches", "always true", "m.a", "go", False)}),
    ("context m.a { on ok forget m.b; }", {("sets", "m.a", "m.b", "on ok forget", False)}),
    (
        "resource f: 5 consumable by wait; context m.a { consumes f 2; } context m.b { produces f 1; }",
        {
            ("shares", "m.a", "resource f", "consumes 2", False),
            ("wakes", "resource f", "m.a", "f", False),
            ("sets", "m.b", "resource f", "produces 1", False),
        },
    ),
    (
        "poster p: bool = false; latch l: when p until m.b; context m.a { check l == false; }",
        {
            ("sets", "poster p", "latch l", "when", False),
            ("sets", "m.b", "latch l", "until", False),
            ("constrains", "latch l", "m.a", "m.a.check.1", False),
        },
    ),
]


RULES += [(text.replace("> 5", ">= 6"), expected) for text, expected in RULES if "> 5" in text]


@pytest.mark.parametrize(("text", "expected"), RULES, ids=[text for text, _ in RULES])
def test_each_kind_of_rule(text: str, expected: set[tuple[str, str, str, str, bool]]) -> None:
    assert edges(MODULE + text) == expected


def test_things_of_one_name_are_told_apart() -> None:
    text = "module m { request p(); state p: bool = false; } poster r: bool = false; resource r: 1;"
    text += "context m.p { uses r 1; check m.p == false and r == false; on ok set p = true; }"
    found = edges(text)
    assert ("constrains", "state m.p", "m.p", "m.p.check.1", False) in found
    assert ("constrains", "poster r", "m.p", "m.p.check.1", False) in found
    assert ("sets", "m.p", "state m.p", "on ok", False) in found
    assert ("shares", "m.p", "resource r", "1", False) in found


def test_only_some_edges_leave_all_requests() -> None:
    model = exover.loads(f"spec s; {MODULE} poster p: bool = false; mutex m.a, m.b; launch m.a() when p;").model
    found = interactions(model, ("excludes",))
    assert {edge.kind for edge in found.interactions} == {"excludes"}
    assert [each.id for each in found.participants] == ["m.a", "m.b", "m.c"]


@pytest.mark.parametrize("path", SPECS, ids=[path.stem for path in SPECS])
def test_runs_do_what_the_edges_say(path: Path) -> None:
    model = exover.load(path).model
    graph = interactions(model)
    apart = [e for e in graph.interactions if e.kind in ("excludes", "interrupts") and not e.sometimes]
    stream, seen = Stream(model, 1), 0
    for line in stream.lines(250):
        event = read_event(model, line)
        assert event is not None
        active = [name for name, _slot in stream.state.active()]
        for edge in apart:
            least = 2 if edge.source == edge.target else 1
            assert min(active.count(edge.source), active.count(edge.target)) < least, edge
        seen += len(active) > 1
    assert seen


@pytest.mark.parametrize("path", SPECS, ids=[path.stem for path in SPECS])
def test_whoever_waits_or_is_killed_has_an_edge_of_that_rule(path: Path) -> None:
    model = exover.load(path).model
    graph = interactions(model)
    lines = list(Stream(model, 2).lines(250))
    for answer in exover.simulate(exover.load(path), lines):
        for action in answer.actions:
            match action:
                case Waits(name, rule):
                    assert into(graph, "wakes", name, rule), action
                case Killed(name, _, rule) if rule != "abort":
                    assert into(graph, "interrupts", name, rule) or into(graph, "constrains", name, rule), action


def into(graph: InteractionGraph, kind: str, target: str, rule: str) -> list[Interaction]:
    """Return the edges of a kind and rule that lead to a request."""
    return [e for e in graph.interactions if e.kind == kind and e.target == target and rule in e.rules]


def test_the_order_is_that_of_the_text() -> None:
    model: Model = exover.load(ROOT / "specs" / "rover.exo").model
    assert interactions(model) == interactions(exover.load(ROOT / "specs" / "rover.exo").model)
    names = [each.name for each in interactions(model).participants if each.kind == "request"]
    assert names == [request.name for request in model.requests]
