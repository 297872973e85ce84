"""Shorthand, names and places of rules: what each construct of docs/language.md comes down to."""

from exover.model.expression import And, Compare, Cond, Const, Count, Param, Past, Reading, Status, Used
from exover.model.model import (
    Consumption,
    Forget,
    Guard,
    Kill,
    KillSlot,
    Latch,
    Launch,
    Location,
    Model,
    Reject,
    Remedy,
    Resource,
    Rule,
    SetState,
    Share,
    Wait,
)
from exover.model.types import Bool, Enum, Int, Real
from tests.resolve.specs import model, world


def both(first: str, second: str) -> And:
    """Return the condition that two requests are active together."""
    return And((Status("active", first), Status("active", second)))


def rules(found: Model) -> list[tuple[str, str, Cond, tuple[Remedy, ...]]]:
    """Return the rules without the world's own resource, places and texts."""
    return [(rule.name, rule.kind, rule.condition, rule.remedies) for rule in found.rules if rule.kind != "resource"]


def test_mutex_is_a_rule_for_each_pair() -> None:
    found = world("mutex m.a, m.b, o.d; mutex w: m.a, m.b by kill m.b or wait because 'no';".replace("'", '"'))
    reject = (Reject(),)
    assert rules(found) == [
        ("mutex.1", "mutex", both("m.a", "m.b"), reject),
        ("mutex.1", "mutex", both("m.a", "o.d"), reject),
        ("mutex.1", "mutex", both("m.b", "o.d"), reject),
        ("w", "mutex", both("m.a", "m.b"), (Kill(("m.b",)), Wait())),
    ]
    assert [rule.because for rule in found.rules[1:]] == [None, None, None, "no"]
    places = [rule.place for rule in found.rules]
    assert places == sorted(set(places))


def test_over_is_a_rule_for_each_winner_and_loser() -> None:
    found = world("mutex m.a, m.b over o.d, m.c; mutex o.d over both else wait;")
    assert rules(found) == [
        ("mutex.1", "over", both("m.a", "o.d"), (Kill(("o.d",)),)),
        ("mutex.1", "over", both("m.a", "m.c"), (Kill(("m.c",)),)),
        ("mutex.1", "over", both("m.b", "o.d"), (Kill(("o.d",)),)),
        ("mutex.1", "over", both("m.b", "m.c"), (Kill(("m.c",)),)),
        ("mutex.2", "over", both("o.d", "m.a"), (Kill(("m.a",)), Wait())),
        ("mutex.2", "over", both("o.d", "m.b"), (Kill(("m.b",)), Wait())),
    ]


def test_names_count_labelled_statements_too() -> None:
    found = world(
        """
        mutex first: m.a, m.b; mutex m.a over m.b; mutex m.a, o.d;
        forbid active(m.a); forbid second: active(m.b); forbid active(o.d);
        limit at most 1 of m.*; limit third: at most 1 of m.a, m.b; limit at most 0 of m.a;
        launch m.a() when hot; launch fourth: m.b() when hot; launch m.b() when calm;
        context m.a { check hot; wait calm: until hot; check l: hot; check hot; settle until hot; fail when hot; }
        context m.a { check hot; wait until hot; settle s: until hot; fail when hot; }
        """
    )
    assert [rule.name for rule in found.rules[1:]] == [
        *("first", "mutex.2", "mutex.3", "forbid.1", "second", "forbid.3", "limit.1", "third", "limit.3"),
        *("m.a.fail.1", "m.a.fail.2"),
    ]
    assert [launch.name for launch in found.launches] == ["launch.1", "fourth", "launch.3"]
    assert [guard.name for guard in found.request["m.a"].guards] == [
        *("m.a.check.1", "m.a.calm", "m.a.l", "m.a.check.3", "m.a.settle.1", "m.a.check.4", "m.a.wait.2", "m.a.s"),
    ]


def test_limit_counts_slots() -> None:
    found = world("limit l: at most 2 of m.*, o.d by kill both or wait;")
    count = Compare(">", Count(("m.a", "m.b", "m.c", "o.d")), Const(2))
    assert rules(found) == [("l", "limit", count, (Kill(("m.a", "m.b")), Wait()))]


def test_forbid_rejects_unless_it_says_otherwise() -> None:
    found = world("forbid active(m.a) and hot; forbid used(power) > 7 by kill m.b; context m.b { uses power 8; }")
    assert rules(found) == [
        ("forbid.1", "forbid", And((Status("active", "m.a"), Compare("==", Reading("hot"), Const(True)))), (Reject(),)),
        ("forbid.2", "forbid", Compare(">", Used("power"), Const(7)), (Kill(("m.b",)),)),
    ]


def test_interrupts() -> None:
    found = world("context m.b { interrupts o.d, self, both_; } group both_ = m.a;")
    twice = Compare(">", Count(("m.b",)), Const(1))
    assert rules(found) == [
        ("m.b.interrupts.o.d", "interrupts", both("m.b", "o.d"), (Kill(("o.d",)),)),
        ("m.b.interrupts.self", "interrupts", twice, (Kill(("m.b",)),)),
        ("m.b.interrupts.m.a", "interrupts", both("m.b", "m.a"), (Kill(("m.a",)),)),
    ]
    assert [request.name for request in found.requests if request.interrupts_self] == ["m.b"]
    found = world("context m.b { interrupts all else wait; }")
    assert rules(found) == [
        ("m.b.interrupts.m.a", "interrupts", both("m.b", "m.a"), (Kill(("m.a",)), Wait())),
        ("m.b.interrupts.m.c", "interrupts", both("m.b", "m.c"), (Kill(("m.c",)), Wait())),
    ]


def test_fail_is_a_rule_for_each_slot() -> None:
    found = world('context m.c { fail low: when x > battery because "low"; fail when hot else wait; }')
    first, second = found.rules[1:]
    condition = Compare(">", Param("x"), Reading("battery"))
    assert first == Rule("m.c.low", "fail", condition, (KillSlot(),), "low", first.place, "m.c")
    assert (second.name, second.remedies, second.slot_of) == ("m.c.fail.2", (KillSlot(), Wait()), "m.c")


def test_after_and_before_are_checks() -> None:
    found = world(
        """
        context m.a { before m.b, o.d because "first a"; }
        context m.b { check hot; after o.d because "d"; }
        """
    )
    place = found.rules[0].place
    assert found.request["m.b"].guards == (
        Guard("check", "m.a.before.m.b", Past("m.a"), "first a", place + 1),
        Guard("check", "m.b.check.1", Compare("==", Reading("hot"), Const(True)), None, place + 3),
        Guard("check", "m.b.after.o.d", Past("o.d"), "d", place + 4),
    )
    assert found.request["o.d"].guards == (Guard("check", "m.a.before.o.d", Past("m.a"), "first a", place + 2),)


def test_places_follow_the_text() -> None:
    found = model(
        """spec t;
        context m.r { check first: hot; }
        mutex m.r, m.s;
        module m {
            request r() { fail when hot; consumes film 1; wait w: until hot; interrupts self; before m.s; }
            request s() { settle until hot; }
        }
        resource film: 3 consumable;
        resource power: 10;
        poster hot: bool = true;
        context m.r { check last: hot; }
        """
    )
    places = {rule.name: rule.place for rule in found.rules}
    for request in found.requests:
        places |= {guard.name: guard.place for guard in request.guards}
    places["consumes"] = found.request["m.r"].consumptions[0].place
    assert sorted(places, key=places.__getitem__) == [
        *("m.r.first", "mutex.1", "m.r.fail.1", "consumes", "m.r.w", "m.r.interrupts.self", "m.r.before.m.s"),
        *("m.s.settle.1", "power", "m.r.last"),
    ]
    assert len(set(places.values())) == len(places)
    assert [rule.place for rule in found.rules] == sorted(rule.place for rule in found.rules)
    assert [guard.name for guard in found.request["m.r"].guards] == ["m.r.first", "m.r.w", "m.r.last"]


def test_resources() -> None:
    found = model(
        """spec t; module m { request r(big: bool) {
            uses power 3; uses power 4 when big; consumes film 1 when not big because "one"; produces film 2; } }
        resource power: 10 by kill m.r or wait because "hungry"; resource film: 3 consumable = 1 by wait;
        resource full: 4 consumable;"""
    )
    big = Compare("==", Param("big"), Const(True))
    remedies = (Kill(("m.r",)), Wait())
    assert found.resources == (
        Resource("power", 10, False, 10, remedies, "hungry"),
        Resource("film", 3, True, 1, (Wait(),)),
        Resource("full", 4, True, 4, (Reject(),)),
    )
    (rule,) = found.rules
    assert rule == Rule("power", "resource", Compare(">", Used("power"), Const(10)), remedies, "hungry", rule.place)
    request = found.request["m.r"]
    assert request.shares == (Share("power", 3), Share("power", 4, big))
    (consumption,) = request.consumptions
    assert consumption.when is not None
    assert consumption == Consumption("film", 1, consumption.when, "one", consumption.place)
    assert request.productions == (Share("film", 2),)


def test_effects_in_the_order_of_the_text() -> None:
    found = world(
        """module z { state n: int in 0 .. 9 = 0; request r() {
            on launch set n = three; on ok set m.tool = gripper; on ok forget both; on failed forget z.r;
            on interrupted set n = 1; } }
        context z.r { on ok set n = 2; }"""
    )
    request = found.request["z.r"]
    assert request.on_launch == (SetState("z.n", 3),)
    assert request.on_ok == (SetState("m.tool", "gripper"), Forget(("m.a", "m.b")), SetState("z.n", 2))
    assert request.on_failed == (Forget(("z.r",)),)
    assert request.on_interrupted == (SetState("z.n", 1),)


def test_launch_takes_values_of_the_parameters_types() -> None:
    found = world('launch l: m.c(three, 2, half, home, true, 256) when hot because "why";')
    condition = Compare("==", Reading("hot"), Const(True))
    assert found.launches == (Launch("l", "m.c", (3, 2.0, 0.5, "base", True, 256), condition, "why"),)
    assert isinstance(found.launches[0].args[1], float)


def test_variables_and_latches() -> None:
    found = model(
        """spec t; enum zone { base, field } const low = -2; const far = 1e3; const start = field;
        poster p: int in low .. 2 = -1 else 2; poster q: real = 2; poster z: zone = start else base;
        poster r: real in -1 .. far = far; poster one: int in 3 .. 3 = 3; poster half: real in 0.5 .. 0.5 = 0.5;
        module m { poster on: bool = false; state tool: {none, gripper} = none; request r(); request s(); }
        latch l: when on_ or p > 1 until m.*; poster on_: bool = true;
        latch k: when l until m.s;"""
    )
    kinds = {variable.name: (variable.kind, variable.type) for variable in found.variables}
    assert kinds == {
        "p": ("poster", Int(-2, 2)),
        "q": ("poster", Real()),
        "z": ("poster", Enum(("base", "field"))),
        "r": ("poster", Real(-1.0, 1000.0)),
        "one": ("poster", Int(3, 3)),
        "half": ("poster", Real(0.5, 0.5)),
        "m.on": ("poster", Bool()),
        "m.tool": ("state", Enum(("none", "gripper"))),
        "on_": ("poster", Bool()),
    }
    values = [(variable.initial, variable.fallback) for variable in found.variables]
    assert values == [
        *((-1, 2), (2.0, None), ("field", "base"), (1e3, None), (3, None), (0.5, None)),
        *((False, None), ("none", None), (True, None)),
    ]
    assert [type(variable.initial) for variable in found.variables][:4] == [int, float, str, float]
    assert [(latch.name, latch.resets) for latch in found.latches] == [("l", ("m.r", "m.s")), ("k", ("m.s",))]
    assert found.latches[1] == Latch("k", Compare("==", Reading("l"), Const(True)), ("m.s",))


def test_requests() -> None:
    found = model(
        """spec t; module m { request r(x: int in 0 .. 3, y: real) returns (z: bool) fails (lost, stuck) instances 3;
        request s(); } module empty { }"""
    )
    first, second = found.requests
    assert [(param.name, param.type) for param in first.params] == [("x", Int(0, 3)), ("y", Real())]
    assert [(param.name, param.type) for param in first.results] == [("z", Bool())]
    assert (first.statuses, first.instances) == (("lost", "stuck"), 3)
    assert (second.name, second.params, second.instances) == ("m.s", (), 1)


def test_locations_are_those_of_names_and_statements() -> None:
    found = model(
        "spec t;\n"
        "poster hot: bool = true;\n"
        "module m { state on: bool = true;\n"
        "  request r() { check hot;\n"
        "    fail when hot; uses p 1; consumes f 1; } request s(); }\n"
        "resource p: 3;\n"
        "resource f: 3 consumable;\n"
        "latch l: when hot until m.r;\n"
        "  mutex two: m.r, m.s;\n"
        "launch m.s() when hot;\n"
    )
    request = found.request["m.r"]
    places = [
        *(variable.location for variable in found.variables),
        *(request.location, request.guards[0].location, request.consumptions[0].location),
        *(rule.location for rule in found.rules),
        *(resource.location for resource in found.resources),
        *(found.latches[0].location, found.launches[0].location),
    ]
    assert [(place.line, place.column) for place in places] == [
        *((2, 8), (3, 18)),
        *((4, 11), (4, 17), (5, 30)),
        *((5, 5), (6, 1), (9, 3)),
        *((6, 10), (7, 10)),
        *((8, 7), (10, 1)),
    ]
    assert places[0] == Location("t.exo", 2, 8)
