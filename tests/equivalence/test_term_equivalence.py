"""Z3 finds that tables decide as the rules say, or what differs, also where numbers are too many for diagrams."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path
from random import Random

import pytest

from exover.checks.run import check_all
from exover.checks.schedule.engines import PORTFOLIO
from exover.checks.schedule.plan import CheckPlan
from exover.engines.smt.solver import Clock, Prover
from exover.equivalence.engine import Z3
from exover.equivalence.record_equivalence import kinds_of_events
from exover.equivalence.term_equivalence import TermComparison
from exover.loop.claim import Claim
from exover.model.property import NO_PROPERTIES
from exover.ocrd.compile import Compiled
from exover.ocrd.packing import decode, pack
from exover.ocrd.tables import NONE, Tables
from exover.pipeline import build
from tests.support import fuzz, small
from tests.support.engines import model_of
from tests.support.mutants import Subject, mutants
from tests.support.small import compiled, small_spec_of

SPECS = Path(__file__).parents[2] / "specs"
LARGE = """spec large;
poster load: int in 0 .. 1000000000 = 0;
poster limit: real in 0 .. 10 = 5;
resource fuel: 100000 consumable;
module m {
    request go(n: int in -500000000 .. 500000000, v: real in 0 .. 10) instances 2 {
        check sum: load + 2 * n <= 900000000;
        check slow: v <= limit;
        check fuel_left: level(fuel) >= 250;
        consumes fuel 200 when n > 1000;
        wait until not active(m.go with n == 7);
    }
    request stop() { interrupts m.go; }
}
forbid heavy: active(m.go with n > 123456) and load > 700000000 by kill m.go;
"""


def differences(made: Compiled, tables: Tables) -> Iterator[str]:
    """Yield in what damaged tables of a model are not its rules; also that they do not fit together."""
    rules = TermComparison(replace(made, tables=tables), Prover(Clock(), 60.0))
    try:
        for kind, name, _ in kinds_of_events(made.model):
            yield from rules.different(kind, name)
    except (AssertionError, IndexError, KeyError):
        yield "the records do not fit together"


def found(made: Compiled, tables: Tables) -> bool:
    return next(differences(made, tables), None) is not None


@pytest.mark.parametrize("name", ["rover", "assistant", "satellite", "diligent"])
def test_tables_that_were_just_made_are_the_rules(name: str) -> None:
    made = build(model_of((SPECS / f"{name}.exo").read_text())).compiled
    assert list(differences(made, made.tables)) == []


@pytest.mark.parametrize(
    ("made_of", "seed"), [*product([fuzz.spec_of], fuzz.VARIED), *product([small.small_spec_of], small.VARIED)]
)
def test_of_random_specs_too(made_of: Callable[[int], str], seed: int) -> None:
    made = compiled(model_of(made_of(seed)))
    assert list(differences(made, made.tables)) == [], made_of(seed)


def test_every_test_of_the_rover_matters() -> None:
    made = compiled(model_of((SPECS / "rover.exo").read_text()))
    nodes = made.tables.nodes
    for number, node in enumerate(nodes):
        if node.code >= 0:
            changed = replace(node, low=node.high, high=node.low)
            assert found(made, replace(made.tables, nodes=(*nodes[:number], changed, *nodes[number + 1 :])))


@pytest.mark.parametrize("seed", [3, 7, 11])
def test_no_damage_is_missed_that_changes_a_decision(seed: int) -> None:
    subject = Subject(small_spec_of(seed))
    source = mutants(subject.built.tables, Random(seed))
    changing = 0
    for _ in range(12):
        way, mutant = next(source)
        tables = decode(pack(mutant))
        if subject.changes(tables):
            changing += 1
            assert found(subject.built.compiled, tables), f"{way}\n{subject.text}"
    assert changing > 2


def test_sums_and_large_ranges_are_exact() -> None:
    """No set of states is made where they are more than diagrams are for; and the least change of a bound is found."""
    made = compiled(model_of(LARGE))
    outcome = check_all(made, lambda what: None, CheckPlan(["tables"], engines=PORTFOLIO))
    said = {(each.verdict, each.engine) for each in outcome.findings if each.check == "tables"}
    assert said == {("holds", "bdd")}
    nodes, tested = made.tables.nodes, 0
    for number, node in enumerate(nodes):
        if node.code >= 0 and abs(node.bound) > 1000:
            tested += 1
            for way in (-1, 1):
                changed = replace(node, bound=node.bound + way)
                assert found(made, replace(made.tables, nodes=(*nodes[:number], changed, *nodes[number + 1 :])))
    assert tested >= 3


def test_entries_that_count_something_else_are_found() -> None:
    made = compiled(model_of(LARGE))
    tables = made.tables
    for number, feature in enumerate(tables.features):
        if feature.running != NONE:
            dropped = replace(feature, running=NONE)
            features = (*tables.features[:number], dropped, *tables.features[number + 1 :])
            assert found(made, replace(tables, features=features))
    for number, row in enumerate(tables.entries):
        entries = (*tables.entries[:number], replace(row, initial=row.initial + 1), *tables.entries[number + 1 :])
        assert found(made, replace(tables, entries=entries))
    for number, row in enumerate(tables.params):
        if row.value != NONE:
            params = (*tables.params[:number], replace(row, value=NONE), *tables.params[number + 1 :])
            assert found(made, replace(tables, params=params))


def test_what_differs_is_said_and_what_takes_too_long_is_unknown() -> None:
    made = compiled(model_of(LARGE))
    claim = Claim("tables", "ask m.go", None)
    said = Z3(made, NO_PROPERTIES).judge(claim)
    assert (said.verdict, said.method) == ("holds", "all states")
    asked = made.tables.below(made.tables.requests[0].decide)
    number = next(number for number in asked if made.tables.nodes[number].code >= 0)
    node = made.tables.nodes[number]
    nodes = (*made.tables.nodes[:number], replace(node, bound=node.bound + 1), *made.tables.nodes[number + 1 :])
    damaged = replace(made, tables=replace(made.tables, nodes=nodes))
    said = Z3(damaged, NO_PROPERTIES).judge(claim)
    assert (said.verdict, said.message) == ("violated", "the decision on `m.go`")
    said = Z3(damaged, NO_PROPERTIES, 0.0).judge(claim)
    assert (said.verdict, said.message) == ("unknown", "time limit")
