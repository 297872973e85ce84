"""The loop remembers of what is past all that conditions read, whether a table tests it or not."""

from exover.loop.finite.builder import ClosedLoop
from exover.ocrd.compile import compile_model
from exover.ocrd.tables import NONE
from tests.support.engines import DIGEST, model_of
from tests.support.small import compiled, findings_of


def verdict(text: str, check: str, subject: str) -> str:
    findings = findings_of(compiled(model_of(text)))
    (found,) = (each.verdict for each in findings if (each.check, each.subject) == (check, subject))
    return found


def test_an_argument_and_a_result_may_lie_in_one_gap_in_either_order() -> None:
    ranges = "request go(x: real in 0 .. 2) returns (y: real in 0 .. 2);"
    for order in ("x < y", "x > y", "x == y"):
        guard = f"check past(m.go with {order} and x > 1 and y < 2 and y > 1);"
        text = f"spec s; module m {{ {ranges} request b() {{ {guard} }} }}"
        assert verdict(text, "reachability", "m.b") == "holds", order


def test_what_no_table_tests_is_remembered_all_the_same() -> None:
    """The tables leave out the test of `last`: a slot that stops has not ended, so b is never launched anyway."""
    text = """spec s;
    module m {
        request a() { uses power 1; }
        request b() { uses power 1; check last(m.b) == ok and past(m.a with k == 1) and stopping(m.b); }
    }
    resource power: 1;"""
    text = text.replace("request a()", "request a(k: int in 0 .. 3)")
    model = model_of(text)
    compiled_model = compile_model(model, DIGEST)
    loop = ClosedLoop(model, compiled_model.tables, compiled_model.entries)
    assert all(request.last == NONE for request in compiled_model.tables.requests)
    assert not compiled_model.tables.pasts
    assert {("past", 0), ("last", 1)} <= loop.index.keys()
    assert verdict(text, "tables", "ask m.b") == "holds"


def test_a_past_is_one_variable_however_many_conditions_read_it() -> None:
    """What nobody tells apart is one: here none, k == 0, k == 1 and the others."""
    guards = " ".join(f"check past(m.a with k == {k});" for k in (0, 1))
    model = model_of(f"spec s; module m {{ request a(k: int in 0 .. 9); request b() {{ {guards} }} }}")
    made = compile_model(model, DIGEST)
    loop = ClosedLoop(model, made.tables, made.entries)
    assert loop.variables[loop.index["past", 0]].size == 4
