"""The bit rows and what reasons say of them, written down by hand."""

from exover.model.event import Ask, Waits
from exover.ocrd.conflicts import conflicts, row
from exover.ocrd.machine import Machine
from exover.ocrd.reasons import reasons
from exover.ocrd.tables import ALL_DENIALS, CLEARINGS, NO_DENIALS, ConflictRow
from tests.support.engines import model_of, tables_of

MODEL = model_of(
    """spec rows;
    poster p: bool = false;
    module m {
        request a(); request b(); request c() { interrupts self else wait; check not active(m.a); }
        request d(n: int in 0 .. 3) { interrupts m.b else wait; } request e();
    }
    mutex still: m.a, m.b;
    mutex drive: m.c over m.d;
    forbid both: active(m.a) and active(m.e) by wait;
    forbid three: active(m.b) and active(m.c) and active(m.e);
    forbid seen: active(m.b) and active(m.e) and p;
    forbid some: active(m.a) and active(m.d with n > 1);
    limit one: at most 1 of m.d, m.e;"""
)
A, B, C, D, E = range(5)


def test_rows() -> None:
    assert conflicts(MODEL) == tuple(map(frozenset, ([A, B, E], [A, B, D], [C, D], [B, C, D], [A, E])))


def test_a_request_with_several_slots_conflicts_with_itself_only_if_it_interrupts_itself() -> None:
    text = "spec s; module m {{ request a() instances 2{} }}"
    assert conflicts(model_of(text.format(";"))) == (frozenset(),)
    assert conflicts(model_of(text.format(" { interrupts self; }"))) == (frozenset([0]),)


def test_blocks() -> None:
    assert row(frozenset([0, 15, 16, 47])) == [
        ConflictRow(0, 1 - (1 << 15)),
        ConflictRow(1, 1),
        ConflictRow(2, -(1 << 15)),
    ]
    assert row(frozenset()) == []


def test_only_rules_that_can_tell_say_so() -> None:
    tables = tables_of(MODEL)
    said = {reason.rule: row.denials for reason, row in zip(reasons(MODEL), tables.reasons, strict=True)}
    assert {name: said.pop(name) for name in ("busy", "still", "both")} == dict.fromkeys(
        ("busy", "still", "both"), ALL_DENIALS
    )
    kills = ("drive", "m.d.interrupts.m.b", "m.c.interrupts.self")
    assert {name: said.pop(name) for name in kills} == dict.fromkeys(kills, CLEARINGS)
    assert set(said.values()) == {NO_DENIALS} and len(said) == 5


def test_busy_says_nothing_where_a_request_has_several_slots() -> None:
    model = model_of("spec s; module m { request a() instances 2; request b(); } mutex m.a, m.b;")
    assert [row.denials for row in tables_of(model).reasons] == [NO_DENIALS, ALL_DENIALS]


def test_a_request_that_is_never_to_be_active_is_refused_without_a_conflict() -> None:
    """With several slots it is in no row, and the second channel must not wonder why it waits."""
    model = model_of("spec s; module m { request a() instances 2; } forbid active(m.a) and active(m.a) by wait;")
    machine = Machine(model, tables_of(model))
    assert conflicts(model) == (frozenset(),)
    assert machine.step(Ask("m.a", ())) == (Waits("m.a", "forbid.1"),)
