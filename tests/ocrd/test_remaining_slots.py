"""Slots that a decision leaves as they are while it kills others are counted, not told apart one by one."""

import pytest

from exover.equivalence.path_equivalence import PathComparison
from exover.equivalence.path_feasibility import PathFeasibility
from exover.ocrd.compile import Compiled, compile_model
from tests.support.engines import DIGEST, agree_at_random, model_of

FLEET = """spec fleet; poster wind: int in 0 .. 9 = 0; module m {{
    request carry(x: int in 0 .. 9) instances {slots} {{ uses power 3; }}
    request charge() instances {slots};
    request rest();
    request survey(x: int in 0 .. 9, y: int in 0 .. 9) instances {slots} {{
        uses power 2; {clauses}
    }}
}}
limit at most {twice} of m.* by wait;
mutex m.carry, m.charge by wait;
resource power: {thrice} by {remedy};
"""
CLAUSES = {
    "an argument": "fail when x > 5 and active(m.carry);",
    "what holds for all": "fail when wind > 4 and (x > 5 or not (y < 3)) and active(m.carry with x < 7);",
    "two clauses": "fail when x > 5 and active(m.carry); fail when y > 5 and wind > 3;",
    "the share": "uses power 1 when y > 2; fail when not (y <= 4) and used(power) > 4;",
    "with what stops and without": "fail when x > 5 and active(m.carry) and not active(m.rest);",
    "slots compared": "fail when active(m.survey with x > self.x) and active(m.carry);",
    "every slot": "fail when active(m.carry) and wind > 5;",
}


def fleet(slots: int, clauses: str, remedy: str = "wait") -> str:
    return FLEET.format(slots=slots, twice=2 * slots, thrice=3 * slots, clauses=CLAUSES[clauses], remedy=remedy)


def made(text: str) -> Compiled:
    return compile_model(model_of(text), DIGEST)


@pytest.mark.parametrize("clauses", ["an argument", "what holds for all"])
def test_tables_are_linear_in_the_slots_that_are_killed_by_their_arguments(clauses: str) -> None:
    """Each choice of slots that are killed had sums of its own: eight slots took 3 048 nodes, ten 10 187."""
    small, middle, large = (made(fleet(slots, clauses)).figures.nodes for slots in (3, 5, 7))
    assert large - middle == middle - small
    assert made(fleet(12, clauses)).figures.nodes < 400, "asked anew, for it is large before its entries are ordered"


def test_what_remains_of_several_clauses_is_counted() -> None:
    """Of eight slots the choices were too many: more than 1 500 000 nodes."""
    assert made(fleet(8, "two clauses")).figures.nodes < 5_000


KILLED = {
    "by a clause": ("fail when x > 5 and active(m.carry);", ""),
    "by a rule": ("", "forbid active(m.carry) and active(m.r{} with x > 5) by kill m.r{};"),
}


def many(requests: int, killed: str) -> str:
    """Return a spec of so many requests, of one slot each, that share a resource and are killed by arguments."""
    clause, rule = KILLED[killed]
    declared = "".join(f"request r{n}(x: int in 0 .. 9) {{ uses power 2; {clause} }} " for n in range(requests))
    rules = "".join(rule.format(n, n) for n in range(requests))
    return f"""spec many; module m {{ request carry() {{ uses power 3; }} {declared} }} {rules}
        resource power: {requests} by wait; limit at most {requests // 2 + 1} of m.* by wait;"""


@pytest.mark.parametrize("killed", KILLED)
def test_tables_are_linear_in_the_requests_that_are_killed_by_their_arguments(killed: str) -> None:
    """Each choice of requests that are killed had sums of its own: twelve took 24 643 nodes and 2 MB."""
    small, middle, large = (made(many(requests, killed)).figures.nodes for requests in (6, 9, 12))
    assert large - middle == middle - small < 100
    agree_at_random(many(5, killed), seed=0, events=600)


@pytest.mark.parametrize("clauses", CLAUSES)
def test_decisions_are_those_of_the_rules(clauses: str) -> None:
    tables = made(fleet(2, clauses))
    compared = PathComparison(tables, PathFeasibility(tables))
    assert all(compared.decides(request.name) for request in tables.model.requests)


@pytest.mark.parametrize("remedy", ["wait", "reject", "kill m.carry or wait"])
@pytest.mark.parametrize("clauses", CLAUSES)
def test_answers_are_those_of_the_rules(clauses: str, remedy: str) -> None:
    agree_at_random(fleet(3, clauses, remedy), seed=1, events=600)
