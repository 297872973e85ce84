"""Explanations of runs that are written out, and what they say is tried by hand."""

import json
import math
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from exover.explain import counterfactuals
from exover.explain.counterfactuals import LEAST, TERMS
from exover.explain.explain import explain
from exover.explain.intervals import Interval, described, intervals
from exover.explain.source_text import written
from exover.model.explanation import Explanation, RuleVerdict
from exover.model.model import Model
from exover.model.types import Int, Real
from exover.pipeline import load
from exover.report.explanation import render_json, render_text
from exover.run.simulate import ReferenceEngine, simulate
from exover.source import Source

ROVER = Source("rover.exo", (Path(__file__).parents[1] / "vectors" / "rover.exo").read_text(encoding="utf-8"))

LOCALIZED = ['{"ask": "pom.localize"}', '{"report": "pom.localize", "outcome": "ok"}']
MOUNTED = ['{"ask": "arm.mount"}', '{"report": "arm.mount", "outcome": "ok"}']
READY = LOCALIZED + MOUNTED
CALIBRATE, STOP = '{"ask": "arm.calibrate"}', '{"ask": "nd.stop"}'


def goto(v: float = 0.4) -> str:
    return json.dumps({"ask": "nd.goto", "args": {"x": 1, "y": 2, "v": v}})


def move(where: str = "field") -> str:
    return json.dumps({"ask": "arm.move", "args": {"where": where}})


def observe(name: str, value: object) -> str:
    return json.dumps({"observe": name, "value": value})


def model_of(source: Source) -> Model:
    model = load(source).model
    assert model is not None
    return model


def told(*lines: str, spec: Source = ROVER) -> Explanation:
    found = explain(model_of(spec), written(spec), lines)
    assert found is not None
    return found


def text(*lines: str, spec: Source = ROVER) -> list[str]:
    return render_text(model_of(spec), told(*lines, spec=spec)).splitlines()


def last_answer(*lines: str, spec: Source = ROVER) -> list[dict[str, Any]]:
    model = model_of(spec)
    *_, answer = simulate(model, ReferenceEngine(model), lines)
    actions: list[dict[str, Any]] = json.loads(answer)["actions"]
    return actions


def verdict(explanation: Explanation, rule: str) -> RuleVerdict:
    """Return the verdict of a rule in the last account."""
    account = explanation.accounts[-1]
    return next(each for each in account.deciding + account.others if each.rule == rule)


def turns(explanation: Explanation) -> dict[tuple[str, ...], list[str]]:
    """Return by changes the kinds of actions that they bring about."""
    assert explanation.search is not None
    return {turn.changes: [type(a).__name__ for a in turn.actions] for turn in explanation.search.turns}


# ---- each kind of answer ----


def test_a_rejection_by_a_guard() -> None:
    assert text(*READY, move(), goto(0.9)) == [
        "step 6: ask nd.goto(x = 1, y = 2, v = 0.9)",
        "  reject nd.goto [nd.goto.calm]",
        "",
        "why reject nd.goto: what any guard, resource or rule rejects is rejected",
        "  nd.goto.calm rejects it",
        "    rover.exo:15: check calm: v <= 0.5 or not active(arm.move);",
        "    as things are",
        "      v <= 0.5 is false: v = 0.9",
        "      active(arm.move) is true: arm.move is running",
        "  also power makes it wait",
        "    rover.exo:30: resource power: 100 by wait;",
        "    with nd.goto running",
        "      used(power) > 100 is true: used(power) = 105 (nd.goto 60, arm.move 45)",
        "    remedy wait is taken: it always applies",
        "",
        "what would have turned the answer (12 changes tried):",
        "  if arm.move were idle: launch nd.goto(x = 1, y = 2, v = 0.9)",
        "  if the asked v were <= 0.5: wait nd.goto [power]",
    ]
    # Tried: at the end of the interval, right above it, and without the arm.
    assert "wait" in last_answer(*READY, move(), goto(0.5))[0]
    assert "reject" in last_answer(*READY, move(), goto(0.5000001))[0]
    assert "launch" in last_answer(*READY, goto(0.9))[0]


def test_a_launch_names_what_could_have_objected_and_why_it_did_not() -> None:
    found = told(*READY, move())
    assert [each.rule for each in found.accounts[0].others] == ["arm.move.check.1", "power", "crush"]
    assert {each.demand for each in found.accounts[0].others} == {"nothing"}
    crush = verdict(found, "crush")
    assert [(fact.condition, fact.holds, fact.read) for fact in crush.facts] == [
        ("nd.speed > 0.2", False, "nd.speed = 0")
    ]
    assert crush.written is not None
    assert crush.written.startswith("forbid crush: active(arm.move with where == field) and nd.speed > 0.2 by kill arm")
    assert (crush.because, crush.location.line) == ("the arm may hit the ground", 34)
    assert turns(found)[("nd.speed were > 0.2",)] == ["Rejected"]
    assert "launch" in last_answer(*READY, observe("nd.speed", 0.2), move())[0]
    assert "reject" in last_answer(*READY, observe("nd.speed", 0.2000001), move())[0]


def test_a_wait_and_the_kill_that_clears_its_way() -> None:
    found = told(*LOCALIZED, goto(), STOP)
    kill, wait = found.accounts
    assert (kill.text, wait.text) == ("it is in the way of nd.stop", "its way is being cleared")
    assert kill.deciding == wait.deciding
    assert [(each.remedy, each.chosen, each.note) for each in kill.deciding[0].attempts] == [
        ("kill nd.goto", True, "it ends nd.goto")
    ]
    assert turns(found) == {("nd.goto were idle",): ["Launched"]}
    assert "launch" in last_answer(*LOCALIZED, STOP)[0]


def test_a_request_that_waited_is_decided_again() -> None:
    found = told(*LOCALIZED, goto(), STOP, '{"report": "nd.goto", "outcome": "interrupted"}')
    assert found.accounts[0].text.endswith("objects to it, decided again in its waiting place")
    assert turns(found)[("nothing waited at nd.stop",)] == []
    assert "again" not in told(*LOCALIZED, goto()).accounts[0].text


def test_a_kill_that_restores_a_rule() -> None:
    found = told(*READY, move(), observe("nd.speed", 0.3))
    assert found.accounts[0].text == "a rule was broken, and this restores it"
    assert [fact.read for fact in verdict(found, "crush").facts] == ["arm.move has where = field", "nd.speed = 0.3"]
    assert turns(found)[("the observed nd.speed were <= 0.2",)] == []
    assert turns(found)[("arm.move had other arguments",)] == []
    assert last_answer(*READY, move(), observe("nd.speed", 0.2)) == []
    assert last_answer(*READY, move("dock"), observe("nd.speed", 0.3)) == []


def test_a_mutex_is_quoted_as_it_is_written() -> None:
    found = told(*LOCALIZED, goto(), CALIBRATE)
    still = verdict(found, "still")
    assert still.written is not None
    assert still.written.startswith("mutex still: nd.goto, arm.calibrate because")
    assert [fact.read for fact in still.facts] == ["nd.goto is running", "the newcomer is running"]
    assert turns(found) == {("nd.goto were idle",): ["Launched"]}


def test_busy_and_superseded() -> None:
    busy = told(*READY, move(), move())
    assert "does not interrupt itself" in busy.accounts[0].text
    assert busy.accounts[0].deciding == ()
    assert turns(busy) == {("arm.move were idle",): ["Launched"]}
    lines = text(*READY, move(), goto(), goto())
    assert "why reject nd.goto: a newer ask takes its waiting place" in lines
    assert "  power makes it wait" in lines
    waiting = Source("w.exo", "spec w; module m { request a(); request b(); } mutex still: m.a, m.b by wait;")
    assert "something stands in the waiting place of m.b" in "\n".join(
        text('{"ask": "m.a"}', '{"ask": "m.b"}', '{"ask": "m.b"}', spec=waiting)
    )


def test_a_required_launch_that_is_rejected() -> None:
    found = told(observe("battery", 5))
    assert [(each.rule, each.demand) for each in found.accounts[0].deciding] == [
        ("go_home", "launch"),
        ("arm.move.check.1", "reject"),
    ]
    assert turns(found)[("arm.tool were gripper",)] == ["Launched"]
    assert last_answer(*MOUNTED, observe("battery", 5))[0]["launch"] == "arm.move"


STORM = Source(
    "storm.exo",
    """spec storm;
poster wind: int in 0 .. 40 = 0 else 40;
module crane { request lift(); request lower(); }
forbid storm: wind > 20 and active(crane.lift) by kill crane.lower or reject because "a load swings";
""".replace("by kill crane.lower or reject", "by reject"),
)


def test_a_violation_says_why_no_remedy_restores_it() -> None:
    found = told('{"ask": "crane.lift"}', observe("wind", 30), spec=STORM)
    (account,) = found.accounts
    assert account.text == "the rule is broken and no remedy restores it"
    (attempt,) = account.deciding[0].attempts
    assert (attempt.remedy, attempt.chosen) == ("reject", False)
    assert turns(found) == {("the observed wind were <= 20",): [], ("crane.lift were idle",): []}
    assert last_answer('{"ask": "crane.lift"}', observe("wind", 20), spec=STORM) == []


def test_a_broken_reading_is_taken_as_the_worst() -> None:
    first, second = told('{"ask": "crane.lift"}', observe("wind", 99), spec=STORM).accounts
    assert "taken as 40" in first.text
    assert second.deciding[0].facts[0].read == "wind = 40"


def test_remedies_that_do_not_apply_are_told() -> None:
    spec = Source(
        "r.exo",
        """spec r; module m { request a(); request b(); request c(); }
forbid both: (active(m.a) or active(m.c)) and active(m.b) by kill m.a or kill m.c or wait;
""",
    )
    found = told('{"ask": "m.a"}', '{"ask": "m.c"}', '{"ask": "m.b"}', spec=spec)
    assert [(each.remedy, each.chosen, each.note) for each in verdict(found, "both").attempts] == [
        ("kill m.a", False, "the rule would be broken without m.a, too"),
        ("kill m.c", False, "the rule would be broken without m.c, too"),
        ("wait", True, "it always applies"),
    ]


def test_a_step_that_clears_the_slot_whose_rule_reads_its_parameters_is_explained() -> None:
    spec = Source(
        "s.exo",
        "spec s; poster person: bool = false;"
        "module base { request drive(v: real in 0 .. 2) { interrupts self; fail hurt: when person and v > 0.3; } }",
    )
    first, second = (json.dumps({"ask": "base.drive", "args": {"v": v}}) for v in (0.4, 0.5))
    report = '{"report": "base.drive", "outcome": "interrupted"}'
    assert "  launch base.drive(v = 0.5)" in text(first, second, report, spec=spec)
    cleared = text(first, second, spec=spec)
    assert "  kill base.drive [base.drive.interrupts.self]" in cleared


def test_nothing_was_done() -> None:
    found = told(observe("battery", 50))
    assert found.accounts[0].action is None
    assert [fact.read for fact in verdict(found, "go_home").facts] == ["battery = 50"]
    assert turns(found) == {("the observed battery were <= 9",): ["Rejected"]}
    still = text(*READY, move(), goto(), observe("battery", 80))
    assert any(line.endswith("; nd.goto still cannot start") for line in still)
    assert "  power makes it wait" in still


def test_a_rule_that_only_a_stopping_slot_breaks_is_read_with_that_idle() -> None:
    spec = Source(
        "s.exo",
        "spec s; poster wind: int in 0 .. 40 = 0; module m { request lift() { fail when wind > 20; } }",
    )
    lines = text('{"ask": "m.lift"}', observe("wind", 30), observe("wind", 31), spec=spec)
    assert lines[2:] == [
        "why nothing was done: no rule that reads what has changed is broken",
        "  m.lift.fail.1 does not object",
        "    s.exo:1: fail when wind > 20;",
        "    as things are, the stopping slots taken as idle",
        "      active(m.lift) is false: m.lift is idle",
        "",
        "nothing that was tried would have turned the answer: 5 changes of up to 2 quantities",
    ]


@pytest.mark.parametrize(
    ("line", "code", "detail"),
    [
        ("what?", "bad-event", "not JSON"),
        ('{"ask": "nd.gogo"}', "unknown-request", "did you mean `nd.goto`?"),
        (observe("nd.speed", 5), "out-of-range", "nd.speed is 5"),
        ('{"report": "nd.stop", "outcome": "ok"}', "not-active", "slot 0 of nd.stop is idle"),
        ('{"abort": "nd.stop", "waiting": true}', "nothing-to-abort", "nothing waits at nd.stop"),
    ],
)
def test_an_invalid_event_is_explained_by_its_code_and_detail(line: str, code: str, detail: str) -> None:
    found = told(*LOCALIZED, line)
    assert found.search is None
    lines = text(*LOCALIZED, line)
    assert lines[1].startswith(f"  invalid {code}: ")
    assert lines[-1].startswith(f"why invalid {code}: the event cannot be taken: ")
    assert detail in lines[-1]


def test_an_abort_needs_no_rule() -> None:
    lines = text(*LOCALIZED, goto(), '{"abort": "nd.goto"}')
    assert lines[-3:] == [
        "why kill nd.goto: the decisional level has given it up",
        "",
        "nothing in the state could have turned the answer",
    ]


# ---- the search ----


def test_two_changes_where_one_is_not_enough() -> None:
    spec = Source(
        "two.exo",
        """spec two; poster p: int in 0 .. 100 = 0; poster q: real in 0 .. 1 = 0;
module m { request a(n: int in 0 .. 1000) { check p > 40; check q >= 0.5 or n > 700 and p > 90; } }
""",
    )
    found = told('{"ask": "m.a", "args": {"n": 0}}', spec=spec)
    assert found.search is not None
    assert (found.search.most, found.search.complete) == (2, True)
    assert ("p were >= 91", "the asked n were >= 701") not in turns(found)  # what the event gives stands first
    assert turns(found) == {
        ("the asked n were >= 701", "p were >= 91"): ["Launched"],
        ("p were >= 41", "q were >= 0.5"): ["Launched"],
    }
    assert "launch" in last_answer(observe("p", 91), '{"ask": "m.a", "args": {"n": 701}}', spec=spec)[0]
    assert (
        "launch" in last_answer(observe("p", 41), observe("q", 0.5), '{"ask": "m.a", "args": {"n": 0}}', spec=spec)[0]
    )


def test_none_turns_the_answer_and_that_is_said() -> None:
    checks = "".join(f"check p{i} > 4; " for i in range(3))
    posters = "".join(f"poster p{i}: int in 0 .. 9 = 0; " for i in range(3))
    spec = Source("three.exo", f"spec three; {posters} module m {{ request a() {{ {checks} }} }}")
    lines = text('{"ask": "m.a"}', spec=spec)
    assert lines[-1].startswith("nothing that was tried would have turned the answer: ")
    assert lines[-1].endswith(" changes of up to 2 quantities")


def test_trials_are_fewer_where_conditions_are_long(monkeypatch: pytest.MonkeyPatch) -> None:
    names, terms = [f"p{number}" for number in range(120)], TERMS // 20
    monkeypatch.setattr(counterfactuals, "TERMS", terms)
    posters = "".join(f"poster {name}: int in 0 .. 9 = 0; " for name in names)
    check = f"check {' + '.join(names)} > 400;"
    spec = Source("long.exo", f"spec long; {posters} module m {{ request a() {{ {check} }} }}")
    found = told('{"ask": "m.a"}', spec=spec)
    assert found.search is not None
    assert not found.search.complete
    assert LEAST < found.search.tried <= terms // len(names)


@pytest.mark.parametrize("budget", ["WORK", "TERMS"])
def test_a_search_that_either_budget_cuts_says_so(monkeypatch: pytest.MonkeyPatch, budget: str) -> None:
    names = range(4)
    checks = "".join(f"check p{i} > 4; " for i in names)
    posters = "".join(f"poster p{i}: int in 0 .. 9 = 0; " for i in names)
    spec = Source("cut.exo", f"spec cut; {posters} module m {{ request a() {{ {checks} }} }}")
    for each in ("WORK", "TERMS"):
        monkeypatch.setattr(counterfactuals, each, 1 << 60)
    whole = told('{"ask": "m.a"}', spec=spec).search
    assert whole is not None
    assert whole.complete
    assert whole.tried > LEAST
    monkeypatch.setattr(counterfactuals, budget, 1)
    cut = told('{"ask": "m.a"}', spec=spec).search
    assert cut is not None
    assert not cut.complete
    assert cut.tried == LEAST
    assert "the search was cut there" in text('{"ask": "m.a"}', spec=spec)[-1]


def test_a_latch_follows_what_is_imagined_and_broken_rules_are_no_way_out() -> None:
    spec = Source(
        "latch.exo",
        """spec latch; poster t: int in 0 .. 100 = 0;
latch hot: when t > 80 until m.cool;
module m { request go() { check not hot; } request cool(); request fan(); }
forbid loud: active(m.fan) and t > 50 by kill m.fan;
""",
    )
    found = told('{"ask": "m.go"}', spec=spec)
    busy = {("m.go were running",): ["Rejected"]}
    assert turns(found) == {("t were >= 81",): ["Rejected"], ("hot were true",): ["Rejected"]} | busy
    with_fan = told('{"ask": "m.fan"}', '{"ask": "m.go"}', spec=spec)
    assert turns(with_fan) == {("hot were true",): ["Rejected"]} | busy  # t above 80 would have ended the fan before


def test_a_consumable_and_a_past() -> None:
    spec = Source(
        "c.exo",
        """spec c; resource ammo: 10 consumable = 2 by wait because "reload";
module m { request home() returns (err: real in 0 .. 9); request fire() { consumes ammo 3;
  check past(m.home with err < 0.5) because "aim first"; } }
""",
    )
    found = told('{"ask": "m.fire"}', spec=spec)
    assert [(each.rule, each.demand) for each in found.accounts[0].others] == [("ammo", "wait")]
    assert turns(found) == {("past(m.home) had err = 0",): ["Waits"]}
    report = '{"report": "m.home", "outcome": "ok", "results": {"err": 0.5}}'
    later = told('{"ask": "m.home"}', report, '{"ask": "m.fire"}', spec=spec)
    assert verdict(later, "m.fire.check.1").facts[0].read == "m.home has ended ok with err = 0.5"


def test_json_holds_everything() -> None:
    found = told(*READY, move(), goto(0.9))
    report = json.loads(render_json(model_of(ROVER), found))
    assert list(report) == ["step", "event", "actions", "why", "search"]
    assert report["event"] == {"ask": "nd.goto", "args": {"x": 1, "y": 2, "v": 0.9}}
    assert report["actions"] == [{"reject": "nd.goto", "rule": "nd.goto.calm"}]
    (why,) = report["why"]
    assert list(why) == ["action", "text", "deciding", "others"]
    assert why["deciding"][0]["facts"][0] == {"condition": "v <= 0.5", "holds": False, "read": "v = 0.9"}
    assert report["search"]["turns"][0]["if"] == ["arm.move were idle"]
    assert report["search"]["complete"] is True


def test_no_event_is_nothing_to_explain() -> None:
    assert explain(model_of(ROVER), {}, ["", "  \n"]) is None


# ---- intervals ----


def test_regions_of_numbers() -> None:
    real = intervals(Real(0.0, 2.0), {Fraction(0.2)}, 0.3)
    assert real == (
        Interval(0.0, 0.2, True, False, 0.1),
        Interval(0.2, 0.2, True, True, 0.2),
        Interval(0.2, 2.0, False, True, 0.3),
    )
    assert described(real[0], real[1], Real(0.0, 2.0)) == "<= 0.2"
    assert described(real[0], real[0], Real(0.0, 2.0)) == "< 0.2"
    assert described(real[2], real[2], Real(0.0, 2.0)) == "> 0.2"
    assert real[0].meets(real[1])
    assert not real[0].meets(real[2])
    unbounded = intervals(Real(), {Fraction(-1), Fraction(1)}, 9.0)
    assert [each.sample for each in unbounded] == [-2.0, -1.0, 0.0, 1.0, 9.0]
    assert described(unbounded[1], unbounded[3], Real()) == "in -1 .. 1"
    assert described(unbounded[2], unbounded[3], Real()) == "> -1 and <= 1"
    whole = intervals(Int(0, 100), {Fraction(5, 2), Fraction(7), Fraction(999)}, 50)
    assert [(each.low, each.high, each.sample) for each in whole] == [
        (0, 1, 1), (2, 2, 2), (3, 3, 3), (4, 6, 6), (7, 7, 7), (8, 100, 50),
    ]  # fmt: skip
    assert described(whole[1], whole[3], Int(0, 100)) == "in 2 .. 6"
    assert len(intervals(Int(0, 9), (), 3)) == 10


def test_ends_of_regions_are_doubles() -> None:
    """Between a double and the next there is none, so there is no interval."""
    above = math.nextafter(0.5, 1)
    found = intervals(Real(0.0, 1.0), {Fraction(0.5), Fraction(above)}, 0.0)
    assert [(each.low, each.high) for each in found] == [(0.0, 0.5), (0.5, 0.5), (above, above), (above, 1.0)]
    assert all(each.low <= each.sample <= each.high for each in found)
    huge = intervals(Real(), {Fraction(1e300), Fraction(-1e300)}, 0.0)
    assert [each.sample for each in huge if each.low == -math.inf or each.high == math.inf] == [
        math.nextafter(-1e300, -math.inf),
        math.nextafter(1e300, math.inf),
    ]


def test_an_interval_without_its_end_is_told_as_such() -> None:
    kind = Real(0.0, 2.0)
    low, _, high = intervals(kind, {Fraction(0), Fraction(2)}, 1.0)[:3]
    assert (low.low, low.high) == (0.0, 0.0)
    (inner,) = [each for each in intervals(kind, {Fraction(0), Fraction(1)}, 0.0) if each.high == 1.0 and each.low < 1]
    assert described(inner, inner, kind) == "> 0 and < 1"
    assert described(Interval(1.0, 2.0, True, False, 1.5), high, kind) == ">= 1"
    assert described(Interval(1.0, 2.0, True, False, 1.5), Interval(1.0, 2.0, True, False, 1.5), kind) == ">= 1 and < 2"


STOCK = Source(
    "stock.exo",
    """spec stock; poster wind: int in 0 .. 500 = 0; poster gust: int in 0 .. 500 = 0; poster dark: bool = false;
resource ammo: 100 consumable = 6;
module m { request fire() { consumes ammo 5; } request lamp(n: int in 0 .. 100); request fly(); }
forbid empty: active(m.fire) and level(ammo) < 3;
forbid calm: active(m.fly) and (wind <= 450 or wind + gust < 900);
launch home: m.lamp(7) when dark;
""",
)


def test_an_interval_speaks_of_the_moment_in_which_the_newcomer_runs() -> None:
    found = told('{"ask": "m.fire"}', spec=STOCK)
    assert turns(found)[("level(ammo) were >= 8",)] == ["Launched"]
    assert last_answer(observe("ammo", 8), '{"ask": "m.fire"}', spec=STOCK)[0]["launch"] == "m.fire"
    assert last_answer(observe("ammo", 7), '{"ask": "m.fire"}', spec=STOCK)[0]["reject"] == "m.fire"


def test_intervals_of_two_numbers_that_do_not_hang_together_are_told_as_such() -> None:
    spec = Source(
        "pair.exo",
        "spec pair; poster p: real in 0 .. 1 = 0; poster q: real = 0;"
        "module m { request a() { check p > 0.5; check q < -1; } }",
    )
    found = told('{"ask": "m.a"}', spec=spec)
    assert turns(found) == {("p were > 0.5", "q were < -1"): ["Launched"]}


def test_two_numbers_that_are_added_are_told_for_one_value_of_the_first() -> None:
    found = told('{"ask": "m.fly"}', spec=STOCK)
    assert turns(found) == {("wind were 451", "gust were >= 449"): ["Launched"]}


def test_an_imagined_request_is_told_with_the_arguments_by_which_a_launch_rule_knows_it() -> None:
    found = told(observe("dark", True), spec=STOCK)
    assert turns(found)[("m.lamp were running with n = 0",)] == ["Rejected"]
    assert ("m.lamp were running",) not in turns(found)  # with 7 it would be what `home` requires


REFUSING = Source(
    "s.exo",
    """spec s; poster e: bool = false; poster b: bool = false; module m { request dock(); request stop(); }
mutex sa: m.stop over m.dock;
forbid halted: e and active(m.dock) by kill m.dock because "stay out";
launch go: m.dock() when b;
launch brake: m.stop() when e;
""",
)


def test_a_refusal_that_is_not_answered_again_is_told_beside_the_actions() -> None:
    stopped = '{"report": "m.stop", "outcome": "ok"}'
    said = text(observe("e", True), observe("b", True), stopped, stopped, spec=REFUSING)
    assert said[:3] == [
        "step 4: report m.stop ok",
        "  launch m.stop() [brake]",
        "  reject m.dock of go [halted] stay out, as before: not answered again",
    ]
    assert "why reject m.dock of go: what any guard, resource or rule rejects is rejected" in said
    assert "  if b were false: launch m.stop() [brake]" in said


@pytest.mark.parametrize(
    ("line", "title"),
    [
        ('{"ask": "m.dock", "args": {"x": 1}}', "step 1: an invalid event"),
        ('{"observe": "wind", "value": 1}', "step 1: an invalid event"),
        ('{"tick": 1}', "step 1: an event that cannot be read"),
    ],
)
def test_an_invalid_event_is_told_from_one_that_cannot_be_read(line: str, title: str) -> None:
    assert text(line, spec=REFUSING)[0] == title
