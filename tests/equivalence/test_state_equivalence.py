"""Tables that ask what the rules ask, in the same order, are compared without sets of states; others are not."""

from dataclasses import replace
from typing import NoReturn

import pytest

from exover.engines.bdd.loopsets import LoopSets
from exover.equivalence import state_equivalence as comparison
from exover.equivalence.entry_equivalence import plain_entries
from exover.equivalence.state_equivalence import StateComparison
from exover.loop.finite.builder import ClosedLoop
from exover.model.property import NO_PROPERTIES
from exover.ocrd import compile
from exover.ocrd.compile import Compiled, compile_model
from exover.ocrd.packing import pack
from exover.ocrd.tables import NONE, Node, Tables
from exover.proofs import bytes as proofs
from tests.support.engines import DIGEST, model_of

PLAIN = """spec plain;
poster battery: int in 0 .. 100 = 100;
poster height: real in 0 .. 9 = 1;
module m {
    request a(n: int in 0 .. 5) { fail low: when battery < 10; check n < 4 or n > 4; }
    request b() { fail deep: when height < 0.5; }
    request c();
}
mutex m.a, m.b;
mutex m.b over m.c;
limit few: at most 1 of m.a, m.c by wait;
forbid flat: active(m.a) and battery < 5 by kill m.a;
launch home: m.c() when battery in 10 .. 20;
"""
SLOTS = PLAIN.replace("active(m.a) and", "active(m.a with n == 1) and")


class Asked(Exception):
    """Sets of states were asked for."""


def asked(*_: object) -> NoReturn:
    raise Asked


class NoSets(LoopSets):
    """Sets that are not to be asked for."""

    stepper = property(asked)  # type: ignore[assignment]


@pytest.fixture(scope="module")
def compiled() -> Compiled:
    return compile_model(model_of(PLAIN), DIGEST)


def equal(compiled: Compiled, tables: Tables) -> bool:
    """Return whether tables are seen to be the rules; raises `Asked` if they are not alike."""
    loop = ClosedLoop(compiled.model, tables, compiled.entries)
    equivalence = StateComparison(NoSets(loop, NO_PROPERTIES))
    return all(map(equivalence.decides, compiled.model.requests)) and not list(equivalence.differences())


def test_what_is_alike_needs_no_sets(compiled: Compiled) -> None:
    assert equal(compiled, compiled.tables)


def test_no_other_action_bound_or_child_is_alike(compiled: Compiled) -> None:
    nodes = compiled.tables.nodes
    for number, node in enumerate(nodes):
        changes: list[Node] = [replace(node, bound=node.bound + 1)]
        if node.code >= 0:
            changes = [*changes, replace(node, low=node.high, high=node.low), replace(node, code=node.code + 1)]
        for changed in changes:
            with_it = replace(compiled.tables, nodes=(*nodes[:number], changed, *nodes[number + 1 :]))
            if -node.code not in (4, 7, 9):  # of launches and predicates nothing is read but what they are
                with pytest.raises((Asked, IndexError)):
                    equal(compiled, with_it)


def test_entries_are_plain_if_one_record_says_what_they_count(compiled: Compiled) -> None:
    tables = compiled.tables
    plain = plain_entries(compiled.model, tables)
    assert tuple(plain[entry] for entry in range(len(tables.entries))) == compiled.entries
    (first, *others) = tables.entries
    other_start = replace(tables, entries=(replace(first, initial=first.initial + 1), *others))
    assert plain.items() - plain_entries(compiled.model, other_start).items() == {(0, plain[0])}
    twice = replace(tables, features=(replace(tables.features[0], stopping=tables.features[0].running),))
    twice = replace(twice, features=twice.features + tables.features[1:])
    entry = tables.features[0].running
    assert plain_entries(compiled.model, twice).get(entry) != plain[entry]


def test_entries_that_count_by_arguments_are_not_plain() -> None:
    compiled = compile_model(model_of(SLOTS), DIGEST)
    plain = plain_entries(compiled.model, compiled.tables)
    assert 0 < len(plain) < len(compiled.entries)
    assert all(compiled.entries[entry] == element for entry, element in plain.items())


def test_plain_bytes_are_compared_without_the_compiler(compiled: Compiled, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(proofs, "digest", lambda model: DIGEST)
    monkeypatch.setattr(compile, "compile_model", asked)
    tables = compiled.tables
    assert list(proofs.differences(compiled.model, pack(tables))) == []
    more = replace(tables, rules=(*tables.rules, tables.rules[0]))
    found = list(proofs.differences(compiled.model, pack(more)))
    assert "rules, of which there are more than can be broken" in found
    with pytest.raises(Asked):
        model = model_of(SLOTS)
        list(proofs.differences(model, pack(compile_model(model, DIGEST).tables)))


LISTED = """spec listed;
poster fog: bool = false;
poster storm: bool = false;
module m {
    request a() { check clear: not fog; settle calm: until not storm; }
    request b();
    request c();
    request d() instances 2;
}
mutex first: m.a, m.b by wait;
mutex second: m.a, m.c;
limit crowd: at most 1 of m.d by wait;
"""


def test_decisions_that_ask_one_thing_after_another_need_no_diagram(monkeypatch: pytest.MonkeyPatch) -> None:
    """Wrong is: another order, another reason, another test, one left out, one more, no launch at the end."""
    found = compile_model(model_of(LISTED), DIGEST)
    tables, model = found.tables, found.model
    monkeypatch.setattr(comparison, "composed", asked)

    def decides(nodes: dict[int, Node], name: str) -> bool:
        changed = tuple(nodes.get(number, node) for number, node in enumerate(tables.nodes))
        loop = ClosedLoop(model, replace(tables, nodes=changed), found.entries)
        return StateComparison(NoSets(loop, NO_PROPERTIES)).decides(model.request[name])

    assert all(decides({}, request.name) for request in model.requests)
    first = tables.requests[1].decide
    test = tables.nodes[first]
    second = tables.nodes[test.low]
    assert test.code >= 0 and second.code >= 0 and tables.nodes[second.low].code < 0
    wrong = [
        {first: replace(second, low=test.low, high=test.high)},
        {first: replace(test, bound=test.bound + 1)},
        {first: replace(test, low=test.high, high=test.low)},
        {first: second},
        {first: replace(test, high=second.high)},
        {test.low: replace(second, low=NONE)},
        {second.low: tables.nodes[test.high]},
        {test.high: replace(tables.nodes[test.high], low=second.high)},
        {test.high: replace(tables.nodes[test.high], bound=tables.nodes[second.high].bound)},
    ]
    for nodes in wrong:
        with pytest.raises(Asked):
            decides(nodes, "m.b")
