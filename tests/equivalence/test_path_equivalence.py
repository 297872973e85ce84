"""Tables beside rules, path by path: specs as teams write them are compared at once, and no damage is missed."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from time import process_time
from typing import NoReturn

import pytest

from exover.checks.questions import tables as check
from exover.checks.questions.question import Context, Question
from exover.engines.bdd.analysis import Analysis
from exover.equivalence.bound_propagation import EMPTY, BoundPropagation, learned
from exover.equivalence.path_equivalence import PathComparison, UndecidedPaths, merged_order
from exover.equivalence.path_equivalence import TestedPath as Way
from exover.equivalence.path_feasibility import PathFeasibility
from exover.equivalence.record_equivalence import kinds_of_events
from exover.loop.finite import builder
from exover.model.property import NO_PROPERTIES
from exover.model.semantics import Reference
from exover.ocrd.compile import Compiled, compile_model
from exover.ocrd.tables import STATE, Node, Tables
from tests.support.engines import DIGEST, agree_at_random, model_of

SPECS = Path(__file__).parents[1] / "specs"
SECONDS = 20.0
"""Of processor time for one spec: ten times what it takes, since machines differ; cells alone took minutes."""

CHOSEN = """spec chosen;
enum kind { red, green, blue }
poster on: bool = true;
module m {
    request put(what: kind, n: int in 0 .. 6, odd: bool);
    request take(what: kind, n: int in 0 .. 6) {
        check like: past(m.put with what == self.what and n >= self.n and not odd);
        check other: not past(m.put with not (what == self.what or n < self.n) and odd) or on;
        wait fewer: until not past(m.take with n > self.n or what == blue);
    }
    request drop() { on ok forget m.put, m.take; }
}
"""


@cache
def compiled(name: str) -> Compiled:
    return compile_model(model_of((SPECS / f"{name}.exo").read_text(encoding="utf-8")), DIGEST)


def never(*_: object) -> NoReturn:
    raise AssertionError("asked for")


def beside_rules(made: Compiled, possible: object = None) -> PathComparison:
    """Return the comparison of tables with the rules."""
    return PathComparison(made, PathFeasibility(made) if possible is None else possible)  # type: ignore[arg-type]


def different(made: Compiled, possible: object = None) -> set[str]:
    """Return in what tables are seen to be otherwise than the rules."""
    beside = beside_rules(made, possible)
    return {what for kind, name, _ in kinds_of_events(made.model) for what in beside.different(kind, name)}


def with_node(made: Compiled, number: int, node: Node) -> Compiled:
    nodes = made.tables.nodes
    return with_tables(made, replace(made.tables, nodes=(*nodes[:number], node, *nodes[number + 1 :])))


def with_tables(made: Compiled, tables: Tables) -> Compiled:
    return replace(made, tables=tables)


@pytest.mark.parametrize("name", ["hospital_courier", "lab_automation"])
def test_specs_as_teams_write_them_need_neither_loop_nor_solver(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(builder.ClosedLoop, "__post_init__", never)
    start = process_time()
    made = compiled.__wrapped__(name)
    context = Context(made, Analysis(made, Reference(made.model), lambda what: None))
    context.tables.by_paths.possible = never
    for subject, location in check.subjects(made.model, NO_PROPERTIES):
        finding = check.decide(context, Question("tables", "error", subject, location))
        assert finding.verdict == "holds", finding
    assert process_time() - start < SECONDS


def test_swapped_and_moved_tests_of_a_large_spec_are_found() -> None:
    made = compiled("hospital_courier")
    row = made.tables.requests[[r.name for r in made.model.requests].index("drawers.unload")]
    below = [n for n in made.tables.below(row.decide) if made.tables.nodes[n].code >= 0]
    for number in (below[0], below[len(below) // 2]):
        node = made.tables.nodes[number]
        for changed in (replace(node, low=node.high, high=node.low), replace(node, low=node.high)):
            beside = beside_rules(with_node(made, number, changed))
            assert "the decision on `drawers.unload`" in beside.different("ask", "drawers.unload"), node


def test_a_predicate_that_is_true_of_other_arguments_is_found() -> None:
    made = compiled("lab_automation")
    past = next(row for row in made.tables.pasts if row.predicate >= 0)
    node = made.tables.nodes[past.predicate]
    found = different(with_node(made, past.predicate, replace(node, low=node.high, high=node.low)))
    assert f"entry {past.entry} of the state vector" in found


def test_a_record_of_one_slot_counts_no_waiting_place() -> None:
    waits = """spec waits;
    module m {
        request a(x: bool) { wait until not active(m.b); }
        request b();
        request c() { check not waiting(m.a with x); }
    }"""
    made = compile_model(model_of(waits), DIGEST)
    (number,) = [n for n, row in enumerate(made.tables.features) if row.waiting >= 0]
    row = made.tables.features[number]
    rows = (*made.tables.features[:number], replace(row, slot=0), *made.tables.features[number + 1 :])
    found = different(with_tables(made, replace(made.tables, features=rows)))
    assert f"entry {row.waiting} of the state vector" in found


def test_posters_are_compared_by_what_each_reads_whenever_that_changes() -> None:
    text = "poster a: real in 0 .. 3 = 0; poster b: real in 0 .. 3 = 1; module m { request x() { check a < b; } }"
    made = compile_model(model_of(f"spec compared; {text}"), DIGEST)
    (a, b), orders = made.tables.variables, made.tables.orders
    assert not different(made)
    shared = replace(made.tables, variables=(a, replace(b, raw=a.raw)))
    assert different(with_tables(made, shared)) == {f"where the value of `{name}` is kept" for name in "ab"}
    for number, name in enumerate("ab"):
        deaf = replace(
            made.tables, orders=tuple(replace(o, entry=-1) if k == number else o for k, o in enumerate(orders))
        )
        assert f"the posters that `{name}` is compared with" in different(with_tables(made, deaf))


def test_a_poster_that_is_taken_for_a_state_is_found() -> None:
    made = compile_model(model_of("spec deaf; poster p: bool = false; module m { request x() { check p; } }"), DIGEST)
    deaf = (replace(made.tables.variables[0], role=STATE),)
    assert different(with_tables(made, replace(made.tables, variables=deaf))) == {"which variables are observed"}


def test_a_record_that_fills_the_entry_of_another_is_found() -> None:
    made = compile_model(model_of(CHOSEN), DIGEST)
    for number, param in enumerate(made.tables.params):
        rows = (*made.tables.params[:number], replace(param, rank=0), *made.tables.params[number + 1 :])
        assert different(with_tables(made, replace(made.tables, params=rows)))
        rows = (*made.tables.params[:number], replace(param, value=-2), *made.tables.params[number + 1 :])
        assert different(with_tables(made, replace(made.tables, params=rows)))


def test_what_is_not_seen_is_asked_of_sets_of_states(monkeypatch: pytest.MonkeyPatch) -> None:
    def undecided(*_: object) -> NoReturn:
        raise UndecidedPaths("too many paths")

    monkeypatch.setattr(PathComparison, "different", undecided)
    made = compile_model(model_of(CHOSEN), DIGEST)
    context = Context(made, Analysis(made, Reference(made.model), lambda what: None))
    for subject, location in check.subjects(made.model, NO_PROPERTIES):
        assert check.decide(context, Question("tables", "error", subject, location)).verdict == "holds"


def test_a_path_that_no_state_is_on_tells_nothing() -> None:
    made = compile_model(model_of(CHOSEN), DIGEST)
    number = made.tables.requests[1].decide
    node = made.tables.nodes[number]
    broken = with_node(made, number, replace(node, low=node.high, high=node.low))
    ways: list[Way] = []

    def nowhere(way: Way) -> bool:
        ways.append(way)
        return False

    assert different(broken, lambda way: True)
    try:
        assert not different(broken, nowhere)
    except UndecidedPaths as reason:
        assert str(reason) == "too many paths"
    assert ways and all(low <= high for way in ways for _, (low, high) in way)


def test_bounds_are_propagated_until_nothing_more_follows() -> None:
    made = compile_model(model_of(CHOSEN), DIGEST)
    beside = PathComparison(made, never)  # type: ignore[arg-type]
    knowledge = BoundPropagation(beside.questions.numbers)
    by_text = {repr(element): number for element, number in zip(made.entries, beside.elements, strict=True)}
    active = next(n for text, n in by_text.items() if text.count("Slots(request='m.take'") == 2)
    assert knowledge.range(active, ()) == (0, 2)
    assert knowledge.range(active, learned((), active, (1, 2))) == (1, 2)
    assert knowledge.range(active, learned((), active, (3, 2))) == EMPTY


def test_elements_that_an_order_lacks_stand_before_what_they_stand_before_elsewhere() -> None:
    assert merged_order([3, 1], [1, 2, 3, 4]) == [2, 3, 1, 4]
    assert merged_order([], [5, 6]) == [5, 6]


@pytest.mark.parametrize("seed", range(6))
def test_a_past_that_is_told_part_by_part_decides_alike(seed: int) -> None:
    agree_at_random(CHOSEN, seed, 120)
    assert not different(compile_model(model_of(CHOSEN), DIGEST), never)
