"""What rules exclude by their form."""

import pytest

from exover.checks.causes.excluded import kept
from tests.support.engines import model_of

MODEL = model_of("""spec s; resource kw: 60 by wait; resource oil: 20 by wait; resource gas: 9; resource lone: 3;
module m {
    request open() { uses kw 40; uses oil 15; uses lone 1; }
    request close() { interrupts m.open; uses kw 40; }
    request turn() { uses kw 15; uses gas 5; }
    request wash() instances 2 { uses oil 6; uses gas 5; }
}
mutex shower: m.wash, m.open by wait; limit few: at most 2 of m.wash, m.open, m.close; limit all: at most 3 of m.*;
mutex dry: m.wash, m.close;""")


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("kw", ["`m.close.interrupts.m.open` leaves at most 55 of 60 taken at a time"]),
        ("oil", ["`shower` leaves at most 15 of 20 taken at a time"]),
        ("few", ["`m.close.interrupts.m.open`, `shower`, `dry` leave at most 2 of 2 taken at a time"]),
        ("all", ["`m.close.interrupts.m.open`, `shower`, `dry` leave at most 3 of 3 taken at a time"]),
        ("gas", []),
        ("lone", []),
        ("dry", []),
    ],
)
def test_how_much_rules_leave_is_told_if_that_keeps_a_resource_or_limit(name: str, told: list[str]) -> None:
    assert list(kept(MODEL, name)) == told
