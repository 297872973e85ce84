"""What one slot holds of a resource at most, by which of its shares can count together."""

import pytest

from exover.model.shares import most_held
from tests.support.engines import model_of

SHARES = [
    ("uses p 2 when kg > 100; uses p 1 when kg <= 100;", 2),
    ("uses p 2 when kg > 100; uses p 1 when kg <= 101;", 3),
    ("uses p 4; uses p 2 when kg > 100; uses p 1 when kg > 399;", 7),
    ("uses p 2 when fast; uses p 3 when not fast and kg > 3;", 3),
    ("uses p 2 when at == a; uses p 3 when at != b; uses p 9 when at == c;", 12),
    ("uses p 2 when v > 0.1; uses p 3 when v <= 0.1; uses p 4 when v < 0.1;", 7),
    ("uses p 2 when v > 0.1; uses p 3 when v < 0.1; uses p 4 when v == 0.1;", 4),
    ("uses p 2 when kg + n > 9; uses p 3 when kg + n <= 9;", 5),
    ("uses p 2 when n < 1; uses p 3 when n < 1; uses q 4 when n >= 1;", 5),
]


@pytest.mark.parametrize(("clauses", "most"), SHARES)
def test_the_most_that_a_slot_holds_is_that_of_shares_that_can_count_together(clauses: str, most: int) -> None:
    model = model_of(f"""spec s; enum e {{ a, b, c }} resource p: 99; resource q: 99; module m {{
    request r(kg: int in 1 .. 400, n: int in 0 .. 9, fast: bool, at: e, v: real in 0 .. 1) {{ {clauses} }} }}""")
    assert most_held(model, model.request["m.r"], "p") == most
