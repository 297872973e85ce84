"""The forest: tests that no consistent state needs are gone, and nodes have canonical numbers."""

import pytest

from exover.ocrd import tables as t
from exover.ocrd.tables import NONE, Tables
from tests.support.engines import model_of, tables_of
from tests.support.fuzz import spec_of


def asked_for(guard: str) -> int:
    """Return how many tests the decision on a request with this guard has, besides whether its slot is free."""
    model = model_of(f"""spec s;
        poster k: int in 0 .. 5 = 0;
        poster v: real in 0 .. 1 = 0;
        resource p: 3;
        module m {{
            request a(n: int in 0 .. 3) {{ check {guard}; }}
            request b(n: int in 0 .. 3, z: bool) returns (d: int in 0 .. 3) instances 2 {{ uses p 2; }}
        }}
        """)
    tables = tables_of(model)
    seen: set[int] = set()
    stack = [tables.requests[0].decide]
    while stack:
        node = stack.pop()
        if node != NONE and node not in seen and tables.nodes[node].code >= 0:
            seen.add(node)
            stack += [tables.nodes[node].low, tables.nodes[node].high]
    return len(seen) - 1


@pytest.mark.parametrize(
    ("guard", "tests"),
    [
        ("running(m.b) implies active(m.b)", 0),
        ("past(m.b with d == 2) implies past(m.b)", 0),
        ("k <= 1 or k <= 2", 1),
        ("k <= 2 and not k > 3", 1),
        ("k <= 1 or k > 3", 2),
        ("k <= 5", 0),
        ("v >= 0", 0),
        ("v < 0.5 or v > 0.5 or v == 0.5", 0),
        ("used(p) <= 8", 0),
        ("used(p) > 1 implies active(m.b)", 0),
    ],
)
def test_a_test_whose_answer_follows_is_left_out(guard: str, tests: int) -> None:
    assert asked_for(guard) == tests


def test_the_decision_asks_nothing_that_is_known() -> None:
    """Below `nothing of b is active` nothing asks what of b runs."""
    assert asked_for("active(m.b) or (running(m.b) and k <= 2)") == 1
    outside = asked_for("running(m.b) or (active(m.b) and k <= 2)")
    assert asked_for("active(m.b) and (running(m.b) or k <= 2)") == outside


def children(tables: Tables, index: int) -> list[int]:
    node = tables.nodes[index]
    below = [node.low] if node.code < 0 else [node.low, node.high]
    return [child for child in below if child != NONE]


@pytest.mark.parametrize("seed", range(24))
def test_nodes_are_numbered_from_the_roots_down(seed: int) -> None:
    tables = tables_of(model_of(spec_of(seed)))
    roots = [request.decide for request in tables.requests] + [rule.root for rule in tables.rules]
    roots += [launch.condition for launch in tables.launches] + [latch.condition for latch in tables.latches]
    roots += [row.root for row in tables.invariants]
    predicates = [row.predicate for row in tables.features] + [row.predicate for row in tables.pasts]
    roots += [root for root in predicates + [row.predicate for row in tables.amounts] if root != t.ALWAYS]
    reached = {root for root in roots if root != NONE}
    for index in range(len(tables.nodes)):
        assert index in reached, f"node {index} is below no root"
        for child in children(tables, index):
            assert child > index, f"node {child} follows {index}"
            reached.add(child)
    assert len(set(tables.nodes)) == len(tables.nodes), "equal nodes are one"
    branches = [node for node in tables.nodes if node.code >= 0]
    assert all(node.low != node.high for node in branches), "every test has a use"
