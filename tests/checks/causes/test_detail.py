"""What messages of findings say of their causes beside what the check says of all subjects."""

from dataclasses import replace
from functools import cache

import pytest

from exover.checks.causes.blocking import Obstacles
from exover.checks.causes.shadowing import WithoutRules
from exover.checks.finding import Finding
from exover.checks.questions.property import VIOLATED
from exover.checks.questions.question import Question
from exover.checks.run import check_all
from exover.checks.schedule.engines import DIAGRAMS, Engines
from exover.checks.schedule.opinions import contradicted
from exover.checks.schedule.plan import CheckPlan
from exover.loop.claim import CONTRADICTION
from exover.model.event import Observe
from exover.model.model import NOWHERE
from exover.model.property import NO_PROPERTIES, Properties
from exover.model.semantics import Reference
from exover.model.trace import Trace
from exover.pipeline import load_properties
from exover.source import Source
from tests.support.engines import model_of
from tests.support.small import compiled

SPEC = """spec s; poster wind: int in 0 .. 60 = 0; resource power: 9 by wait; latch hot: when wind > 50 until m.cool;
module m {
    request cool() { uses power 3; }
    request heat() { uses power 3; }
    request lift(kg: int in 3 .. 9) { uses power 9; check wind < 99 because "no gale"; }
}
module a { request left(); request give() { wait partner: until running(b.take) because "the other hand"; } }
module b { request take() { wait until running(a.give); } }
module c { request never_so(k: int in 2 .. 4) { check closed: not past(a.left); check small: wind + k < 70; } }
"""
PROPERTIES = """for s;
property p "no lift in a storm": never active(m.lift) and wind > 40;
property q: possible wind > 60;
property r: always possible wind == 3;
property l: always (active(m.cool) leads to not active(m.cool));
"""
AIG = Engines(("aig",))


@cache
def found(
    spec: str, properties: str = "", engines: Engines = DIAGRAMS, asked: str | None = None
) -> dict[tuple[str, str], Finding]:
    """Return the findings by check and subject; of one check, if that is `asked`."""
    model, read = model_of(spec), NO_PROPERTIES
    if properties:
        loaded = load_properties(Source("s.prop", properties), model)
        assert isinstance(loaded.properties, Properties), loaded.diagnostics
        read = loaded.properties
    checks = None if asked is None else {asked}
    findings = check_all(compiled(model), lambda phase: None, CheckPlan(checks, read, engines)).findings
    return {(each.check, each.subject): each for each in findings}


@pytest.mark.parametrize("engines", [DIAGRAMS, AIG], ids=["bdd", "aig"])
def test_a_property_is_told_with_its_text_and_what_it_reads_at_the_end(engines: Engines) -> None:
    findings = found(SPEC, PROPERTIES, engines, "property")
    said = {subject: each.message for (_, subject), each in findings.items()}
    start, _, wind = said["p"].rpartition("wind == ")
    assert start == ('"no lift in a storm": a run comes to a moment that it forbids; there active(m.lift), ')
    assert int(wind) > 40
    assert said["q"].startswith("no run comes to a moment in which it is true; `wind > 60` is false whatever happens: ")
    broken, owed = said["l"].split("; ")
    assert broken == ("a run comes to where `active(m.cool)` is true, and from there on `not active(m.cool)` never is")
    assert int(owed.removeprefix("the premise is true after step ")) >= 1


@pytest.mark.parametrize("engines", [DIAGRAMS, AIG], ids=["bdd", "aig"])
def test_of_a_lasso_it_is_told_by_what_its_requests_wait_and_what_asks_again(engines: Engines) -> None:
    spec = (
        "spec s; poster low: bool = true; module m { request a(); request halt(); } mutex still: m.a, m.halt by wait;"
    )
    spec += "launch brake: m.halt() when low;"
    said = found(spec, "for s; property l: always (waiting(m.a) leads to launched(m.a));", engines, "property")[
        "property", "l"
    ].message
    owed, *held = said.split("; ")[1:]
    assert owed.startswith("the premise is true after step ")
    assert held == ["`m.a` waits by `still`, there active(m.halt)", "launch rule `brake` requires `m.halt` there"]


@pytest.mark.parametrize("engines", [DIAGRAMS, AIG], ids=["bdd", "aig"])
def test_an_abort_that_gives_up_what_must_come_is_told(engines: Engines) -> None:
    spec = "spec s; module m { request moor(); request take() { interrupts m.moor; } request rest(); }"
    findings = found(
        spec,
        """for s; assume fair reports; property taken: always (waiting(m.take) leads to active(m.take));
property rests: always (running(m.rest) leads to last(m.rest) == ok);""",
        engines,
        "property",
    )
    said = findings["property", "taken"].message.split("; ")
    since = int(said[1].removeprefix("the premise is true after step "))
    assert said[2].startswith("the wait of `m.take` is given up by the abort in step ")
    assert int(said[2].rpartition(" ")[2]) > since
    assert "abort" not in findings["property", "rests"].message


FORMS = [
    ("past(m.cool) precedes active(m.lift)", "a run comes to `active(m.lift)` before `past(m.cool)`; there "),
    (
        "not launched(m.lift with kg > 4) until past(m.cool)",
        "a run gives up `not launched(m.lift with kg > 4)` before ",
    ),
    ("wind <= 60 until asked(m.cool) and past(m.cool)", "a run never comes to `asked(m.cool) and past(m.cool)`"),
    (
        "asked(m.cool) or asked(m.heat) or asked(a.left) or asked(a.give) precedes active(m.lift) and wind > 9",
        "a run comes to `active(m.lift) and wind > 9` before the first; there ",
    ),
    ("ltl G (asked(m.lift) -> !rejected(m.lift))", "the formula is false of a run; what its `G` says is false first "),
    ("ltl G (asked(m.lift) -> X F asked(m.lift))", "the formula is false of a run; what its `G` says is false first "),
    (
        "never running(m.lift with kg > 4)",
        "a run comes to a moment that it forbids; there running(m.lift with kg == 5)",
    ),
]


@pytest.mark.parametrize(("said", "told"), FORMS)
def test_a_property_is_told_in_the_words_of_its_form(said: str, told: str) -> None:
    message = found(SPEC, f"for s; property p: {said};", asked="property")["property", "p"].message
    assert message.startswith(told)
    if "false first" in told:
        assert message.removeprefix(told).startswith("after step ")


def test_of_what_no_run_launches_it_is_told_that_a_guard_waits_for_it() -> None:
    spec = "spec s; poster wind: int in 0 .. 60 = 0; module m { request a() { check wind > 60; }"
    spec += "request b() { wait gone: until not active(m.a); } request c() { check then: past(m.a) and wind > 3; } }"
    findings = found(spec)
    see = "no run launches `m.a`: see reachability"
    assert findings["rule-use", "m.b.gone"].message == f"it never acts: {see}; correct it or take it out"
    message = findings["reachability", "m.c"].message
    assert message.endswith(f"by `m.c.then`; without `m.c.then` it would be launched there; {see}")


def test_of_a_lasso_it_is_told_by_what_its_request_waits_in_turn() -> None:
    spec = "spec s; module m { request a(); request b(); request c(); }"
    spec += "mutex first: m.a, m.b by wait; mutex second: m.a, m.c by wait;"
    _, by, earlier = found(spec, asked="starvation")["starvation", "m.a"].message.split("; ")
    first, second = "by `first`, there active(m.b)", "by `second`, there active(m.c)"
    assert (by, earlier) in (
        (f"`m.a` waits {first}", f"earlier in the loop {second}"),
        (f"`m.a` waits {second}", f"earlier in the loop {first}"),
    )


def test_what_waits_is_told_with_its_rule_and_who_holds_it() -> None:
    said = {key: each.message.partition("; ")[2] for key, each in found(SPEC).items()}
    by = "`a.give` waits by `a.give.partner` (the other hand), there not active(b.take)"
    other = "`b.take` waits by `b.take.wait.1`, there not active(a.give)"
    asked = (
        by.replace("give` waits", "give()` is kept waiting"),
        other.replace("take` waits", "take()` is kept waiting"),
    )
    assert said["deadlock", "a.give"] in (f"{by}; {other}", f"{by}; {asked[1]}")
    assert said["deadlock", "b.take"] in (f"{other}; {by}", f"{other}; {asked[0]}")
    waits, _, there = said["starvation", "m.lift"].partition(", there ")
    assert waits == "`m.lift` waits by `power`"
    assert there in ("active(m.cool)", "active(m.heat)", "active(m.cool), active(m.heat)")


def test_what_can_never_be_launched_again_is_told_with_what_refuses_it() -> None:
    said = {key: each.message.partition("; ")[2] for key, each in found(SPEC).items()}
    assert said["lockout", "c.never_so"] == "`c.never_so(k = 2)` is refused by `c.never_so.closed`, there past(a.left)"


@pytest.mark.parametrize("engines", [DIAGRAMS, AIG], ids=["bdd", "aig"])
def test_what_would_end_a_wait_by_being_active_is_not_told_to_be_in_the_way(engines: Engines) -> None:
    spec = """spec s; poster dust: int in 0 .. 80 = 50;
module cut { request go(); } module vac { request suck(level: int in 1 .. 3) instances 2; }
forbid cloud: active(cut.go) and dust > 40 and not active(vac.suck with level >= 2) by wait;
launch extract: vac.suck(1) when dust > 30;
"""
    waits = found(spec, engines=engines, asked="starvation")["starvation", "cut.go"].message.partition("; ")[2]
    assert waits in (
        "`cut.go` waits by `cloud`, there running(vac.suck with level == 1), dust == 50",
        "`cut.go` waits by `cloud`, there not active(vac.suck), dust == 50",
    )


@pytest.mark.parametrize("engines", [DIAGRAMS, AIG], ids=["bdd", "aig"])
def test_what_refuses_a_required_launch_is_told(engines: Engines) -> None:
    spec = """spec s; poster low: int in 0 .. 9 = 9;
module m { request go(); request dock(p: int in 1 .. 3) { check far: p < 3; } request stow(); }
mutex way: m.go, m.stow because "one at a time";
module n { request lift(kg: int in 1 .. 3) { wait until low < 3; } }
launch home: m.dock(3) when low < 2;
launch still: m.stow() when low == 7;
launch first: m.dock(1) when low in 4 .. 6;
launch shut: n.lift(2) when low == 8;
"""
    said = {name: each.message for (_, name), each in found(spec, engines=engines, asked="obligation").items()}
    causes = {name: message.partition("; ")[2] for name, message in said.items()}
    assert causes == {
        "home": "`m.dock(p = 3)` is refused by `m.dock.far`, there p == 3",
        "still": "`m.stow()` is refused by `way` (one at a time), there active(m.go)",
        "shut": "`n.lift(kg = 2)` is refused by `busy`, there waiting(n.lift)",
        "first": "`m.dock(p = 1)` is refused by `busy`, there active(m.dock)",
    }


@pytest.mark.parametrize("engines", [DIAGRAMS, AIG], ids=["bdd", "aig"])
def test_a_launch_is_refused_by_what_the_last_step_refused_it_for_whatever_it_launched_then(engines: Engines) -> None:
    spec = """spec s; poster e: bool = false; module m { request dock(); request stop(); }
mutex first: m.stop over m.dock;
forbid halted: e and active(m.dock) by kill m.dock because "stay out";
launch go: m.dock() when e;
launch brake: m.stop() when e;
"""
    findings = found(spec, "for s; property docks: always (e leads to active(m.dock));", engines=engines)
    assert findings["obligation", "go"].message.endswith(
        "; `m.dock()` is refused by `halted` (stay out), there e == true"
    )
    assert findings["property", "docks"].message.endswith("; `m.dock()` is refused by `first`, there active(m.stop)")


@pytest.mark.parametrize(
    ("form", "told"),
    [
        ("never (running(m.go) and hot)", "there running(m.go), hot == true"),
        ("never (active(m.go) and not running(m.go) and hot)", "there stopping(m.go), hot == true"),
        ("never (active(m.go) and hot)", "there active(m.go), hot == true"),
        ("never (past(m.go with v == 2) and hot)", "there past(m.go with v == 2), hot == true"),
        ("past(m.go with v == 2) precedes active(m.halt)", "there not past(m.go), active(m.halt)"),
        ("never waiting(m.halt with n == 3)", "there waiting(m.halt with n == 3)"),
    ],
)
def test_what_a_property_reads_is_told_as_it_reads_it(form: str, told: str) -> None:
    spec = """spec s; poster hot: bool = false;
module m { request go(v: int in 0 .. 3); request halt(n: int in 1 .. 4) { interrupts m.go; } }
"""
    message = found(spec, f"for s; property p: {form};", asked="property")["property", "p"].message
    assert message.partition("; ")[2] == told


def test_what_stays_in_the_way_is_found_beside_many_requests() -> None:
    others = " ".join(f"request x{number}(n: int in 0 .. 9);" for number in range(12))
    spec = f"""spec s; resource wifi: 10 by wait; module z {{ {others} }}
module m {{
    request b() {{ uses wifi 6; }}
    request e() {{ check known: last(m.b) == failed; wait net: until used(wifi) > 8; }}
}}
"""
    told = "once all else is mended, `m.e()` is kept waiting by `m.e.net`, there used(wifi) == 0"
    assert found(spec, asked="lockout")["lockout", "m.e"].message.endswith(f"; {told}")


def test_a_launch_that_a_shortage_refuses_is_told_with_the_text_of_the_clause() -> None:
    spec = """spec s; poster low: bool = false; resource pills: 5 consumable = 0;
module m { request a() { consumes pills 1 because "none left"; } }
launch go: m.a() when low;
"""
    told = found(spec, asked="obligation")["obligation", "go"].message
    assert told.endswith("; `m.a()` is refused by `pills` (none left), there level(pills) == 0")


def test_a_request_that_wants_more_than_there_can_be_is_told_so() -> None:
    spec = """spec s; resource net: 10 by wait; resource pills: 5 consumable;
module m { request a(n: int in 1 .. 2) { uses net 7; uses net 4 when n > 0; } request b() { consumes pills 6; } }
"""
    findings = found(spec)
    assert findings["deadlock", "m.a"].message.endswith("; `m.a` waits by `net` (it wants 11 of 10)")
    assert findings["lockout", "m.b"].message.endswith(
        "; `m.b()` is refused by `pills` (it wants 6 of 5), there level(pills) == 5"
    )
    assert (
        "; it wants 6 of `pills`, of which there are 5; it is kept from a launch by `pills`"
        in findings["reachability", "m.b"].message
    )
    assert "it wants" not in findings["reachability", "m.a"].message, "that depends on a condition"


@pytest.mark.parametrize(
    ("assumed", "told"),
    [
        ("never asked(a.left) and past(m.cool)", "the assumption at s.prop:1:8 forbids the step"),
        ("never asked(a.left) and not killed(m.lift with kg > 3)", "the assumptions leave no such step"),
    ],
)
def test_what_only_assumptions_keep_from_a_launch_is_told_so(assumed: str, told: str) -> None:
    properties = f"for s; assume {assumed}; property p: always possible active(a.left);"
    findings = found(SPEC, properties)
    would = f"; `a.left()` would be launched, but {told}"
    assert findings["lockout", "a.left"].message.endswith(would)
    assert findings["property", "p"].message.endswith(
        would if "forbids" in told else "; no run launches `a.left`: see reachability"
    )


def test_a_rule_may_stand_in_the_way_of_what_an_assumption_forbids_all_the_same() -> None:
    spec = "spec s; poster ready: bool = true; module m { request reset() { check is_ready: ready; } }"
    findings = found(spec, "for s; assume never asked(m.reset) and active(m.reset);")
    forbids = "the assumption at s.prop:1:8 forbids"
    assert findings["reachability", "m.reset"].message.endswith(f"; it would be launched only in steps that {forbids}")
    would = f"; `m.reset()` would be launched, but {forbids} the step"
    assert findings["lockout", "m.reset"].message.endswith(would)


def test_an_assumption_that_forbids_what_would_mend_it_is_told() -> None:
    spec = """spec s; poster free: bool = true; latch stop: when not free until m.reset;
    module m { request reset() { check free; } request go() { check clear: not stop; } }"""
    said = found(spec, "for s; assume never asked(m.reset) and active(m.reset);", asked="lockout")[
        "lockout", "m.go"
    ].message
    assert said.endswith(
        "; `m.go()` is refused by `m.go.clear`, there stop == true; "
        "in a later state `m.reset()` would be launched, but the assumption at s.prop:1:8 forbids the step"
    )


def test_what_a_state_after_the_run_has_is_not_told_as_if_it_were_its_end() -> None:
    spec = """spec s;
    module m {
        state up: bool = false; state at: int in 0 .. 3 = 0;
        request step() { on launch set up = true; on launch set at = 3; }
        request sing() { check lit: up; check low: at == 2; }
    }"""
    said = found(spec, asked="lockout")["lockout", "m.sing"].message
    told = "once all else is mended, `m.sing()` is refused by `m.sing.low`, in a later state m.at == 3"
    assert said.endswith(f"; {told}")


LATER = """spec s; module m { request a(); request b(); }
forbid x: active(m.a) and not active(m.b) by wait or kill m.a;"""
CHOSEN = "spec s; module m { request a(n: int in 0 .. 9) { check some: n > 2; } request b(); }"
NEVER_ASKED = "the assumption at s.prop:1:8 forbids the step"


@pytest.mark.parametrize(
    ("spec", "assumed", "told"),
    [
        (LATER, "never asked(m.a)", f"; in a later state `m.a()` would be launched, but {NEVER_ASKED}"),
        (CHOSEN, "never asked(m.a)", f"; `m.a(n = 6)` would be launched, but {NEVER_ASKED}"),
        (
            CHOSEN,
            "never asked(m.a) and not killed(m.a with n > 3)",
            "; `m.a(n = 6)` would be launched, but the assumptions leave no such step",
        ),
    ],
)
def test_a_launch_that_is_forbidden_is_one_at_the_end_of_the_run_unless_it_is_told(
    spec: str, assumed: str, told: str
) -> None:
    message = found(spec, f"for s; assume {assumed};", asked="lockout")["lockout", "m.a"].message
    assert message.endswith(told)


def test_what_mends_it_is_told_to_be_refused_later_if_it_is_not_at_the_end_of_the_run() -> None:
    spec = """spec s; poster k: bool = true;
    module m { request a() { wait until last(m.a) == failed; check not k; } request b() { after m.a; } }"""
    said = found(spec, asked="lockout")["lockout", "m.b"].message
    first = "`m.b()` is refused by `m.b.after.m.a`, there not past(m.a)"
    last = "once all else is mended, `m.a()` is kept waiting by `m.a.wait.1`, there last(m.a) == none"
    assert said.endswith(f"; {first}; {last}")


STUCK = """spec s; poster dark: bool = true; latch alarm: when dark until m.reset;
module arm {
    state pose: { folded, out } = folded;
    request unfold() { check folded: pose == folded because "it is out"; on launch set pose = out; }
    request stow() { wait held: until plug.mated because "it needs hold"; on ok set pose = folded; }
}
module plug {
    state mated: bool = false;
    request mate() { check not active(arm.unfold); check clear: arm.pose == folded; on ok set mated = true; }
}
module m {
    request reset() { check unplugged: plug.mated; }
    request send();
    request sing() { wait silence: until not active(m.send); }
}
launch distress: m.send() when alarm;
"""


@pytest.mark.parametrize("engines", [DIAGRAMS, AIG], ids=["bdd", "aig"])
def test_what_would_mend_it_and_cannot_be_is_told(engines: Engines) -> None:
    findings = found(STUCK, "for s; property back: always possible launched(arm.unfold);", engines)
    said = {
        key: each.message.partition("; ")[2].replace("` waits by", "()` is kept waiting by")
        for key, each in findings.items()
    }
    mate = "`plug.mate()` is refused by `plug.mate.clear`, there arm.pose == out"
    stow = "`arm.stow()` is kept waiting by `arm.stow.held` (it needs hold), there plug.mated == false"
    assert said["lockout", "plug.mate"].removeprefix("once all else is mended, ") == f"{mate}; {stow}"
    unfold = "`arm.unfold()` is refused by `arm.unfold.folded` (it is out), there arm.pose == out"
    mended = "once all else is mended, "
    assert said["lockout", "arm.unfold"] == f"{mended}{unfold}; {stow}; {mended}{mate}"
    assert said["property", "back"] == f"{mended}{unfold}; {stow}; {mended}{mate}"
    sing = said["lockout", "m.sing"].split("; ")
    assert sing[0] == "`m.sing()` is kept waiting by `m.sing.silence`, there active(m.send)"
    assert sing[1] == "launch rule `distress` requires `m.send` there"
    assert sing[2] == "`m.reset()` is refused by `m.reset.unplugged`, there plug.mated == false"


@pytest.mark.parametrize(("length", "more"), [(4, False), (5, True)])
def test_of_a_long_chain_it_is_told_that_it_goes_on(length: int, more: bool) -> None:
    """Each request is to come after the next, and the last after the first."""
    chain = " ".join(f"request r{n}() {{ after m.r{(n + 1) % length}; }}" for n in range(length))
    message = found(f"spec s; module m {{ {chain} }}", asked="lockout")["lockout", "m.r0"].message
    assert message.count(" is refused by ") == 4
    assert message.endswith("; and so on") == more


OTHERS = """module other {
    request a() { check x: p > 3; } request b() { fail y: when lit; } request c(x: int in 0 .. 9) { fail z: when dark; }
    request d(); request e(); request f(); request g(); request h(); request i();
}"""


def test_a_guard_that_an_observation_mends_is_not_told_as_the_cause_of_a_lockout() -> None:
    spec = f"""spec s; poster key: bool = false; poster people: int in 0 .. 20 = 0; poster dose: int in 0 .. 10000 = 1;
poster lit: bool = true; poster dark: bool = true; poster p: int in 0 .. 9 = 0;
module drawer {{
    state pos: {{outside, middle, inside}} = outside;
    request push() {{
        check was: pos == outside; check c: door.pos == shut; on launch set pos = middle; on ok set pos = inside;
    }}
}}
{OTHERS}
module door {{
    state pos: {{shut, moving, open}} = shut;
    request unlock() {{
        check k: key; check nobody: people == 0; check low: dose < 50; check d: drawer.pos == outside;
        on launch set pos = moving; on ok set pos = open; fail rad: when dose > 50;
    }}
    request lock() {{ interrupts door.unlock; on ok set pos = shut; }}
}}"""
    said = found(spec, asked="lockout")["lockout", "door.unlock"].message
    told = "once all else is mended, `door.unlock()` is refused by `door.unlock.d`, there drawer.pos == middle"
    assert said.endswith(f"; {told}")


def test_a_value_that_the_launch_would_set_is_told_with_what_it_sets() -> None:
    spec = """spec s; resource oil: 9 consumable by wait;
module m {
    state up: bool = false;
    request lift() { on launch set up = true; } request lower() { on ok set up = false; } request drive() instances 2;
    request open() { consumes oil 4; }
}
forbid moving: m.up and active(m.drive) by wait;
forbid low: level(oil) < 8 and active(m.open) by wait;"""
    findings = found(spec, asked="starvation")
    said = findings["starvation", "m.lift"].message
    told = said.partition("; ")[2]
    assert (
        told == "`m.lift` waits by `moving`, there active(m.drive), m.up == false (once it is launched: m.up == true)"
    )
    said = findings["starvation", "m.open"].message.partition("; `m.open` waits by `low`, there level(oil) == ")[2]
    level, _, then = said.partition(" (once it is launched: level(oil) == ")
    assert int(then.removesuffix(")")) == int(level) - 4


def test_of_several_obstacles_one_is_told_that_no_run_mends() -> None:
    spec = """spec s; poster key: bool = true;
module m {
    state x: bool = false; state y: bool = false;
    request spoil() { on launch set x = true; on launch set y = true; }
    request go() { check k: not key; check one: not x; check two: not y; }
}"""
    said = found(spec, asked="lockout")["lockout", "m.go"].message
    assert said.endswith("; among others, `m.go()` is refused by `m.go.one`, there m.x == true")


def test_a_rule_that_can_be_mended_is_told_only_as_the_one_that_decides_first() -> None:
    spec = """spec s; poster p: int in 0 .. 2 = 0;
module m { request go() { check a: p == 1; check b: p == 2; check c: p == 0; } }"""
    said = found(spec, asked="lockout")["lockout", "m.go"].message
    assert said.endswith("; `m.go()` is refused first by `m.go.a`, there p == 0")


@pytest.mark.parametrize("engines", [DIAGRAMS, AIG], ids=["bdd", "aig"])
def test_of_a_lasso_it_is_told_by_what_its_request_waits_there_not_what_would_last(engines: Engines) -> None:
    spec = "spec s; poster p: int in 0 .. 2 = 0; module m { state at: {a, b} = a;"
    spec += "request go() { wait low: until p == 1; wait mid: until p == 2; check there: at == a; } }"
    said = found(spec, engines=engines, asked="starvation")["starvation", "m.go"].message
    by, read = said.rpartition("; `m.go` waits by ")[2].split(", there p == ")
    assert by == ("`m.go.mid`" if read == "1" else "`m.go.low`")


def test_an_idle_request_that_a_rule_names_would_mend_nothing() -> None:
    spec = """spec s; module m {
        state used: bool = false;
        request a() { on launch set used = true; } request b() { wait until not active(m.c); }
        request c(); request d() { check not m.used; }
    }
    limit one: at most 1 of m.a, m.b, m.d by wait; launch again: m.a() when m.used;"""
    said = found(spec, asked="lockout")["lockout", "m.b"].message
    assert said.endswith(
        "`m.b()` is kept waiting by `one`, there active(m.a); launch rule `again` requires `m.a` there"
    )


def test_only_steps_that_are_assumed_mend_anything() -> None:
    spec = """spec s; poster near: bool = false; poster lit: bool = true;
    module m {
        request a() { check close: near; check seen: lit; check past(m.b); }
        request b() { check not past(m.a) and lit; }
    }"""
    said = found(spec, "for s; assume always not near;", asked="lockout")["lockout", "m.a"].message
    assert said.endswith("; `m.a()` is refused by `m.a.close`, there near == false")
    assumed = "assume never launched(m.b) and not active(m.a); assume always lit or near or active(m.b) or past(m.b);"
    said = found(spec, f"for s; {assumed}", asked="lockout")["lockout", "m.a"].message
    forbidden = "`m.b()` would be launched, but the assumption at s.prop:1:8 forbids the step"
    last = f"once all else is mended, `m.a()` is refused by `m.a.check.3`, there not past(m.b); {forbidden}"
    assert said.endswith(f"; {last}")


def test_a_property_that_no_run_shows_points_at_a_request_that_is_never_launched() -> None:
    spec = "spec s; module m { state at: { here, there } = here; request a() { check at == there; } request b(); }"
    findings = found(
        spec, "for s; property p: possible running(m.a); property q: possible launched(m.a) and past(m.b);"
    )
    assert findings["property", "p"].message.endswith("; no run launches `m.a`: see reachability")
    assert findings["property", "q"].message.endswith("; no run launches `m.a`: see reachability")
    message = findings["reachability", "m.a"].message
    assert message.startswith("no run launches the request; `m.at == there` is false whatever happens: m.at is here; ")


def test_a_premise_that_is_never_true_says_what_keeps_it_from_being_true() -> None:
    spec = (
        "spec s; poster wind: int in 0 .. 60 = 0 else 60; mutex x: m.b, m.c by reject;"
        "module m { state at: int in 0 .. 1 = 0; request a() { check at == 1; } request b(); request c(); }"
    )
    said = found(
        spec,
        "for s; property storm: always (wind > 70 implies not active(m.b));"
        "property unlaunched: always (active(m.a) leads to wind < 10);"
        "property excluded: always (active(m.b) and active(m.c) implies wind < 10);",
    )
    never = "its premise is never true: the property says nothing"
    assert said["vacuity", "storm"].message == f"{never}; `wind > 70` is false whatever happens: wind lies in 0 .. 60"
    assert said["vacuity", "unlaunched"].message == f"{never}; no run launches `m.a`: see reachability"
    assert said["vacuity", "excluded"].message == f"{never}; `x` forbids it"


FORBIDDEN = [
    ("active(m.a) and active(m.b)", "`pair` forbids it"),
    ("running(m.b) and stopping(m.a)", "`pair` forbids it"),
    ("launched(m.a) and active(m.b with n == 2)", "`pair` forbids it"),
    ("active(m.c) and active(m.d)", "`power` forbids it"),
    ("active(m.b) and active(m.d) and active(m.e)", "`two` forbids it"),
    ("running(m.e) and wind > 9 and lit", "`gale` forbids it"),
    ("active(m.b with n == 1) and active(m.b with n == 2)", "`m.b` has one slot"),
    ("active(m.g with n == 1) and active(m.g with n == 2) and running(m.g with n == 3)", "`m.g` has 2 slots"),
    ("active(m.k with n == 1) and active(m.k with n == 2 and k == 1) and active(m.a)", "`few` forbids it"),
    ("active(m.h with n == 1) and active(m.h with n == 3)", "`heat` forbids it"),
    ("active(m.h with n == 1) and active(m.h with k == 3) and lit and not lit", None),
    ("active(m.b with n == 1) and waiting(m.b with n == 2) and lit and not lit", "nothing makes `m.b` wait"),
    ("waiting(m.w) and lit and not lit", None),
    ("m.at == there", "no run launches `m.f`: see reachability"),
    ("not m.at == here and active(m.a)", "no run launches `m.f`: see reachability"),
]


@pytest.mark.parametrize(("wanted", "told"), FORBIDDEN)
def test_what_is_never_possible_is_told_with_the_rules_that_forbid_it(wanted: str, told: str | None) -> None:
    spec = """spec s; poster wind: int in 0 .. 60 = 0; poster lit: bool = false; resource power: 3;
    module m {
        state at: { here, there } = here; request a(); request b(n: int in 0 .. 9);
        request c() { uses power 2; } request d() { uses power 2; } request e();
        request f() { check at == there; on ok set at = there; on failed set at = here; }
        request g(n: int in 0 .. 9) instances 2;
        request h(n: int in 0 .. 9, k: int in 0 .. 9) instances 3 { uses heat 2; }
        request k(n: int in 0 .. 9, k: int in 0 .. 9) instances 3; request w() { wait until lit; }
    }
    resource heat: 3; limit few: at most 2 of m.a, m.k;
    mutex pair: m.a, m.b; limit two: at most 2 of m.b, m.d, m.e;
    forbid gale: lit and wind > 9 and active(m.e) by kill m.e;"""
    message = found(spec, f"for s; property p: possible ({wanted});")["property", "p"].message
    assert message == "no run comes to a moment in which it is true" + (f"; {told}" if told else "")


def test_what_rules_leave_of_a_resource_that_is_never_exceeded_is_told() -> None:
    spec = """spec s; resource kw: 90 by wait;
    module m { request a() { uses kw 40; } request b() { uses kw 40; } request c() { uses kw 40; } }
    mutex one: m.a, m.b, m.c;"""
    told = found(spec)["rule-use", "kw"].message
    assert told == "it never acts: `one` leaves at most 40 of 90 taken at a time; correct it or take it out"


def test_a_guard_that_ranges_decide_says_so() -> None:
    said = {key: each.message for key, each in found(SPEC).items()}
    one, other = "wind lies in 0 .. 60", "wind lies in 0 .. 60 and k lies in 2 .. 4"
    for name, why in (
        ("m.lift.check.1", f"`wind < 99` is true whatever happens: {one}"),
        ("c.never_so.small", f"`wind + k < 70` is true whatever happens: {other}"),
    ):
        assert said["rule-use", name] == f"it never acts: {why}; correct it or take it out"


@pytest.mark.parametrize(
    ("assumed", "message"),
    [
        (
            "assume fair reports; assume always wind < 0;",
            "from here on they forbid every step; steps there break that at s.prop:1:29",
        ),
        (
            "assume fair reports; assume never ended(m.cool) and wind == 0; assume always past(m.cool);",
            "forbid every step; steps there break that at s.prop:1:71",
        ),
        (
            "assume always wind > 9;\nassume never active(m.cool);\nassume always wind < 5;",
            "forbid every step; steps there break that at s.prop:1:8, or that at s.prop:3:1",
        ),
        ("assume fair reports; assume always active(m.cool); assume never ended(m.cool);", "reports fair"),
    ],
)
def test_why_assumptions_contradict_each_other_is_told(assumed: str, message: str) -> None:
    finding = found(SPEC, f"for s; {assumed}")["property", "assumptions"]
    assert finding.verdict == "violated"
    assert finding.message.endswith(message)


def test_what_a_guard_is_asked_and_how_much_is_left_is_told() -> None:
    spec = """spec s; poster speed: int in 0 .. 9 = 3; resource fuel: 8 consumable = 2 by wait;
    module m {
        request go(v: int in 0 .. 9) { wait slow: until v <= speed because "too fast"; }
        request burn() { consumes fuel 5; }
    }"""
    said = {key: each.message.partition("; ")[2] for key, each in found(spec).items()}
    asked, read = said["starvation", "m.go"].removeprefix("`m.go` waits by `m.go.slow` (too fast), there ").split(", ")
    assert int(asked.removeprefix("v == ")) > int(read.removeprefix("speed == "))
    start, _, level = said["starvation", "m.burn"].partition("level(fuel) == ")
    assert start == "`m.burn` waits by `fuel`, there " and int(level) < 5


def test_the_argument_that_a_guard_compares_with_those_of_others_is_told() -> None:
    spec = """spec s; module m {
        request drive(truck: int in 1 .. 2) instances 2;
        request charge(truck: int in 1 .. 2) { wait until not active(m.drive with truck == self.truck); }
    }"""
    said = found(spec)["starvation", "m.charge"].message.partition("`m.charge` waits by `m.charge.wait.1`, there ")[2]
    asked, *active = said.split(", ")
    assert asked.startswith("truck == ")
    assert f"running(m.drive with {asked})" in active


def test_all_properties_are_violated_once_assumptions_are_seen_to_contradict_each_other() -> None:
    """An engine that sees no lasso cannot say so of each by itself."""
    question = Question("property", "error", "p", NOWHERE)
    other = replace(question, subject="q")
    told = question.violated(f"{VIOLATED}; {CONTRADICTION}", Trace(()))
    findings = [other.unknown("time limit", "aig"), told, replace(other, check="vacuity").unknown("time limit")]
    first, second, third = contradicted(findings)
    assert first == replace(second, subject="q")
    assert (second.verdict, second.message, second.trace) == ("violated", CONTRADICTION, Trace(()))
    assert third == findings[2]
    assert contradicted(findings[:1]) == tuple(findings[:1])


@pytest.mark.parametrize(
    ("properties", "length"),
    [
        ("property u: not active(m.a) until asked(m.b);", 1),
        ("property l: ltl F launched(m.b);", 1),
        ("property l: always (wind > 40 leads to launched(m.b));", 2),
    ],
)
def test_where_nothing_need_happen_a_lasso_observes_what_is_read(properties: str, length: int) -> None:
    spec = "spec s; poster wind: int in 0 .. 60 = 0; module m { request a(); request b(); }"
    (finding,) = (
        each
        for each in found(spec, f"for s; {properties} assume fair reports; assume never asked(m.a);", AIG).values()
        if each.check == "property"
    )
    assert finding.verdict == "violated" and finding.trace is not None
    assert len(finding.trace.moments) == length and finding.trace.loop_start == length - 1
    assert isinstance(finding.trace.events[-1], Observe)


def test_what_is_used_and_what_refuses_a_launch_that_should_come_are_told() -> None:
    spec = """spec s; resource power: 9 by wait; poster low: bool = false;
module m { request lift() { uses power 7; } request dock() { check seen: past(m.look); } request look(); }
module n { state at: {home, pool} = home; request go() { interrupts self; on ok set at = home; } }
launch home: m.dock() when low;
"""
    properties = """for s; property u: never used(power) > 5;
property l: always (low leads to active(m.dock));
property f: from launched(n.go) possible n.at == pool;
"""
    said = {name: each.message for (_, name), each in found(spec, properties, asked="property").items()}
    assert said["u"].endswith("; there used(power) == 7")
    assert said["l"].endswith("; `m.dock()` is refused by `m.dock.seen`, there not past(m.look)")
    assert "; `n.at == pool` is false whatever happens: " in said["f"]
    assert "is kept waiting" not in said["f"]


def test_findings_that_no_step_shows_name_assumptions_that_contradict_each_other_first() -> None:
    findings = found(SPEC, "for s; assume always wind < 3; assume always wind > 9; property p: never wind == 4;")
    first = {
        check: each.message.partition(",")[0] for (check, _), each in findings.items() if each.verdict == "violated"
    }
    told = "the assumptions contradict each other"
    property_told = first.pop("property")
    assert property_told.startswith(
        f"{told}: from here on they forbid every step; steps there break that at s.prop:1:8"
    )
    assert set(first.values()) == {told}
    assert {"reachability", "rule-use", "lockout"} <= first.keys()


def test_what_can_start_with_some_arguments_is_in_nobodys_way() -> None:
    spec = """spec s; module m { state held: {none, saw} = none;
    request take(t: {none, saw}) { check some: t != none; on ok set held = saw; }
    request drop(t: {none, saw}) { check taken: held == saw; } }"""
    reference = Reference(model_of(spec))
    obstacles = Obstacles(reference, WithoutRules(reference.model), ())
    assert obstacles.blocked(reference.start(), "m.take") is None
    dropped = obstacles.blocked(reference.start(), "m.drop")
    assert dropped is not None and dropped.reason.rule == "m.drop.taken" and dropped.args == ("none",)


DRAWER = """spec drawer; poster heavy: bool = false; latch full: when heavy until drawer.pull;
module drawer {
    state pos: {outside, middle, inside} = outside;
    request push() { check was: pos == outside; on launch set pos = middle; on ok set pos = inside; }
    request pull() { check in_: pos == inside; on ok set pos = outside; }
}"""


@pytest.mark.parametrize("engines", [DIAGRAMS, AIG], ids=["bdd", "aig"])
def test_of_a_conclusion_it_is_told_what_keeps_those_from_a_launch_that_would_make_it_true(engines: Engines) -> None:
    """A push that fails leaves the drawer where neither request takes it."""
    findings = found(DRAWER, "for drawer; property emptied: from full possible not full;", engines, "property")
    assert findings["property", "emptied"].message == (
        "a run comes to where the premise is true, and from there no run comes to the conclusion; there full == true; "
        "`drawer.pull()` is refused by `drawer.pull.in_`, there drawer.pos == middle; "
        "`drawer.push()` is refused by `drawer.push.was`, there drawer.pos == middle"
    )


@pytest.mark.parametrize("engines", [DIAGRAMS, AIG], ids=["bdd", "aig"])
def test_of_an_idle_remedy_it_is_told_what_stands_before_it_or_that_nothing_is_killed(engines: Engines) -> None:
    spec = """spec s; resource air: 6 by wait or reject; poster wind: int in 0 .. 60 = 0;
    module m { request a() { uses air 4; } request b() { uses air 4; } }
    forbid gale: wind > 20 and active(m.a) by kill m.a; forbid storm: wind > 30 and active(m.a) by kill m.a;"""
    findings = found(spec, "", engines, "idle-guard")
    told = {subject: each.message for (_, subject), each in findings.items() if each.verdict == "violated"}
    assert told == {
        "air.reject": "no decision of any run is made by it: `wait` stands before it, and always applies",
        "storm.kill m.a": "no run kills `m.a` for this rule, or gives it up while it waits: "
        "nothing calls for it, or another demand always goes before",
    }


@pytest.mark.parametrize(
    ("assumed", "told"),
    [
        ("never ended(m.fly)", True),
        ("never (ended(m.fly) and active(m.stop))", True),
        ("never (ended(m.fly) and dark)", False),
        ("never (ended(m.fly) and not past(m.stop))", True),
    ],
)
def test_of_a_request_that_is_waited_for_it_is_told_that_an_assumption_keeps_it_from_ending(
    assumed: str, told: bool
) -> None:
    spec = """spec s; poster dark: bool = true; module m { request fly(); request stop(); }
    mutex landed: m.stop over m.fly;"""
    findings = found(spec, f"for s; assume {assumed};", asked="deadlock")
    message = findings["deadlock", "m.stop"].message
    cause = "; `m.fly` does not end there, for the assumption at s.prop:1:8 forbids each report of it"
    if told:
        assert message.endswith(f"`m.stop` waits by `landed`, there stopping(m.fly){cause}")
    else:
        assert cause not in message


@pytest.mark.parametrize("engines", [DIAGRAMS, AIG], ids=["bdd", "aig"])
def test_of_a_wait_that_leads_to_nothing_it_is_told_that_an_ask_supersedes_it(engines: Engines) -> None:
    spec = "spec s; module m { request page(urgent: bool) { interrupts self; } request b(); }"
    properties = """for s; assume fair reports; assume never (rejected(m.page with urgent) and not asked(m.page));
    property told: always (asked(m.page with urgent) leads to active(m.page with urgent));"""
    message = found(spec, properties, engines, "property")["property", "told"].message
    assert message.endswith("; the wait of `m.page` is superseded by the ask in step 3")
