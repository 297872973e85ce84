"""What decides before a dead rule is found by steps near runs, and nothing else is."""

from dataclasses import replace

import pytest

from exover.checks.causes.detail import detailed
from exover.checks.causes.shadowing import STATES, Shadows, WithoutRules
from exover.checks.questions.redundancy import VIOLATED as NEEDLESS
from exover.checks.questions.rule_use import VIOLATED
from exover.model.event import Ask, Report
from exover.model.property import NO_PROPERTIES
from exover.model.semantics import Reference
from exover.model.trace import end_of
from exover.pipeline import load_properties
from exover.source import Source
from tests.support.diagrams import check_by_diagrams
from tests.support.engines import model_of
from tests.support.small import compiled, small_spec_of

HEAD = """spec s; poster wind: int in 0 .. 60 = 0; poster t: real in 0 .. 9 = 0; resource fuel: 3 consumable;
module m { request a(x: int in 0 .. 3) { check calm: wind < 20; consumes fuel 1; interrupts self; } request b(); }
"""
DEAD = [
    ("forbid gale: wind > 10 and active(m.b) by kill m.b; forbid dead: wind > 30 and active(m.b) by kill m.b;", "gale"),
    ("context m.b { check low: wind < 20; check dead: wind < 30; }", "m.b.low"),
    ("mutex one: m.a, m.b; mutex dead: m.b, m.a;", "one"),
    ("forbid hot: t > 3 and active(m.b) by wait or kill m.b; forbid dead: t > 5 and active(m.b) by wait;", "hot"),
    ("context m.b { wait dead: until not running(m.b); }", "busy"),
    (
        "module n { request c() { check no: wind > 10 and wind < 5; consumes dead 1; } } resource dead: 3 consumable;",
        "n.c.no",
    ),
    (
        "latch up: when wind > 10 until m.a; latch high: when wind > 30 until m.a;"
        "forbid gale: up and active(m.b) by kill m.b; forbid dead: high and active(m.b) by kill m.b;",
        "gale",
    ),
    ("forbid dead: wind > 60 and active(m.b);", ""),
]


@pytest.mark.parametrize(("rules", "first"), DEAD)
def test_what_decides_before_a_dead_rule_is_named(rules: str, first: str) -> None:
    findings = check_by_diagrams(compiled(model_of(HEAD + rules))).findings
    (message,) = (each.message for each in findings if each.check == "rule-use" and each.verdict == "violated")
    causes = (
        f"where it would, `{first}` decides" if first else "`wind > 60` is false whatever happens: wind lies in 0 .. 60"
    )
    assert message == f"it never acts: {causes}; correct it or take it out"


POSE = """spec s; module g {
    state pose: {stand, go} = stand;
    request walk() {
        on launch set pose = go; on ok set pose = stand; on failed set pose = stand; on interrupted set pose = stand;
    }
    request turn() { check upright: pose == stand; CLAUSE }
}
mutex motion: g.walk, g.turn;"""


@pytest.mark.parametrize(
    ("clause", "rules", "name", "cause"),
    [
        (
            "wait still: until not active(g.walk);",
            "",
            "g.turn.still",
            "where it would, `g.turn.upright` decides, and without it `motion`",
        ),
        (
            "uses power 60;",
            "resource power: 100; context g.walk { uses power 60; }",
            "power",
            "`motion` leaves at most 60 of 100 taken at a time",
        ),
    ],
)
def test_rules_of_which_each_is_enough_to_decide_first_are_told_by_what_keeps_it_if_that_is_known(
    clause: str, rules: str, name: str, cause: str
) -> None:
    spec = POSE.replace("CLAUSE", clause) + rules
    findings = check_by_diagrams(compiled(model_of(spec))).findings
    said = {each.subject: each.message for each in findings if each.check == "rule-use" and each.verdict == "violated"}
    assert said == {name: f"it never acts: {cause}; correct it or take it out"}


SILENT = "no answer names it, but it decides without a word: it keeps what waits waiting; "
KEEPS = """spec s; poster h: bool = false; launch go: m.b() when not waiting(m.a); module m { request a() { CLAUSE }
request b() { interrupts m.a; } } forbid x1: active(m.a) and not h by wait;"""


@pytest.mark.parametrize(
    ("clause", "rules", "name", "told"),
    [
        ("", "forbid x2: active(m.a) and not active(m.b) by wait;", "x2", " decides; to take it out changes"),
        ("settle until running(m.b) and h;", "", "m.a.settle.1", ", `busy` decide; to take it out may change"),
        (
            "",
            "forbid x2: active(m.a) and not active(m.b) by wait; forbid x3: not active(m.b) and active(m.a) by wait;",
            "x2",
            " decides; correct it or take it",
        ),
    ],
)
def test_a_rule_that_keeps_what_waits_waiting_is_not_told_to_be_idle(
    clause: str, rules: str, name: str, told: str
) -> None:
    findings = check_by_diagrams(compiled(model_of(KEEPS.replace("CLAUSE", clause) + rules))).findings
    said = {each.subject: each.message for each in findings if each.check == "rule-use" and each.verdict == "violated"}
    assert said[name].startswith(SILENT)
    assert f"; where an answer would name it, `x1`{told}" in said[name]


REDUNDANT = [
    (
        "forbid gale: wind > 30 and active(m.b) by kill m.b; forbid storm: wind > 20 and active(m.b) by kill m.b;",
        {"gale": "`storm` decides"},
    ),
    ("mutex one: m.a, m.b by wait; limit two: at most 1 of m.a, m.b by wait;", {"one": "`two` decides"}),
    (
        "forbid no: wind > 9 and active(m.b) by kill m.b; forbid nor: wind > 8 and active(m.b) by wait or kill m.b;",
        {},
    ),
]


@pytest.mark.parametrize(("rules", "told"), REDUNDANT)
def test_what_decides_in_the_place_of_a_redundant_rule_is_named(rules: str, told: dict[str, str]) -> None:
    findings = check_by_diagrams(compiled(model_of(HEAD + rules))).findings
    dead = {each.subject for each in findings if each.check == "rule-use" and each.verdict == "violated"}
    messages = {e.subject: e.message for e in findings if e.check == "redundancy" and e.verdict == "violated"}
    assert messages.keys() - dead == told.keys()
    for name, message in messages.items():
        added = f"; in its place {told[name]}" if name in told else ""
        assert message == f"{NEEDLESS}{added}"


def test_what_decides_in_the_place_of_a_redundant_rule_is_told_also_where_its_request_waits() -> None:
    rules = "mutex one: m.a, m.b by wait; limit two: at most 1 of m.a, m.b by wait;"
    reference = Reference(model_of(HEAD + rules))
    waits = end_of(reference, (Ask("m.a", (0,)), Ask("m.b", ())))
    assert waits.places["m.b"]
    shadows = Shadows(reference, WithoutRules(reference.model), [waits], ())
    assert shadows.instead_of("one") == ("two",)


def test_what_decides_in_the_place_of_a_redundant_rule_is_looked_for_where_its_requests_are_active() -> None:
    rules = "mutex one: m.a, m.b by wait; limit two: at most 1 of m.a, m.b by wait; context m.a { after m.c; }"
    reference = Reference(model_of(HEAD.replace("request b();", "request b(); request c();") + rules))
    active = end_of(reference, (Ask("m.c", ()), Report("m.c", 0, "ok", ()), Ask("m.b", ())))
    states = [*[reference.start()] * (2 * STATES - 1), active]
    assert Shadows(reference, WithoutRules(reference.model), states, ()).instead_of("one") == ("two",)


def test_all_that_decide_in_the_place_of_a_redundant_rule_are_named_not_only_those_of_one_state() -> None:
    spec = """spec s; poster wind: int in 0 .. 60 = 0; module m { request a(x: int in 0 .. 999); request b(); }
    forbid one: active(m.a) and active(m.b) and wind < 30 by wait;
    forbid two: active(m.a) and active(m.b) and not past(m.b) by wait;
    forbid three: active(m.a) and active(m.b) and past(m.b) by wait;"""
    reference = Reference(model_of(spec))
    first = end_of(reference, (Ask("m.b", ()),))
    later = end_of(reference, (Ask("m.b", ()), Report("m.b", 0, "ok", ()), Ask("m.b", ())))
    shadows = Shadows(reference, WithoutRules(reference.model), [first, later], ())
    assert shadows.instead_of("one") == ("two", "three")


def test_nothing_is_looked_for_when_the_time_is_over() -> None:
    rules, _ = DEAD[0]
    model = model_of(HEAD + rules)
    findings = check_by_diagrams(compiled(model), {"rule-use"}).findings
    plain = [replace(each, message=VIOLATED if each.verdict == "violated" else each.message) for each in findings]
    violated = [each for each in plain if each.verdict == "violated"]
    advice = "correct it, or take it out if `idle-guard` finds it idle"
    for is_late, cause in ((lambda: False, ": where one would, `gale` decides"), (lambda: True, "")):
        told = [each.message for each in detailed(model, NO_PROPERTIES, plain, is_late) if each.verdict == "violated"]
        assert told == [f"no answer names it{cause}; {advice}"] * len(violated)


NEVER = [
    ("context m.a { check never: wind > 70; }", "`m.a.never`, `m.a.calm`, `fuel`; without `m.a.never` it"),
    (
        "context m.b { check up: wind > 30; check down: wind < 10; }",
        "`m.b.up`, `m.b.down`; without `m.b.up` or without `m.b.down` it",
    ),
    ("context m.b { wait up: until wind > 70; }", "`m.b.up`; without `m.b.up` it"),
    ("context m.b { check one: wind > 70; check two: wind > 70; }", "`m.b.one`"),
]


@pytest.mark.parametrize(("rules", "told"), NEVER)
def test_what_decides_where_a_request_is_asked_that_is_never_launched_is_named(rules: str, told: str) -> None:
    findings = check_by_diagrams(compiled(model_of(HEAD + rules))).findings
    (message,) = (each.message for each in findings if each.check == "reachability" and each.verdict == "violated")
    there = " would be launched there" if "without" in told else ""
    first, _, rest = message.partition("; it is kept from a launch by ")
    never = "; `wind > 70` is false whatever happens: wind lies in 0 .. 60" if "70" in rules else ""
    assert first == f"no run launches the request{never}"
    assert rest == f"{told}{there}"


@pytest.mark.parametrize(
    ("spec", "told"),
    [
        (
            KEEPS.replace("CLAUSE", "") + "forbid x2: active(m.a) and not active(m.b) by wait;",
            "`m.b.interrupts.m.a`, `x1`, `x2`; without `m.b.interrupts.m.a` or without `x2` it would be launched there",
        ),
        (
            "spec s; module m { request a(x: bool) { wait until last(m.a) == ok; check not x; } request b(); }",
            "`m.a.wait.1`, `m.a.check.1`; without `m.a.wait.1` it would be launched there",
        ),
    ],
)
def test_what_keeps_a_waiting_request_from_a_launch_is_told_of_what_waits(spec: str, told: str) -> None:
    findings = check_by_diagrams(compiled(model_of(spec))).findings
    (message,) = (e.message for e in findings if (e.check, e.subject, e.verdict) == ("reachability", "m.a", "violated"))
    assert message == f"no run launches the request; it is kept from a launch by {told}"


@pytest.mark.parametrize("seed", range(40))
def test_any_rule_of_any_spec_can_be_looked_into(seed: int) -> None:
    model = model_of(small_spec_of(seed))
    names = [rule.name for rule in model.rules] + [g.name for request in model.requests for g in request.guards]
    names += [resource.name for resource in model.resources] + [launch.name for launch in model.launches]
    reference = Reference(model)
    looking = Shadows(reference, WithoutRules(model), [reference.start()], ())
    for name in dict.fromkeys(names):
        found = looking.of(name)
        assert name not in found.rules and found.forbids is None
        assert name not in looking.instead_of(name)
    for request in model.requests:
        found = looking.before_launch(request.name)
        assert "busy" not in found.rules and set(found.alone) <= set(found.rules) and found.forbids is None


@pytest.mark.parametrize(
    ("assumed", "check", "message"),
    [
        (
            "never (asked(m.b) and hot)",
            "rule-use",
            "it never acts, since the assumption at s.prop:1:8 forbids the steps in which it would",
        ),
        ("always not asked(m.b)", "reachability", "only in steps that the assumption at s.prop:1:8 forbids"),
        ("never (asked(m.b) and not hot)", "reachability", "without `m.b.cool` it would be launched there"),
    ],
)
def test_an_assumption_that_forbids_what_would_happen_is_named(assumed: str, check: str, message: str) -> None:
    spec = "spec s; poster hot: bool = false; module m { request b() { check cool: not hot; } }"
    (told,) = messages(spec, assumed, check, "m.b.cool" if check == "rule-use" else "m.b")
    assert told.endswith(message)


WAITS = "spec s; poster h: bool = false; module m { request a() { wait until h; } request b(); } forbid x: active(m.a);"
PLAIN = "spec s; poster h: bool = false; module m { request a(); request b() { check h; } }"


@pytest.mark.parametrize(
    ("spec", "assumed", "subject", "message"),
    [
        (WAITS, "never asked(m.a)", "m.a.wait.1", ": without the assumptions, `x` would decide in its place; "),
        (WAITS, "never asked(m.a)", "x", ", since the assumption at s.prop:1:8 forbids the steps in which it would"),
        (PLAIN, "never asked(m.b); assume always active(m.a) or asked(m.a)", "m.b.check.1", "1:8 forbids the steps"),
        (
            PLAIN,
            "never rejected(m.b); assume never asked(m.b)",
            "m.b.check.1",
            "the assumptions at s.prop:1:8 and at s.prop:1:36 forbid the steps in which it would",
        ),
        (
            PLAIN,
            "never asked(m.b) and not active(m.a); assume never asked(m.b) and active(m.a)",
            "m.b.check.1",
            ", since the assumptions forbid the steps in which it would",
        ),
        (
            PLAIN,
            "never rejected(m.b) and asked(m.b) and not active(m.a); assume never asked(m.b); "
            "assume never asked(m.b) and active(m.a)",
            "m.b.check.1",
            ", since the assumptions forbid the steps in which it would",
        ),
    ],
)
def test_an_assumption_is_named_only_if_the_rule_acts_without_it(
    spec: str, assumed: str, subject: str, message: str
) -> None:
    (told,) = messages(spec, assumed, "rule-use", subject)
    assert message in told


@pytest.mark.parametrize(
    ("assumed", "forbids"),
    [
        ("always active(m.a) or asked(m.a); assume never asked(m.b) and active(m.a)", "assumptions forbid"),
        ("never active(m.b); assume always active(m.a) or asked(m.a)", "assumption at s.prop:1:8 forbids"),
        ("never asked(m.b); assume never launched(m.b)", "assumptions at s.prop:1:8 and at s.prop:1:33 forbid"),
    ],
)
def test_an_assumption_is_named_only_if_it_forbids_every_launch(assumed: str, forbids: str) -> None:
    (told,) = messages("spec s; module m { request a(); request b(); }", assumed, "reachability", "m.b")
    assert told.endswith(f"; it would be launched only in steps that the {forbids}")


def messages(spec: str, assumed: str, check: str, subject: str) -> list[str]:
    """Return what is said of a subject that is violated."""
    model = model_of(spec)
    properties = load_properties(Source("s.prop", f"for s; assume {assumed};"), model).properties
    assert properties is not None
    findings = check_by_diagrams(compiled(model), properties=properties).findings
    return [e.message for e in findings if (e.check, e.subject, e.verdict) == (check, subject, "violated")]
