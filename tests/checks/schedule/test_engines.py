"""Several engines: who is asked, what becomes of their answers, and how long they may take."""

import time
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from math import inf

import pytest

from benchmarks.engines import TEAMS
from benchmarks.families import coupled, guarded, queues
from exover.checks.finding import Counted, Finding
from exover.checks.questions import safety
from exover.checks.questions.property import VACUOUS
from exover.checks.questions.question import Check, Context, Question, requests
from exover.checks.run import CheckOutcome, check_all
from exover.checks.schedule import agenda, plan, tasks
from exover.checks.schedule.agenda import Agenda, Turn
from exover.checks.schedule.engines import DIAGRAMS, SMALL, Engines, suited
from exover.checks.schedule.engines import LARGE as BITS
from exover.checks.schedule.examination import Examination
from exover.checks.schedule.plan import CheckPlan
from exover.checks.schedule.tasks import TaskRunner
from exover.cli.files import read_spec
from exover.engines.bdd import effort
from exover.engines.bdd.analysis import Analysis
from exover.engines.bdd.loopsets import LoopSets
from exover.limits import NO_LIMITS, Limits, limits_from
from exover.loop.claim import NO_FORMULA, Claim, Opinion, Progress
from exover.loop.finite.builder import ClosedLoop
from exover.model.event import Abort
from exover.model.property import NO_PROPERTIES
from exover.model.semantics import Reference
from exover.model.trace import Disagreement, Moment, Trace
from exover.pipeline import build, load_properties
from exover.source import Source
from tests.checks.work import built, silent
from tests.support.diagrams import check_by_diagrams
from tests.support.hanging import hang
from tests.support.needed import needs_cudd

SPEC = """spec demo;
module m { request a(); request b(); request c() { check active(m.a); } }
mutex m.a, m.b by wait;
mutex second: m.b, m.c by wait;
"""
LARGE = """spec large;
poster p: int in 0 .. 100000 = 0; poster q: int in 0 .. 100000 = 0;
module m { request a() { check p + q < 1000; } request b(); }
mutex m.a, m.b;
"""
"""More than decision diagrams are meant for."""
PORTFOLIO = Engines(("bdd", "z3"))
ALL = Engines(("bdd", "z3", "nusmv"), compared=True)
HOLDS = Opinion("holds", "guess")
Judging = Callable[[str, Claim], Opinion]


@dataclass(frozen=True)
class Fake:
    """An engine that says what it is told to, of formulas."""

    name: str
    say: Judging

    def judge(self, claim: Claim) -> Opinion:
        """Return what it is told to."""
        return Opinion("unknown", "", NO_FORMULA) if claim.formula is None else self.say(self.name, claim)


@dataclass(frozen=True)
class All:
    """The same of an engine that is asked all at once."""

    name: str
    say: Judging

    def judge_all(self, claims: Sequence[Claim], say: Callable[[int, Opinion], None]) -> None:
        """Say what it is told to."""
        for number, claim in enumerate(claims):
            say(number, Fake(self.name, self.say).judge(claim))


def ask(
    monkeypatch: pytest.MonkeyPatch,
    text: str,
    engines: Engines,
    say: Judging,
    limits: Limits = NO_LIMITS,
    properties: str = "",
) -> CheckOutcome:
    """Return what is found with engines that say so beside decision diagrams, which say what they do."""

    def fake(name: str, *rest: object) -> Fake:
        return Fake(name, say)

    def batch(name: str, *rest: object) -> All:
        return All(name, say)

    monkeypatch.setattr(tasks, "judge_of", fake)
    monkeypatch.setattr(tasks, "batch_of", batch)
    made = built(text)
    assumed = NO_PROPERTIES
    if properties:
        loaded = load_properties(Source("demo.prop", properties), made.model).properties
        assert loaded is not None
        assumed = loaded
    found = check_all(made.compiled, silent, CheckPlan(properties=assumed, engines=engines), limits=limits)
    return replace(found, findings=tuple(replace(finding, seconds=0.0) for finding in found.findings))


def by_key(outcome: CheckOutcome) -> dict[tuple[str, str], Finding]:
    return {(finding.check, finding.subject): finding for finding in outcome.findings}


# ---- one engine ----


def test_an_engine_alone_answers_what_it_can_express_and_the_rest_is_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    def say(name: str, claim: Claim) -> Opinion:
        match claim.check:
            case "safety":
                return Opinion("violated", "pdr", "but not much", Trace(()))
            case "deadlock":
                return Opinion("unknown", "", "it gave up")
            case _:
                return HOLDS

    found = by_key(ask(monkeypatch, SPEC, Engines(("z3",)), say))
    assert {finding.engine for finding in found.values()} == {"z3"}
    safe, dead = found["safety", "second"], found["deadlock", "m.a"]
    assert (safe.verdict, safe.method, safe.trace) == ("violated", "pdr", Trace(()))
    assert safe.message == "a step ends with the rule broken; but not much"
    assert (dead.verdict, dead.method, dead.message) == ("unknown", "", "it gave up")
    assert found["consistency", "second"].message == "the rule is not broken in the initial state"
    silent = {(finding.check, finding.verdict, finding.message) for finding in found.values() if not finding.method}
    assert silent - {("deadlock", "unknown", "it gave up")} == {
        ("tables", "unknown", NO_FORMULA),
        ("redundancy", "unknown", NO_FORMULA),
    }


def test_every_trace_is_replayed(monkeypatch: pytest.MonkeyPatch) -> None:
    wrong = Trace((Moment(Abort("m.a", 0), ()),))
    for engines in (Engines(("z3",)), ALL):
        with pytest.raises(Disagreement, match="the walker of the tables answers a run of 1 steps otherwise"):
            ask(monkeypatch, SPEC, engines, lambda name, claim: Opinion("violated", "pdr", trace=wrong))


# ---- a portfolio ----


@pytest.mark.parametrize("limits", [NO_LIMITS, Limits(2)])
def test_another_is_asked_what_diagrams_leave_open(monkeypatch: pytest.MonkeyPatch, limits: Limits) -> None:
    def say(name: str, claim: Claim) -> Opinion:
        return HOLDS if claim.subject != "m.b" else Opinion("unknown", "", "gave up")

    alone = by_key(ask(monkeypatch, LARGE, DIAGRAMS, say, limits))
    both = by_key(ask(monkeypatch, LARGE, Engines(("bdd", "z3")), say, limits))
    assert list(alone) == list(both)
    left = [key for key, finding in alone.items() if finding.verdict == "unknown"]
    assert {"reachability", "deadlock", "redundancy"} <= {check for check, _ in left}
    for key, finding in alone.items():
        if key not in left or key[0] in ("tables", "redundancy"):
            assert both[key] == finding
        elif key[1] == "m.b":
            assert both[key] == replace(finding, message=f"{finding.message}; z3: gave up")
        else:
            assert (both[key].engine, both[key].verdict, both[key].method) == ("z3", "holds", "guess")


def test_what_diagrams_answer_nobody_else_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    def say(name: str, claim: Claim) -> Opinion:
        raise AssertionError(claim)

    for bound in ("LEAST", "MOST"):  # of a slice: on a busy machine a second is little
        monkeypatch.setattr(agenda, bound, 60.0)
    wanted = ask(monkeypatch, SPEC, DIAGRAMS, say)
    for limits in (NO_LIMITS, Limits(2), limits_from(time.monotonic(), 2, 600.0)):
        assert ask(monkeypatch, SPEC, PORTFOLIO, say, limits) == wanted


def of_two_engines() -> tuple[Agenda, list[int], list[int]]:
    """Return the agenda of the graph and then diagrams, and the tasks of the latter: about tables, and the rest."""
    compiled = built(SPEC).compiled
    engines = Engines(("aig", "bdd"))
    asked = tuple(CheckPlan(("tables", "safety", "starvation"), engines=engines).questions(compiled.model))
    agenda = TaskRunner(Examination(compiled, NO_PROPERTIES), asked, engines).agenda(None)
    first, bits = agenda.next(inf), agenda.next(inf)
    assert first is not None and first.numbers == tuple(range(len(asked)))
    assert bits == Turn((2 * len(asked),))
    tables = [len(asked) + number for number, (check, _) in enumerate(asked) if check.name == "tables"]
    return agenda, tables, sorted({len(asked) + number for number in range(len(asked))}.difference(tables))


def test_diagrams_compare_the_tables_while_others_have_still_to_answer_the_rest() -> None:
    agenda, tables, rest = of_two_engines()
    agenda.call([number - len(tables + rest) for number in tables])
    assert agenda.next(inf) == Turn(tuple(tables), together=True, in_order=True)
    for number in rest:
        assert agenda.next(inf) is None  # what is left is asked in one turn
        agenda.call([number - len(tables + rest)])
    assert agenda.next(inf) == Turn(tuple(rest), together=True, in_order=True)


def test_diagrams_compare_the_tables_first() -> None:
    agenda, tables, rest = of_two_engines()
    agenda.call([number - len(tables + rest) for number in (*rest, *tables)])
    assert agenda.next(inf) == Turn(tuple(tables), together=True, in_order=True)
    assert agenda.next(inf) == Turn(tuple(rest), together=True, in_order=True)


@pytest.mark.parametrize("jobs", [1, 2])
def test_another_is_asked_what_takes_too_long(monkeypatch: pytest.MonkeyPatch, jobs: int) -> None:
    def decide(context: Context, question: Question) -> Finding:
        hang()
        raise AssertionError

    endless = Check("endless", "error", "it ends", requests, decide, safety.claim, "it ends", "it does not end")
    monkeypatch.setattr(plan, "CHECKS", (endless, *plan.CHECKS))
    started = time.monotonic()
    found = ask(monkeypatch, SPEC, PORTFOLIO, lambda name, claim: HOLDS, limits_from(started, jobs, 20.0 * jobs))
    assert time.monotonic() - started < 15 * jobs
    late = [finding for finding in found.findings if finding.check == "endless"]
    assert [(each.engine, each.verdict, each.message) for each in late] == [("z3", "holds", "it ends")] * 3
    others = Counter(each.engine for each in found.findings if each.check != "endless")
    assert others["bdd"] > others.total() / 2, "where the machine is busy, diagrams may be late with some"


def test_when_all_take_too_long_the_limit_is_said_once(monkeypatch: pytest.MonkeyPatch) -> None:
    def say(name: str, claim: Claim) -> Opinion:
        hang()
        return HOLDS

    def decide(context: Context, question: Question) -> Finding:
        hang()
        raise AssertionError

    endless = Check("endless", "error", "it ends", requests, decide, safety.claim)
    monkeypatch.setattr(plan, "CHECKS", (endless, *plan.CHECKS))
    found = ask(monkeypatch, SPEC, PORTFOLIO, say, limits_from(time.monotonic(), 2, 5.0))
    late = [finding for finding in found.findings if finding.check == "endless"]
    assert [(each.verdict, each.message) for each in late] == [("unknown", "time limit of 5 s")] * 3


# ---- all of them ----


@pytest.mark.parametrize("limits", [NO_LIMITS, Limits(2)])
def test_all_that_agree_are_named(monkeypatch: pytest.MonkeyPatch, limits: Limits) -> None:
    verdicts = by_key(ask(monkeypatch, SPEC, DIAGRAMS, lambda name, claim: HOLDS))

    def say(name: str, claim: Claim) -> Opinion:
        if (name, claim.check) == ("nusmv", "deadlock"):
            return Opinion("unknown", "", "it crashed")
        return Opinion(verdicts[claim.check, claim.subject].verdict, "guess")

    found = by_key(ask(monkeypatch, SPEC, ALL, say, limits))
    for key, finding in found.items():
        assert replace(finding, engine="bdd", message="") == replace(verdicts[key], message="")
    assert {finding.verdict for finding in found.values()} == {"holds", "violated"}
    engines = {check: {finding.engine for key, finding in found.items() if key[0] == check} for check, _ in found}
    assert engines.pop("tables") == engines.pop("redundancy") == {"bdd"}
    assert engines.pop("deadlock") == {"bdd+z3"}
    assert set(map(frozenset, engines.values())) == {frozenset({"bdd+z3+nusmv"})}
    deadlock = ("deadlock", "m.a")
    assert found[deadlock].message == f"{verdicts[deadlock].message}; nusmv: it crashed"


@pytest.mark.parametrize("limits", [NO_LIMITS, Limits(2)])
def test_a_disagreement_is_a_fault(monkeypatch: pytest.MonkeyPatch, limits: Limits) -> None:
    verdicts = by_key(ask(monkeypatch, SPEC, DIAGRAMS, lambda name, claim: HOLDS))

    def say(name: str, claim: Claim) -> Opinion:
        verdict = verdicts[claim.check, claim.subject].verdict
        if name == "nusmv" and claim.subject == "second" and claim.check in ("safety", "completeness"):
            return Opinion("violated", "guess")
        return Opinion(verdict, "guess") if claim.check != "safety" else Opinion("unknown", "", "no idea")

    told = "engines disagree on safety of `second`: bdd says holds, z3 says unknown, nusmv says violated; and on 1 more"
    with pytest.raises(Disagreement, match=told):
        ask(monkeypatch, SPEC, ALL, say, limits)


ASSUMED = "for demo; property p: possible active(m.a); "


@pytest.mark.parametrize(
    ("assumption", "compared"),
    [
        ("assume never (asked(m.a) and active(m.b));", True),
        ("assume never asked(m.b); assume always asked(m.b);", False),
    ],
)
def test_under_contradictory_assumptions_only_properties_are_compared(
    monkeypatch: pytest.MonkeyPatch, assumption: str, compared: bool
) -> None:
    properties = ASSUMED + assumption

    def nothing(name: str, claim: Claim) -> Opinion:
        return Opinion("unknown", "", "")

    verdicts = by_key(ask(monkeypatch, SPEC, DIAGRAMS, nothing, properties=properties))

    def other(check: str) -> Judging:
        def say(name: str, claim: Claim) -> Opinion:
            verdict = verdicts[claim.check, claim.subject].verdict
            return Opinion({"holds": "violated", "violated": "holds"}[verdict] if claim.check == check else verdict, "")  # type: ignore[arg-type]

        return say

    with pytest.raises(Disagreement):
        ask(monkeypatch, SPEC, ALL, other("property"), properties=properties)
    if compared:
        with pytest.raises(Disagreement):
            ask(monkeypatch, SPEC, ALL, other("reachability"), properties=properties)
    else:
        assert ask(monkeypatch, SPEC, ALL, other("reachability"), properties=properties).findings


def test_a_property_that_says_nothing_is_said_to_by_every_engine(monkeypatch: pytest.MonkeyPatch) -> None:
    def say(name: str, claim: Claim) -> Opinion:
        return Opinion("violated" if claim.check == "vacuity" else "holds", "guess")

    properties = "for demo; property p: always (active(m.a) implies not active(m.b));"
    found = by_key(ask(monkeypatch, SPEC, Engines(("z3",)), say, properties=properties))
    assert found["property", "p"].message == VACUOUS
    assert found["vacuity", "p"].verdict == "violated"


# ---- how many states there are ----


def test_states_are_counted_when_that_is_asked() -> None:
    made = built(SPEC).compiled
    assert check_by_diagrams(made).states is None
    number = check_by_diagrams(made, count=True).states
    assert number is not None
    assert number.number is not None
    assert number.number > 10
    assert check_by_diagrams(made, limits=Limits(2), count=True).states == number
    large = check_by_diagrams(built(LARGE).compiled, count=True).states
    assert large is not None
    assert (large.number, "sum" in large.reason) == (None, True), large


@pytest.mark.parametrize("limits", [NO_LIMITS, Limits(2)])
def test_the_bits_of_a_state_that_is_too_large_are_unknown(limits: Limits) -> None:
    assert check_by_diagrams(built(LARGE).compiled, limits=limits).state_bits is None


def test_states_that_are_not_counted_in_time_are_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    def counted(mine: Examination, progress: Progress) -> Counted:
        hang()
        return Counted(0)

    monkeypatch.setattr(Examination, "counted", counted)
    found = check_by_diagrams(built(SPEC).compiled, limits=limits_from(time.monotonic(), 1, 3.0), count=True)
    assert found.states == Counted(None, "time limit of 3 s")
    assert found.state_bits


class _Undrawn(Analysis):
    """An analysis of which no diagram may be made."""

    @property
    def sets(self) -> LoopSets:  # type: ignore[override]
        raise AssertionError("a diagram is made")


class _Unlooped(Analysis):
    """An analysis of which no loop may be made."""

    @property
    def loop(self) -> ClosedLoop:
        raise AssertionError("classes of arguments are told apart")


@pytest.mark.parametrize(("high", "loops"), [(999, True), (1000, False)])
def test_the_order_of_engines_is_known_before_thousands_of_arguments_are_told_apart(high: int, loops: bool) -> None:
    values = f"int in 0 .. {high}"
    made = built(
        f"spec rich; poster p: {values} = 0; module m {{ request a(k: {values}) {{ check k == p; }} }}"
    ).compiled
    adaptive = Engines(("aig", "bdd"), adaptive=True)
    with pytest.raises(AssertionError, match="told apart") if loops else nullcontext():
        assert suited(adaptive, _Unlooped(made, Reference(made.model), silent)) == adaptive


@pytest.mark.parametrize("name", TEAMS)
def test_the_order_of_engines_is_known_before_large_diagrams_are_made(name: str) -> None:
    made = build(read_spec(f"tests/specs/{name}.exo")).compiled
    adaptive = Engines(("aig", "bdd"), adaptive=True)
    assert suited(adaptive, _Undrawn(made, Reference(made.model), silent)) == adaptive


@needs_cudd
@pytest.mark.parametrize(("spec", "first"), [(guarded(60, 120, 10), "bdd"), (queues(64), "bdd"), (coupled(4), "aig")])
def test_diagrams_come_first_where_components_rest_and_read_few_bits(spec: str, first: str) -> None:
    made = built(spec).compiled
    analysis = Analysis(made, Reference(made.model), silent)
    assert SMALL < (analysis.state_bits or 0) < BITS
    assert suited(Engines(("aig", "bdd"), adaptive=True), analysis).names[0] == first


@pytest.mark.parametrize("engines", [Engines(("bdd",)), Engines(("aig", "bdd"), adaptive=True)], ids=["bdd", "auto"])
@pytest.mark.parametrize(("assumed", "kept"), [("m.st != p", "holds"), ("m.st == p or past(m.a)", "violated")])
def test_readings_of_one_enum_are_compared(engines: Engines, assumed: str, kept: str) -> None:
    spec = "spec s; poster p: {l, r} = l; module m { state st: {l, r} = r; request a(); }"
    made = built(spec)
    loaded = load_properties(
        Source("s.prop", f"for s; assume always ({assumed}); property q: never p == r;"), made.model
    )
    assert loaded.properties is not None, loaded.diagnostics
    findings = check_all(made.compiled, silent, CheckPlan(properties=loaded.properties, engines=engines)).findings
    assert {each.verdict for each in findings if each.check == "tables"} == {"holds"}
    assert [each.verdict for each in findings if each.check == "property"] == [kept]


# ---- limits of diagrams ----


@pytest.mark.parametrize("limits", [NO_LIMITS, Limits(1), Limits(2)])
@pytest.mark.parametrize(("first", "asked_too"), [("bdd", "aig"), ("aig", "")])
def test_what_takes_diagrams_too_many_steps_is_unknown_and_not_asked_of_z3(
    monkeypatch: pytest.MonkeyPatch, limits: Limits, first: str, asked_too: str
) -> None:
    monkeypatch.setattr(tasks, "STEPS", 0)
    monkeypatch.setattr(effort, "OFTEN", 0)

    def say(name: str, claim: Claim) -> Opinion:
        assert name == "aig", "Z3 is asked"
        return Opinion("unknown", "", "no idea")

    engines = Engines(("bdd", "aig", "z3") if first == "bdd" else ("aig", "bdd", "z3"))
    found = by_key(ask(monkeypatch, SPEC, engines, say, limits))
    assert found["reachability", "m.c"].verdict == "unknown"
    assert sorted(found["reachability", "m.c"].message.split("; ")) == sorted(
        ["step limit of diagrams", "aig: no idea"] if asked_too else ["no idea", "bdd: step limit of diagrams"]
    )
