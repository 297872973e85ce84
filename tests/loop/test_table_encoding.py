"""Sums of the tables as terms: what they count, and in how many flags."""

from dataclasses import replace

from exover.loop.exact.layout import Layout
from exover.loop.exact.symbolic_state import SymbolicState
from exover.loop.exact.table_encoding import LinearForm, TableEncoding
from exover.loop.exact.term import Terms
from exover.ocrd.compile import Compiled, compile_model
from tests.support.engines import DIGEST, model_of

TEXT = """spec s;
resource power: 5 by wait;
module m {
    request a(fast: bool) instances 2 { uses power 2; uses power 1 when fast; }
    request b() { interrupts m.a; uses power 3; }
}"""


def power(made: Compiled) -> LinearForm:
    """Return the largest sum of the tables."""
    layout = Layout(made.model, Terms())
    encoding, state = TableEncoding(layout, made.tables), SymbolicState(layout.terms, dict(layout.vars))
    forms = [encoding.entry(state, None, entry) for entry in sorted({entry for entry, _ in made.tables.sums})]
    return max((form for form in forms if isinstance(form, LinearForm)), key=lambda form: len(form.flags))


def test_a_slot_is_one_flag_of_a_sum_whether_it_runs_or_is_stopping() -> None:
    found = power(compile_model(model_of(TEXT), DIGEST))
    assert sorted(weight for weight, _ in found.flags) == [1, 1, 2, 2, 3]


def test_a_part_that_damaged_tables_name_twice_counts_twice() -> None:
    made = compile_model(model_of(TEXT), DIGEST)
    whole = power(made)
    sums = list(made.tables.sums)
    row = next(each for each in made.tables.entries if each.sums_end - each.sums > 2)
    sums[row.sums_end - 1] = sums[row.sums_end - 2]
    doubled = power(replace(made, tables=replace(made.tables, sums=tuple(sums))))
    assert sorted(weight for weight, _ in doubled.flags) == sorted([*(weight for weight, _ in whole.flags), 3])
