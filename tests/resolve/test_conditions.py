"""What names, terms and conditions of docs/language.md section 2 come down to."""

import pytest

from exover.model.expression import (
    FALSE,
    TRUE,
    And,
    Compare,
    Cond,
    Const,
    Last,
    Level,
    ModelTerm,
    Not,
    Or,
    Own,
    Param,
    Past,
    Reading,
    Status,
    Sum,
    Used,
)
from tests.resolve.specs import world

A, B = Status("active", "m.a"), Status("active", "m.b")
HOT = Compare("==", Reading("hot"), Const(True))
BATTERY, SPEED, TOOL = Reading("battery"), Reading("speed"), Reading("m.tool")
X, V = Param("x"), Param("v")


def added(constant: int, *terms: tuple[int, ModelTerm]) -> Sum:
    """Return a sum."""
    return Sum(constant, terms)


def about(where: Cond) -> Status:
    """Return `active(m.c with where)`."""
    return Status("active", "m.c", where)


# As a `check` of m.c.
CONDITIONS = {
    # names
    "x == 1": Compare("==", X, Const(1)),
    "self.x == 1": Compare("==", X, Const(1)),
    "on": Compare("==", Param("on"), Const(True)),
    "reach > 1": Compare(">", Reading("m.reach"), Const(1)),
    "m.reach > 1": Compare(">", Reading("m.reach"), Const(1)),
    "tool == none": Compare("==", TOOL, Const("none")),
    "none != tool": Compare("!=", Const("none"), TOOL),
    "hot": HOT,
    "tripped": Compare("==", Reading("tripped"), Const(True)),
    "calm": Compare("<=", SPEED, Const(0.5)),
    "at == home": Compare("==", Param("at"), Const("base")),
    "at == field": Compare("==", Param("at"), Const("field")),
    "battery > three": Compare(">", BATTERY, Const(3)),
    # connectives
    "not hot": Not(HOT),
    "hot and calm and on": And((HOT, Compare("<=", SPEED, Const(0.5)), Compare("==", Param("on"), Const(True)))),
    "hot or on": Or((HOT, Compare("==", Param("on"), Const(True)))),
    "hot implies on": Or((Not(HOT), Compare("==", Param("on"), Const(True)))),
    # shorthand
    "x in 1 .. 3": And((Compare(">=", X, Const(1)), Compare("<=", X, Const(3)))),
    "v in 1 .. half": And((Compare(">=", V, Const(1.0)), Compare("<=", V, Const(0.5)))),
    "x in {1, 2}": Or((Compare("==", X, Const(1)), Compare("==", X, Const(2)))),
    "tool in {none, gripper}": Or((Compare("==", TOOL, Const("none")), Compare("==", TOOL, Const("gripper")))),
    "tool in {none}": Compare("==", TOOL, Const("none")),
    "hot in {false}": Compare("==", Reading("hot"), Const(False)),
    # predicates
    "active(m.a)": A,
    "active(both)": Or((A, B)),
    "running(m.a, m.b)": Or((Status("running", "m.a"), Status("running", "m.b"))),
    "stopping(m.a)": Status("stopping", "m.a"),
    "waiting(m.*)": Or((Status("waiting", "m.a"), Status("waiting", "m.b"), Status("waiting", "m.c"))),
    "past(both)": Or((Past("m.a"), Past("m.b"))),
    "last(m.a) == failed": Last("m.a", "failed"),
    "last(m.a) != none": Not(Last("m.a", "none")),
    "used(power) >= 3": Compare(">=", Used("power"), Const(3)),
    "level(film) < 2": Compare("<", Level("film"), Const(2)),
    # inside `with`
    "active(m.c with x == self.x)": about(Compare("==", X, Own("x"))),
    "active(m.c with x + self.x > 3)": about(Compare(">", added(0, (1, X), (1, Own("x"))), Const(3))),
    "active(m.c with on and at == field)": about(
        And((Compare("==", Param("on"), Const(True)), Compare("==", Param("at"), Const("field"))))
    ),
    "active(m.c with at == self.at)": about(Compare("==", Param("at"), Own("at"))),
    "active(m.c with v < w)": about(Compare("<", V, Param("w"))),
    "past(m.c with dist > v)": Past("m.c", Compare(">", Param("dist"), V)),
    "past(m.c with n == x)": Past("m.c", Compare("==", Param("n"), X)),
    # reals: the nearest double, whatever is written
    "v < 2": Compare("<", V, Const(2.0)),
    "v < 0.1": Compare("<", V, Const(0.1)),
    "1e-1 > v": Compare(">", Const(0.1), V),
    "v > -0": Compare(">", V, Const(0.0)),
    "v > 0.1000000000000000055511151231257827021181583404541015625": Compare(">", V, Const(0.1)),
    "v < w": Compare("<", V, Param("w")),
    "v < top": Compare("<", V, Reading("top")),
    "speed < top": Compare("<", SPEED, Reading("top")),
    # integers
    "x + 1 > battery": Compare(">", added(1, (1, X)), BATTERY),
    "2 * x - battery + 3 - 1 > 0": Compare(">", added(2, (2, X), (-1, BATTERY)), Const(0)),
    "x + x > 3": Compare(">", added(0, (2, X)), Const(3)),
    "x + battery - battery > 3": Compare(">", X, Const(3)),
    "three * x * -2 > 3": Compare(">", added(0, (-6, X)), Const(3)),
    "x > 2 * three + 1": Compare(">", X, Const(7)),
    "x + -9223372036854775808 < 0": Compare("<", added(-(2**63), (1, X)), Const(0)),
    "x - 9223372036854775808 < 0": Compare("<", added(-(2**63), (1, X)), Const(0)),
    "x > -5": Compare(">", X, Const(-5)),
    "battery > 9223372036854775807": Compare(">", BATTERY, Const(2**63 - 1)),
}
# As the value of a clause that may be constant: constants are decided at once.
CONSTANTS = {
    "true": TRUE,
    "not false": Not(FALSE),
    "x - x == 0": TRUE,
    "three < 4": TRUE,
    "half > 1": FALSE,
    "true != true": FALSE,
}


@pytest.mark.parametrize(("text", "meaning"), CONDITIONS.items(), ids=CONDITIONS.keys())
def test_condition(text: str, meaning: Cond) -> None:
    (guard,) = world(f"context m.c {{ check {text}; }}").request["m.c"].guards
    assert guard.condition == meaning
    assert repr(guard.condition) == repr(meaning)  # 1 == 1.0 == True


@pytest.mark.parametrize(("text", "meaning"), CONSTANTS.items(), ids=CONSTANTS.keys())
def test_constant_condition(text: str, meaning: Cond) -> None:
    word = "check" if meaning == FALSE else "fail when"
    found = world(f"context m.c {{ {word} {text}; }}")
    guards = [guard.condition for guard in found.request["m.c"].guards]
    assert guards + [rule.condition for rule in found.rules[1:]] == [meaning]


def test_names_outside_clauses() -> None:
    found = world(
        """define odd = tripped and (m.tool == none or calm);
        forbid active(m.c with x == 3) and odd; launch m.a() when odd and waiting(m.b);"""
    )
    tripped = Compare("==", Reading("tripped"), Const(True))
    odd = And((tripped, Or((Compare("==", TOOL, Const("none")), Compare("<=", SPEED, Const(0.5))))))
    assert found.rules[-1].condition == And((about(Compare("==", X, Const(3))), odd))
    assert found.launches[0].condition == And((odd, Status("waiting", "m.b")))


def test_the_nearer_name_wins() -> None:
    found = world(
        """poster shared: int in 0 .. 1 = 0; poster kept: int in 0 .. 1 = 0; const gripper_ = 3; enum e { kept, other }
        module z {
            poster shared: int in 0 .. 2 = 0; poster kept_: bool = true; state mode: {none, other} = none;
            request r(shared: int in 0 .. 3, none: bool) { check shared == 1; check none; check mode == other; }
            request s() { check shared == 1; check kept == 1; check mode == none; }
        }
        context z.s { check shared == 2; }
        """
    )
    conditions = [guard.condition for guard in found.request["z.r"].guards]
    assert conditions == [
        Compare("==", Param("shared"), Const(1)),
        Compare("==", Param("none"), Const(True)),
        Compare("==", Reading("z.mode"), Const("other")),
    ]
    conditions = [guard.condition for guard in found.request["z.s"].guards]
    assert conditions == [
        Compare("==", Reading("z.shared"), Const(1)),
        Compare("==", Reading("kept"), Const(1)),
        Compare("==", Reading("z.mode"), Const("none")),
        Compare("==", Reading("z.shared"), Const(2)),
    ]


def test_inside_with_posters_hide_nothing() -> None:
    found = world(
        """poster field: bool = true; const limit = 2;
        forbid active(m.c with at == field and x > limit and v > half) and field;"""
    )
    where = And((Compare("==", Param("at"), Const("field")), Compare(">", X, Const(2)), Compare(">", V, Const(0.5))))
    assert found.rules[-1].condition == And((about(where), Compare("==", Reading("field"), Const(True))))


def test_reals_are_compared_where_it_is_allowed() -> None:
    found = world(
        """define fast = speed > top;
        context m.c { check fast; wait until v < speed; settle until fast; fail when v > top or fast;
                      uses power 1 when v < w; }
        forbid active(m.c with v >= w) and speed > half;"""
    )
    fast = Compare(">", SPEED, Reading("top"))
    conditions = [guard.condition for guard in found.request["m.c"].guards]
    assert conditions == [fast, Compare("<", V, SPEED), fast]
    assert [rule.condition for rule in found.rules[1:]] == [
        Or((Compare(">", V, Reading("top")), fast)),
        And((about(Compare(">=", V, Param("w"))), Compare(">", SPEED, Const(0.5)))),
    ]
    assert found.request["m.c"].shares[0].when == Compare("<", V, Param("w"))


def test_enums_are_one_type_if_they_list_the_same() -> None:
    found = world(
        """enum grip { none, gripper } poster p: grip = none;
        module z { request r(g: {none, gripper}) { check g == m.tool; check p == g; check p in {g, none}; } }"""
    )
    first, second, third = (guard.condition for guard in found.request["z.r"].guards)
    assert first == Compare("==", Param("g"), TOOL)
    assert second == Compare("==", Reading("p"), Param("g"))
    assert third == Or((Compare("==", Reading("p"), Param("g")), Compare("==", Reading("p"), Const("none"))))


def test_groups_hold_groups() -> None:
    found = world("group g = o.*, h; group h = both; forbid active(g) by kill g;")
    assert found.rules[-1].condition == Or((Status("active", "o.d"), A, B))


def test_a_rule_may_read_what_no_remedy_changes() -> None:
    found = world(
        """latch l: when battery < 3 or level(film) < 1 or tripped until m.a;
        forbid active(m.a) and past(m.b) and used(power) > 1 and level(film) > 1 and battery > 3 and m.tool == none
            and l and active(m.c with x > 3);"""
    )
    assert len(found.latches) == 2
    assert len(found.rules) == 2
