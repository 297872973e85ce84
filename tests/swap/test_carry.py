"""Of a request that NEW changes nothing is carried over: its slots have to be idle, and its past is forgotten."""

import pytest

from exover.pipeline import build
from exover.swap.carry import Carry
from exover.swap.record import Argument, CarriedLast, CarriedPast, CarriedPhase, RecordField
from tests.support.engines import model_of

REQUEST = "request go(v: int in 0 .. 9, fast: bool) returns (far: int in 0 .. 9) fails (blocked, lost) instances 2;"
SPEC = """spec s;
module m {{ {} request next() {{
    check last(m.go) == failed or past(m.go with v > 3 and fast) or active(m.go with v > 3 and fast);
}} }}
"""
CHANGES = {
    "other statuses": ("(blocked, lost)", "(lost, blocked)"),
    "more statuses": ("(blocked, lost)", "(blocked, lost, stuck)"),
    "other results": ("returns (far: int in 0 .. 9)", "returns (far: int in 0 .. 8)"),
    "parameters in another order": ("v: int in 0 .. 9, fast: bool", "fast: bool, v: int in 0 .. 9"),
    "a smaller range": ("v: int in 0 .. 9", "v: int in 0 .. 8"),
    "fewer instances": (" instances 2", ""),
}


def carry_of(request: str) -> Carry:
    return Carry(build(model_of(SPEC.format(REQUEST))).compiled, build(model_of(SPEC.format(request))).compiled)


def about(carry: Carry, name: str) -> list[RecordField]:
    kinds = CarriedLast | CarriedPast | CarriedPhase | Argument
    found = [number for number in carry.after if isinstance(number, kinds) and number.request == name]
    assert {type(number) for number in found} >= {CarriedLast, CarriedPhase}
    return found


def test_what_is_not_changed_is_carried() -> None:
    carry = carry_of(REQUEST)
    assert not carry.changed and all(
        carry.remembers(number) for name in ("m.go", "m.next") for number in about(carry, name)
    )


@pytest.mark.parametrize(("old", "new"), CHANGES.values(), ids=CHANGES)
def test_of_a_request_that_is_changed_nothing_is_carried(old: str, new: str) -> None:
    carry = carry_of(REQUEST.replace(old, new))
    assert carry.changed == {"m.go"}
    assert not any(carry.remembers(number) for number in about(carry, "m.go"))
    assert all(carry.remembers(number) for number in about(carry, "m.next"))


def test_a_request_that_is_gone_has_to_be_idle() -> None:
    old, new = SPEC.format(REQUEST), "spec s; module m { request next(); }"
    assert Carry(build(model_of(old)).compiled, build(model_of(new)).compiled).changed == {"m.go"}
