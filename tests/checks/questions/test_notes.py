"""What `redundancy` and `idle-guard` say where it is easy to get wrong."""

import pytest

from exover.model.event import Ask
from exover.model.expression import Status
from exover.model.model import NOWHERE
from exover.model.property import NO_PROPERTIES, TRUE, Assumption, Atom, Conjunction, Happened, Negation, Properties
from exover.ocrd.compile import Compiled
from tests.support.diagrams import check_by_diagrams
from tests.support.engines import model_of
from tests.support.small import VARIED, compiled, small_spec_of

Verdicts = dict[tuple[str, str], str]
ASKED = {"redundancy", "idle-guard", "rule-use"}


ALWAYS_TRUE = Properties((), (Assumption(TRUE, NOWHERE),))
"""Changes nothing but the way of looking: where something is assumed, no short run is tried first."""


def while_active(state: str) -> str:
    """Return the clauses by which a state is true while their request is active."""
    endings = " ".join(f"on {outcome} set {state} = false;" for outcome in ("ok", "failed", "interrupted"))
    return f"on launch set {state} = true; {endings}"


def verdicts_of(made: Compiled, properties: Properties = NO_PROPERTIES) -> Verdicts:
    findings = check_by_diagrams(made, ASKED, properties=properties).findings
    return {(each.check, each.subject): each.verdict for each in findings}


def notes_of(text: str) -> Verdicts:
    made = compiled(model_of(text))
    found = verdicts_of(made)
    assert found.items() <= verdicts_of(made, ALWAYS_TRUE).items()  # which also asks whether it can be assumed
    return found


@pytest.mark.parametrize("seed", VARIED)
def test_what_short_runs_show_is_what_the_diagrams_say(seed: int) -> None:
    notes_of(small_spec_of(seed))


def test_a_kill_that_a_later_rule_would_do_as_well_changes_nothing() -> None:
    rules = (
        "forbid gale: wind > 3 and active(m.a) by kill m.a;",
        "forbid storm: wind > 2 and active(m.a) by kill m.a;",
    )
    for text in (" ".join(rules), " ".join(reversed(rules))):
        found = notes_of(f"spec s; poster wind: int in 0 .. 4 = 0; module m {{ request a(); }} {text}")
        assert found["redundancy", "gale"] == "violated"
        assert found["redundancy", "storm"] == "holds"


def test_a_kill_that_only_restores_a_rule_is_a_change() -> None:
    """No ask is decided otherwise: the guard has rejected it."""
    found = notes_of("""spec s; poster wind: int in 0 .. 4 = 0;
        module m { request a() { check wind <= 2; } }
        forbid storm: wind > 2 and active(m.a) by kill m.a;""")
    assert found["redundancy", "storm"] == "holds"


def test_a_violation_is_a_change() -> None:
    found = notes_of("""spec s; poster wind: int in 0 .. 4 = 0;
        module m { request a() { check wind <= 2; } }
        forbid storm: wind > 2 and active(m.a) by reject;""")
    assert found["redundancy", "storm"] == "holds"
    assert found["idle-guard", "storm.reject"] == "violated"


def test_each_of_two_equal_rules_is_redundant() -> None:
    found = notes_of("spec s; module m { request a(); request b(); } mutex x: m.a, m.b; mutex y: m.b, m.a;")
    assert found["redundancy", "x"] == found["redundancy", "y"] == "violated"
    assert found["idle-guard", "x.reject"] == "holds"
    assert found["idle-guard", "y.reject"] == "violated"


def test_another_verdict_is_a_change_another_reason_is_none() -> None:
    for first, verdict in (("by wait", "holds"), ("", "violated")):
        found = notes_of(f"spec s; module m {{ request a(); request b(); }} mutex x: m.a, m.b {first}; mutex m.a, m.b;")
        assert found["redundancy", "x"] == "violated"
        assert found["redundancy", "mutex.2"] == verdict


def test_a_rule_may_matter_within_a_step_alone() -> None:
    """`s` is true only between the launches of b and d, which wait for the same reading; a is decided between them."""
    found = notes_of("""spec s; poster p: bool = false;
        module m {
            state s: bool = false;
            request b() { check not active(m.a); wait until p and waiting(m.d); on launch set s = true; }
            request a() { wait until p; }
            request d() { wait until p; on launch set s = false; }
        }
        forbid x: active(m.a) and m.s by reject;""")
    assert found["redundancy", "x"] == "holds"


@pytest.mark.parametrize(
    ("guards", "verdict"),
    [
        ("check not busy;", "violated"),
        ("check not busy; wait until p;", "holds"),
        ("check not waiting(m.a); wait until not busy;", "holds"),
        ("check active(m.a) or not busy;", "violated"),
    ],
    ids=["never twice", "supersedes", "waits for itself", "counts itself out"],
)
def test_who_interrupts_itself_would_be_busy_without(guards: str, verdict: str) -> None:
    """None of these is ever launched over itself; what is rejected with the clause may as well be busy."""
    found = notes_of(f"""spec s; poster p: bool = true;
        module m {{
            state busy: bool = false;
            request a(k: bool) {{ {guards} interrupts self; {while_active("busy")} }}
        }}""")
    assert found["redundancy", "m.a.interrupts.self"] == verdict


def test_another_kill_is_a_change() -> None:
    found = notes_of("""spec s; module m { request a(); request b(); request c(); }
        forbid x: active(m.c) and (active(m.a) or active(m.a) and active(m.b)) by kill m.a, m.b;
        forbid y: active(m.c) and active(m.a) by kill m.a;""")
    assert found["redundancy", "x"] == "holds"
    assert found["redundancy", "y"] == "violated"


def test_a_short_run_is_shown_where_there_is_one() -> None:
    text = "spec s; module m { request a(); request b(); request c(); } limit x: at most 2 of m.a, m.b, m.c;"
    findings = check_by_diagrams(compiled(model_of(text))).findings
    (found,) = (each for each in findings if each.check == "redundancy")
    assert found.method == "witness"
    assert found.trace is not None
    assert found.trace.events == (Ask("m.a"), Ask("m.b"), Ask("m.c"))


def test_only_steps_that_are_assumed_are_looked_at() -> None:
    text = "spec s; module m { request a(); request b(); } mutex x: m.a, m.b;"
    made = compiled(model_of(text))
    assert verdicts_of(made)["redundancy", "x"] == "holds"
    both = [("m.a", "m.b"), ("m.b", "m.a")]
    never = [Negation(Conjunction((Happened("asked", a), Atom(Status("active", b, None))))) for a, b in both]
    assumed = verdicts_of(made, Properties((), tuple(Assumption(each, NOWHERE) for each in never)))
    assert assumed["redundancy", "x"] == assumed["idle-guard", "x.reject"] == "violated"
    half = verdicts_of(made, Properties((), (Assumption(never[0], NOWHERE),)))
    assert half["redundancy", "x"] == half["idle-guard", "x.reject"] == "holds"


def test_guards_and_remedies_have_stable_names() -> None:
    found = notes_of("""spec s; poster p: bool = false;
        resource power: 2 by kill m.a or wait;
        resource ink: 1 consumable;
        module m {
            request a() { uses power 1; consumes ink 1; after m.b; fail when p else wait; }
            request b() { interrupts self; settle calm: until p; }
        }
        mutex x: m.b over m.a;
        limit at most 1 of m.a, m.b by kill m.a, m.b or reject;""")
    assert [subject for check, subject in found if check == "idle-guard"] == [
        *("power.kill m.a", "power.wait", "m.a.after.m.b", "m.a.fail.1.kill m.a", "m.a.fail.1.wait"),
        *("m.b.interrupts.self.kill m.b", "m.b.calm", "x.kill m.a"),
        *("limit.1.kill m.a", "limit.1.kill m.b", "limit.1.reject", "ink.reject"),
    ]


def test_a_guard_decides_for_what_waits_without_a_word() -> None:
    found = notes_of("""spec s; poster p: bool = false;
        module m {
            request a() { check waiting(m.a) or not active(m.b); wait until p; wait late: until not active(m.b); }
            request b();
        }""")
    assert found["rule-use", "m.a.late"] == "violated"
    assert found["idle-guard", "m.a.late"] == "holds"


def test_a_guard_that_can_never_be_true_decides_for_what_it_holds_back() -> None:
    found = notes_of("""spec s; module m { request a(); request b() { after m.a; settle until false; } }
        mutex m.b over m.a; launch m.a() when true;""")
    assert found["idle-guard", "m.b.settle.1"] == "holds"


def test_a_kill_that_never_applies_is_idle_beside_one_that_does() -> None:
    found = notes_of("""spec s; module m { request a(); request b(); request c(); }
        forbid x: active(m.c) and active(m.a) by kill m.a;
        forbid y: active(m.c) and active(m.b) by wait or kill m.b;""")
    assert found["idle-guard", "x.kill m.a"] == "holds"
    assert found["idle-guard", "y.kill m.b"] == "violated"
    assert found["idle-guard", "y.wait"] == "holds"


def test_giving_up_what_waits_is_a_change_and_the_work_of_a_kill() -> None:
    """Neither is decided while the other is active, so no slot is ever killed; what settles is given up."""

    found = notes_of(f"""spec s; poster p: bool = false;
        module m {{
            state moving: bool = false;
            state lifting: bool = false;
            request a() {{ check not lifting; settle until p; {while_active("moving")} }}
            request b() {{ check not moving; {while_active("lifting")} }}
        }}
        mutex x: m.a, m.b by kill m.a, m.b;""")
    assert found["idle-guard", "m.a.settle.1"] == "holds"
    assert found["idle-guard", "x.kill m.a"] == "holds"
    assert found["idle-guard", "x.kill m.b"] == "violated"
    assert found["redundancy", "x"] == "holds"


def test_of_a_level_that_no_table_tests_diagrams_know_nothing() -> None:
    """Since `x` always makes it wait, whether there is enough of `f` matters to nobody, but without `x`."""
    made = compiled(
        model_of("""spec s; forbid x: active(m.b) by wait;
        module m { request b() { consumes f 2; } } resource f: 2 consumable by wait;""")
    )
    assumed = Properties((), (Assumption(Negation(Happened("rejected", "m.b")), NOWHERE),))
    findings = check_by_diagrams(made, {"redundancy"}, properties=assumed).findings
    assert [(each.verdict, each.message) for each in findings if each.check == "redundancy"] == [
        ("unknown", "the level of `f`, which no table tests, is not followed")
    ]
