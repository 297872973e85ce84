"""Which comparisons ranges decide: those, and only those, that no valuation makes come out otherwise."""

from itertools import product

import pytest

from exover.model.evaluate import OPERATORS
from exover.model.expression import Compare, Const, Reading, Sum
from exover.model.ranges import Ranges
from tests.support.engines import model_of

MODEL = model_of("spec s; poster x: int in -1 .. 2 = 0; poster y: int in 1 .. 3 = 1; module m { request r(); }")
VALUES = {"x": range(-1, 3), "y": range(1, 4)}
TERMS = [
    (Reading("x"), lambda x, y: x),
    (Reading("y"), lambda x, y: y),
    (Sum(1, ((2, Reading("x")), (-1, Reading("y")))), lambda x, y: 1 + 2 * x - y),
]


@pytest.mark.parametrize("operator", OPERATORS)
@pytest.mark.parametrize("number", range(len(TERMS)))
def test_a_term_beside_a_constant_is_decided_as_all_its_values_are(number: int, operator: str) -> None:
    term, value = TERMS[number]
    values = [value(x, y) for x, y in product(*VALUES.values())]
    for constant in range(min(values) - 2, max(values) + 3):
        outcomes = {OPERATORS[operator](each, constant) for each in values}
        if constant in values or not min(values) < constant < max(values):  # a range has no holes
            found = [each.truth for each in Ranges(MODEL).decided(Compare(operator, term, Const(constant)))]
            assert found == (list(outcomes) if len(outcomes) == 1 else []), constant


SPEC = """spec s; enum e { a, b } poster at: e = a; poster on: bool = true;
poster free: real = 0; poster t: real in 0 .. 10 = 0;
resource fuel: 8 consumable; resource power: 9;
latch gale: when t > 10 until m.s; latch windy: when t > 9 until m.s; latch lit: when on or t >= 0 until m.s;
latch both: when gale and on until m.s; latch ever: when true until m.s;
module m { state pose: { in_a, out_b, up } = in_a; state k: int in 0 .. 9 = 2;
    request s() { on ok set pose = out_b; on launch set k = 5; }
    request r(n: int in 0 .. 9) fails (bad) { consumes fuel 1; uses power 1;
        uses power 4 when n > 2; check CONDITION; } }"""


@pytest.mark.parametrize(
    ("condition", "told"),
    [
        ("t > 10", ["`t > 10` is false whatever happens: t lies in 0 .. 10"]),
        ("t < 10", []),
        ("t in 5 .. 3 or n in 4 .. 4", ["`t in 5 .. 3` is false whatever happens: the bounds are swapped"]),
        ("on and not past(m.r with n in 6 .. 2)", ["`n in 6 .. 2` is false whatever happens: the bounds are swapped"]),
        ("free > 1e300 or on or at == b or used(power) < 5", []),
        ("used(power) > 5", ["`used(power) > 5` is false whatever happens: used(power) lies in 0 .. 5"]),
        ("level(fuel) <= 8", ["`level(fuel) <= 8` is true whatever happens: level(fuel) lies in 0 .. 8"]),
        ("n < 12", ["`n < 12` is true whatever happens: n lies in 0 .. 9"]),
        ("not past(m.r with n == 12)", ["`n == 12` is false whatever happens: n lies in 0 .. 9"]),
        ("not past(m.r with n > self.n)", []),
        ("m.pose == up", ["`m.pose == up` is false whatever happens: m.pose is in_a or out_b"]),
        ("up != m.pose", ["`up != m.pose` is true whatever happens: m.pose is in_a or out_b"]),
        ("m.pose == out_b or m.pose != in_a or m.k > 2 or m.k == 5 or at == b", []),
        ("m.k < 2", ["`m.k < 2` is false whatever happens: m.k is 2 or 5"]),
        ("n in 0 .. 5 or t in 3 .. 99 or k in 2 .. 4", []),
        (
            "n in 0 .. 12",
            [f"`n {end}` is true whatever happens: n lies in 0 .. 9" for end in (">= 0", "<= 12")],
        ),
        ("n in 12 .. 20", ["`n >= 12` is false whatever happens: n lies in 0 .. 9"]),
        ("n != n or n > 3", ["`n != n` is false whatever happens: both sides are the same"]),
        (
            "not past(m.r with n == n)",
            ["`n == n` is true whatever happens: both sides are the same; did you mean `self.n`?"],
        ),
        ("lit or windy", ["`lit` is true whatever happens: `t >= 0` is true, t lies in 0 .. 10"]),
        (
            "not both",
            [
                "`both` is false whatever happens: `gale` is false, `t > 10` is false, t lies in 0 .. 10",
            ],
        ),
        ("ever or on", ["`ever` is true whatever happens: its condition is constant"]),
        ("3 < m.k and m.k != 3", ["`m.k != 3` is true whatever happens: m.k is 2 or 5"]),
    ],
)
def test_what_is_decided_is_told_with_the_range(condition: str, told: list[str]) -> None:
    model = model_of(SPEC.replace("CONDITION", condition))
    request = model.request["m.r"]
    (guard,) = request.guards
    assert list(map(str, Ranges(model).decided(guard.condition, request.params))) == told


def test_a_chain_of_latches_is_decided_latch_by_latch() -> None:
    latches = "".join(f"latch l{i}: when l{i - 1} or l{i - 2} until m.r; " for i in range(2, 400))
    model = model_of(
        f"spec s; poster t: int in 0 .. 9 = 0; latch l0: when t > 9 until m.r; latch l1: when l0 until m.r; {latches}"
        "module m { request r() { check not l1; check not l2; check not l399; } }"
    )
    ranges = Ranges(model)
    told = [str(each) for guard in model.request["m.r"].guards for each in ranges.decided(guard.condition)]
    assert told == [
        "`l1` is false whatever happens: `l0` is false, `t > 9` is false, t lies in 0 .. 9",
        "`l2` is false whatever happens: `l1` is false; `l0` is false, `t > 9` is false, t lies in 0 .. 9",
        "`l399` is false whatever happens: `l398` is false; `l397` is false",
    ]
