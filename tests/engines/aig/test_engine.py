"""What the engine says of whole specs: only what it knows, whatever is assumed and whatever the tables are."""

import os
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import islice
from random import Random
from select import select
from typing import Any

import pytest

from benchmarks.families import queues
from exover.checks.schedule.plan import CheckPlan
from exover.engines.aig import bad_states, engine, inquiry, portfolio
from exover.engines.aig.bad_states import BadStates
from exover.engines.aig.circuit.answer import Answer, Inputs, Open, Reachable
from exover.engines.aig.circuit.graph import Circuit, Literal
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.encoding.questions import RunQuestion
from exover.engines.aig.engine import UNSETTLED, Aig
from exover.engines.aig.evidence import STRANDED, Answered, Evidence
from exover.engines.aig.inquiry import Inquiry
from exover.engines.aig.liveness.judging import Judging
from exover.engines.aig.portfolio import Portfolio
from exover.engines.aig.simulation.coverage import CoverageGoals
from exover.engines.aig.simulation.replay import replayed
from exover.engines.aig.ways import always_possible
from exover.engines.beside import SideTask
from exover.loop.claim import NO_FORMULA, Claim, Opinion
from exover.model.property import NO_PROPERTIES, Properties
from exover.model.trace import Disagreement
from exover.ocrd.compile import Compiled
from exover.pipeline import load_properties
from exover.source import Source
from tests.support.agreement import enumerated
from tests.support.engines import model_of
from tests.support.growth import LINEAR
from tests.support.launches import LINKED, chain
from tests.support.mutants import mutants
from tests.support.small import compiled

Key = tuple[str, str]
TWO = "module m { request a(); request b(); }"
TWICE = "module m { request a() instances 2; request b(); }"
WAITS = "module m { request a() { wait until not active(m.b); } request b() { check not waiting(m.a); } }"
SELF = "module m { request a(v: int in 0 .. 1) { interrupts self; } request b(); } launch l: m.a(1) when active(m.b);"
STOCK = "module m { request a() { consumes p 2; } request b() { produces p 1; } } resource p: 2 consumable = 2;"
LATCH = """poster hot: bool = true; latch alarm: when hot until m.b;
module m { request a() { check not alarm; } request b(); }"""


def judged(
    made: Compiled, properties: Properties, found: dict[Key, Opinion] | None = None, spare: bool = False
) -> dict[Key, Opinion]:
    """Return what the engine says of everything that is asked, which is put into `found` as it falls."""
    asked = [(check, each) for check, each in CheckPlan(properties=properties).questions(made.model)]
    found = {} if found is None else found

    def say(index: int, opinion: Opinion) -> None:
        key = asked[index][1].check, asked[index][1].subject
        assert key not in found, "it is answered twice"
        found[key] = opinion

    claims: list[Claim] = [check.claim(made.model, properties, each.subject) for check, each in asked]
    Aig(made, properties, budget=2_000_000, spare=spare).judge_all(claims, say)
    return found


def read(spec: str, text: str) -> tuple[Compiled, Properties]:
    made = compiled(model_of(f"spec s; {spec}"))
    loaded = load_properties(Source("s.prop", f"for s; {text}"), made.model)
    assert loaded.properties is not None, loaded.diagnostics
    return made, loaded.properties


def forms(*texts: str) -> str:
    return " ".join(f"property p{number}: {text};" for number, text in enumerate(texts))


NAMES = {TWO: "two", TWICE: "twice", WAITS: "waits", SELF: "self", STOCK: "stock", LATCH: "latch"}
START = forms(
    "possible not active(m.a)",
    "possible (not active(m.a) and not waiting(m.a) and last(m.a) == none)",
    "always (asked(m.a) or asked(m.b) or last(m.a) == none)",
    "never launched(m.a)",
    "ctl !active(m.a)",
    "ctl AX !active(m.a)",
    "ctl EX active(m.a)",
    "ctl EX ended(m.a)",
    "not active(m.b) until active(m.a)",
    "not active(m.a) precedes active(m.a)",
    "active(m.a) precedes past(m.a)",
    "past(m.a) precedes active(m.b)",
    "ltl G (active(m.a) -> X (active(m.a) | ended(m.a)))",
    "ltl X X active(m.a)",
)
GOES_ON = forms(
    "possible active(m.b)",
    "never active(m.b)",
    "never launched(m.b)",
    "always possible active(m.a)",
    "always possible not active(m.b)",
    "from active(m.a) possible active(m.b)",
    "from active(m.b) possible active(m.a)",
    "ctl EF (active(m.a) & AG !active(m.b))",
    "ctl EF (active(m.b) & AG active(m.b))",
    "ctl AG (active(m.a) -> EF active(m.b))",
    "always (active(m.a) leads to not active(m.a))",
    "always (active(m.b) leads to not active(m.b))",
    "ltl G F !active(m.a)",
)
ASSUMED = {
    "nothing": "",
    "fair": "assume fair reports;",
    "that b never ends": "assume never ended(m.b);",
    "that b never ends, and fair": "assume fair reports; assume never ended(m.b);",
    "that a never ends, and fair": "assume fair reports; assume never ended(m.a);",
    "that nothing ends, and fair": "assume fair reports; assume never ended(m.a, m.b);",
    "that b ends only ok": "assume fair reports; assume never last(m.b) == failed;",
    "what no step can do": "assume never not active(m.a); assume never active(m.a);",
    "what no run can do for ever": "assume never (ended(m.a) or asked(m.a, m.b) or killed(m.a, m.b));",
    "what is so from the first step on": "assume always past(m.a);",
    "what strands some": "assume never active(m.b) and last(m.a) == ok; assume never active(m.a) and last(m.a) == ok;",
}


@pytest.mark.parametrize(
    ("spec", "assumed"),
    [
        *((TWO, assumed) for assumed in ASSUMED),
        *((TWICE, assumed) for assumed in ("nothing", "fair", "that b never ends, and fair", "what strands some")),
        *((spec, f"that {name} never ends, and fair") for spec in (WAITS, SELF, STOCK, LATCH) for name in "ab"),
    ],
    ids=lambda value: NAMES.get(value, value),
)
def test_claims_are_about_the_runs_that_go_on(spec: str, assumed: str) -> None:
    agree(spec, ASSUMED[assumed] + GOES_ON)


@pytest.mark.parametrize("spec", [TWO, WAITS, SELF, STOCK, LATCH], ids=lambda spec: NAMES[spec])
def test_claims_about_the_start_are_about_the_start(spec: str) -> None:
    found = agree(spec, START)
    assert all(found["property", f"p{k}"].verdict != "unknown" for k in range(14))


def agree(spec: str, text: str) -> dict[Key, Opinion]:
    """Return what the engine says, after a look at whether plain enumeration says so too."""
    made, properties = read(spec, text)
    wanted, about_nothing = enumerated(made.model, properties, 3000, 30_000)
    found = judged(made, properties)
    for key, opinion in found.items():
        if opinion.verdict != "unknown" and key in wanted and (key[0] == "property" or not about_nothing):
            assert opinion.verdict == wanted[key], f"{key} is {wanted[key]}, not {opinion}, under {text}"
    return found


def test_a_way_that_cannot_go_on_fairly_is_none() -> None:
    """There is a step to b from wherever a is, but b lies on no fair run."""
    found = agree(
        TWO, "assume fair reports; assume never ended(m.b); property p: ctl EF (active(m.a) & !EF active(m.b));"
    )
    assert found["property", "p"].message == STRANDED


def test_a_premise_that_only_stranded_runs_make_true_is_not_said_to_be_possible() -> None:
    text = "assume fair reports; assume never ended(m.b); property p: always (active(m.b) implies last(m.a) == ok);"
    found = agree(TWO, text)
    assert found["vacuity", "p"].verdict == "violated"


def test_what_no_run_does_no_fair_run_does_if_there_is_one() -> None:
    """Though runs on which b is active cannot go on fairly."""
    text = "assume fair reports; assume never ended(m.b); property p: never (ended(m.a) and active(m.b));"
    found = agree(f"{TWO} mutex m.a, m.b;", text)
    assert found["property", "p"].verdict == "holds"


def test_where_no_run_is_fair_nothing_holds() -> None:
    """Every step has a next one that is allowed, but the first launches b, which never ends."""
    text = "assume fair reports; assume never ended(m.b); assume always on; property p: never ended(m.b);"
    found = agree(f"poster on: bool = true; {TWO} launch at_once: m.b() when on;", text)
    assert found["property", "p"].verdict != "holds"


def test_lemmas_about_latches_that_questions_add_stay_with_their_graph() -> None:
    """Of two graphs of one loop such latches have the same numbers, and mean what was asked in each."""
    made, properties = read(TWO, forms("asked(m.a) precedes launched(m.b)", "asked(m.b) precedes launched(m.a)"))
    asked = list(CheckPlan(("property",), properties).questions(made.model))
    claims = [check.claim(made.model, properties, each.subject) for check, each in asked]
    one, other = (Inquiry(Encoding(made, properties), [each], lambda *_: None, "", 1000) for each in claims)
    added, there = (
        [latch for latch in each.bad_states.circuit.latches if latch.node not in each.encoding.own]
        for each in (one, other)
    )
    assert added and [latch.node for latch in added] == [latch.node for latch in there]
    wrong = [(2 * latch.node + (not latch.initial),) for latch in added]
    one.bad_states.portfolio.lemmas.add(wrong)
    assert one.bad_states.portfolio.lemmas.of(one.bad_states.circuit) == tuple(wrong)
    other.follow(one)
    assert other.bad_states.portfolio.lemmas.of(other.bad_states.circuit) == ()


# ---- what rests on the passes ----


def test_what_is_assumed_is_asked_of_steps_that_are_settled() -> None:
    found = agree(chain(4), f"{LINKED} property never_asked: never active(m.r0);")
    assert found["property", "never_asked"].verdict == "violated"
    assert found["reachability", "m.r0"].verdict == "holds"


def test_nothing_that_rests_on_the_passes_is_said_before_they_are_proved(monkeypatch: pytest.MonkeyPatch) -> None:
    """The model checkers leave open whether the passes are enough, and answer all else."""
    answer = portfolio.decide

    def forgetful(circuit: Circuit, say, *, asked=None, budget=0, **more):  # type: ignore[no-untyped-def]
        first = circuit.bad[0]

        def said(index: int, each: Answer) -> None:
            say(index, Open("forgotten") if circuit.bad[index] == first else each)

        return answer(circuit, said, asked=asked, budget=budget)

    monkeypatch.setattr(portfolio, "decide", forgetful)
    monkeypatch.setattr(portfolio, "mutually_inductive", lambda *_: [])
    made, properties = read(CHAIN, forms("always possible active(m.a)", "ctl !EF active(m.a) | AG !past(m.b)"))
    for key, opinion in judged(made, properties).items():
        assert opinion.verdict == "unknown" or opinion.method in ("witness", "initial state"), f"{key}: {opinion}"


CHAIN = """poster hot: bool = false;
module m {
    state x: int in 0 .. 3 = 0;
    request a() { wait until x >= 2; }
    request b() { wait until x == 1; on launch set x = 2; }
    request c() { wait until not hot; on launch set x = 1; on ok set x = 0; }
}"""
"""Where all wait, the last request starts first: it takes a pass for each."""


def test_more_passes_are_tried_where_only_a_model_checker_finds_that_they_are_needed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Exploration is blind."""
    tried: list[int] = []
    encode = engine.Encoding

    def counted(made: Compiled, properties: Properties, passes: int, *more: object) -> engine.Encoding:
        tried.append(passes)
        return encode(made, properties, passes, *more)  # type: ignore[arg-type]

    monkeypatch.setattr(engine, "Encoding", counted)
    monkeypatch.setattr(bad_states.Exploration, "run", lambda exploration, *rounds: {})
    found = judged(*read(CHAIN, forms("always possible active(m.c)", "possible (launched(m.a) and launched(m.c))")))
    assert tried == [2, 2, 3, 3], "one for runs, and one to be made smaller meanwhile"
    assert found["property", "p1"].verdict == "holds"


def test_runs_that_need_more_passes_are_where_it_goes_on() -> None:
    """What a monitor guessed in them is no input of the other loop."""
    made, properties = read(CHAIN, forms("possible (launched(m.a) and launched(m.c))"))
    few, more = (Inquiry(engine.Encoding(made, properties, passes), (), print, "", 0) for passes in (2, 3))
    assert not few.explore()
    assert few.bad_states.runs
    unsettled = few.encoding.circuit(few.encoding.unsettled_parts)
    for run in few.bad_states.runs:
        assert any(replayed(unsettled, [(bad, run) for bad in unsettled.bad]))
    guess = few.encoding.graph.input() >> 1
    unguessed = few.bad_states.runs
    few.bad_states.runs = [tuple(step | {guess} for step in run) for run in unguessed]
    followed: list[Inputs] = []

    def follow(runs: Sequence[Inputs]) -> dict[int, Reachable]:
        followed.extend(runs)
        return {}

    exploration = more.bad_states._exploration(CoverageGoals())
    more.bad_states._exploration = lambda _: exploration  # type: ignore[method-assign]
    exploration.follow = follow  # type: ignore[method-assign]
    assert more.explore(few)
    inputs = dict(zip(few.encoding.given, more.encoding.given, strict=True))
    assert followed == [tuple(frozenset(inputs[node] for node in step) for step in run) for run in unguessed]


# ---- what is insisted on ----


@pytest.mark.parametrize("soon", [True, False])
def test_another_pass_is_tried_where_two_are_not_soon_proved_to_be_enough(
    soon: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is not tried a second time: what three passes need is asked at length."""
    asked = read(TWO, "")
    at_length: list[int] = []
    usual, settle_soon, put = judged(*asked), Portfolio.settle_soon, Portfolio.put

    def hesitant(self: Portfolio, circuit: Circuit, asked: Sequence[int], *rest: Any, **named: bool) -> list[int]:
        return settle_soon(self, circuit, asked, *rest, **named) if soon or 0 not in asked else list(asked)

    def counted(self: Portfolio, circuit: Circuit, asked: Sequence[int], *rest: Any) -> None:
        if 0 in asked and portfolio.LONG in rest:
            at_length.append(self.system.passes)  # type: ignore[attr-defined]
        put(self, circuit, asked, *rest)

    monkeypatch.setattr(Portfolio, "settle_soon", hesitant)
    monkeypatch.setattr(Portfolio, "put", counted)
    found = judged(*asked)
    assert {key: each.verdict for key, each in found.items()} == {key: each.verdict for key, each in usual.items()}
    assert at_length == ([] if soon else [3])


def test_what_errors_depend_on_is_asked_with_the_passes(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = read(TWO + " mutex x: m.a, m.b;", "")
    passes = len(engine.Encoding(*asked, 2).unsettled_parts)
    calls: list[tuple[int, int]] = []
    settle_soon = Portfolio.settle_soon

    def counted(self: Portfolio, circuit: Circuit, asked: Sequence[int], *rest: Any, **named: bool) -> list[int]:
        about_passes = sum(index < passes for index in asked)
        calls.append((about_passes, len(asked) - about_passes))
        return settle_soon(self, circuit, asked, *rest, **named)

    monkeypatch.setattr(Portfolio, "settle_soon", counted)
    judged(*asked)
    assert calls[0][0] == passes and calls[0][1] >= 1
    assert not any(about_passes for about_passes, _ in calls[1:])


def prove_little_soon(asked: tuple[Compiled, Properties], monkeypatch: pytest.MonkeyPatch) -> None:
    """Have model checkers settle soon whether the passes are enough, and nothing else."""
    passes = len(engine.Encoding(*asked, 2).unsettled_parts)
    settle_soon = Portfolio.settle_soon

    def passes_alone(self: Portfolio, circuit: Circuit, asked: Sequence[int], *rest: Any, **named: bool) -> list[int]:
        left = [index for index in asked if index >= passes]
        return [*settle_soon(self, circuit, [index for index in asked if index < passes], *rest, **named), *left]

    monkeypatch.setattr(Portfolio, "settle_soon", passes_alone)


def test_what_is_not_proved_soon_is_asked_at_length_after_all_else(monkeypatch: pytest.MonkeyPatch) -> None:
    both = "active(m.a) and active(m.b)"
    asked = read(TWO + " mutex x: m.a, m.b;", forms("always (active(m.a) leads to ended(m.a))", f"never ({both})"))
    order: list[str] = []
    at_length, run = BadStates.at_length, Judging.run

    def noted(self: BadStates) -> SideTask[Sequence[Answered]]:
        look = at_length(self)

        def noting(tell: Callable[[Sequence[Answered]], None]) -> None:
            if self._later:
                order.append("at length")
            look(tell)

        return noting

    def lassos(self: Judging, runs: Sequence[Inputs]) -> None:
        order.append("lassos")
        run(self, runs)

    usual = judged(*asked)
    prove_little_soon(asked, monkeypatch)
    monkeypatch.setattr(BadStates, "at_length", noted)
    monkeypatch.setattr(Judging, "run", lassos)
    found = judged(*asked)
    assert {key: each.verdict for key, each in found.items()} == {key: each.verdict for key, each in usual.items()}
    assert order.index("lassos") < order.index("at length")


# ---- errors first ----


def explored(spec: str, text: str) -> list[tuple[str, str, str]]:
    """Return what exploration says alone, in order, of all that is asked: check, subject and verdict."""
    made, properties = read(spec, text)
    asked = [(check, each) for check, each in CheckPlan(properties=properties).questions(made.model)]
    claims: list[Claim] = [check.claim(made.model, properties, each.subject) for check, each in asked]
    said: list[tuple[int, Opinion]] = []
    found = Inquiry(engine.Encoding(made, properties, 2), claims, lambda *each: said.append(each), "", 0)
    assert found.explore()
    return [(asked[k][1].check, asked[k][1].subject, opinion.verdict) for k, opinion in said]


def test_infinite_runs_that_are_errors_are_looked_for_at_once() -> None:
    """A wait that starves is none."""
    spec = "module m { request a(); request b() { wait until not active(m.a) and not active(m.c); } request c(); }"
    said = explored(spec, forms("always (active(m.a) leads to not active(m.a))"))
    assert said[0] == ("property", "p0", "violated"), "before what runs show that is no error"
    assert [each for each in said if each[2] == "violated"] == [said[0]]
    assert judged(*read(spec, ""))["starvation", "m.b"].verdict == "violated"


def test_of_what_runs_show_together_errors_are_said_first() -> None:
    spec = "module m { request a(); request b() { check not active(m.a); } }"
    said = explored(spec, forms("never active(m.a)"))
    assert said[:2] == [("property", "p0", "violated"), ("reachability", "m.a", "holds")]


# ---- what it leaves to others ----


def test_what_no_formula_says_is_left_to_others_before_the_graph_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    class Made(Exception):
        """The graph would be made now."""

    def encoding(*parts: object) -> None:
        raise Made

    monkeypatch.setattr(engine, "Encoding", encoding)
    found: dict[Key, Opinion] = {}
    made = compiled(model_of(f"spec s; {TWO}"))
    with pytest.raises(Made):
        judged(made, NO_PROPERTIES, found)
    of_tables = {(check.name, each.subject) for check, each in CheckPlan().questions(made.model)}
    of_tables = {key for key in of_tables if key[0] == "tables"}
    assert of_tables
    assert {key: found[key] for key in of_tables} == dict.fromkeys(of_tables, Opinion("unknown", "", NO_FORMULA))


def test_what_is_given_up_is_left_to_others_before_the_rest_is_looked_into(monkeypatch: pytest.MonkeyPatch) -> None:
    """The model checkers know that the passes are enough, and no more."""
    answer = portfolio.decide

    def forgetful(circuit: Circuit, say, *, asked=None, budget=0, **more):  # type: ignore[no-untyped-def]
        first.append(circuit.bad[0])

        def said(index: int, each: Answer) -> None:
            say(index, each if circuit.bad[index] == first[0] else Open("forgotten"))

        return answer(circuit, said, asked=asked, budget=budget)

    first: list[Literal] = []
    before: list[set[Key]] = []
    monkeypatch.setattr(portfolio, "decide", forgetful)
    monkeypatch.setattr(portfolio, "mutually_inductive", lambda *_: [])
    monkeypatch.setattr(BadStates, "at_length", lambda self: lambda tell: before.append(set(found)))
    monkeypatch.setattr(inquiry.always_possible, "judge_ways", lambda *parts, **named: None)
    found: dict[Key, Opinion] = {}
    ends = forms("always (active(m.a) leads to ended(m.a))", "always possible active(m.a)")
    judged(*read(TWO, f"assume fair reports; {ends}"), found)
    assert found["property", "p0"].message == "forgotten"
    assert ("property", "p0") in before[-1]
    assert found["property", "p1"].verdict == "unknown"
    assert ("property", "p1") not in before[-1]


@pytest.mark.parametrize(
    ("spec", "little"),
    [(WAITS, False), (LATCH, False), (SELF, True), (STOCK, True)],
    ids=["waits", "latch", "self, little", "stock, little"],
)
def test_several_processes_say_the_same_as_one(spec: str, little: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the same runs: none sees what the others add to the graph. `little`: is proved soon, or seen at random."""
    asked = read(spec, forms("always possible active(m.b)", "always (active(m.a) leads to ended(m.a))"))
    if little:
        prove_little_soon(asked, monkeypatch)
        monkeypatch.setattr(bad_states.Exploration, "run", lambda exploration, *rounds: {})
    one, two = judged(*asked), judged(*asked, spare=True)
    assert one == two


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system forks no process")
@pytest.mark.parametrize(
    ("beside", "spec"),
    [("redundancy", f"{WAITS} mutex x: m.a, m.b;"), ("deadlock", WAITS), ("safety", f"{TWO} mutex x: m.a, m.b;")],
)
def test_what_a_second_process_finds_is_said_before_lassos_are_done(
    beside: str, spec: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What rules change, ways, and what is not proved soon."""

    def delayed(self: Aig, *rest: Any) -> None:
        if beside == "redundancy":
            os.read(begun, 1)
        compare(self, *rest)

    def patient(self: Judging, runs: Sequence[Inputs]) -> None:
        os.write(begin, b".")
        in_time, _, _ = select([said], [], [], 30)
        os.write(tell, b"+" if in_time else b"-")
        answer(self, runs)

    class Saying(dict[Key, Opinion]):
        def __setitem__(self, key: Key, opinion: Opinion) -> None:
            super().__setitem__(key, opinion)
            if key[0] == beside:
                os.write(say, b".")

    begun, begin = os.pipe()
    said, say = os.pipe()
    told, tell = os.pipe()
    compare, answer = Aig._compare, Judging.run
    monkeypatch.setattr(Aig, "_compare", delayed)
    monkeypatch.setattr(Judging, "run", patient)
    asked = read(spec, forms("always (active(m.a) leads to ended(m.a))"))
    if beside == "safety":
        prove_little_soon(asked, monkeypatch)
    judged(*asked, Saying(), spare=True)
    assert os.read(told, 1) == b"+"
    for end in (begun, begin, said, say, told, tell):
        os.close(end)


def test_one_process_looks_for_ways_before_lassos(monkeypatch: pytest.MonkeyPatch) -> None:
    """Errors depend on ways, and they take less time."""
    order: list[str] = []
    look, run = always_possible.judge_ways, Judging.run

    def ways(*given: Any, **named: Any) -> None:
        order.append("ways")
        look(*given, **named)

    def lassos(judging: Judging, runs: Sequence[Inputs]) -> None:
        order.append("lassos")
        run(judging, runs)

    monkeypatch.setattr(always_possible, "judge_ways", ways)
    monkeypatch.setattr(Judging, "run", lassos)
    judged(*read(WAITS, forms("always (launched(m.b) leads to ended(m.b))")))
    assert order == ["ways", "lassos"]


def test_what_rules_change_is_proved_only_if_the_passes_are(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a run shows is believed."""

    def unsure(self: Inquiry, **options: Any) -> bool:
        self.evidence.settled = False
        return True

    spec = (
        "module m { request a(); request b(); request c(); } mutex x: m.a, m.b; mutex y: m.b, m.a; mutex z: m.a, m.c;"
    )
    sure = judged(*read(spec, ""))
    monkeypatch.setattr(Inquiry, "settle", unsure)
    found = judged(*read(spec, ""))
    changes = {key: (each.verdict, each.method) for key, each in sure.items() if key[0] == "redundancy"}
    assert changes == {
        ("redundancy", "x"): ("violated", "k-induction k=1"),
        ("redundancy", "y"): ("violated", "k-induction k=1"),
        ("redundancy", "z"): ("holds", "witness"),
    }
    for key, (verdict, method) in changes.items():
        assert found[key].verdict == (verdict if method == "witness" else "unknown")


# ---- damaged tables ----

HUNGRY = """module m { request a() { consumes p 2; consumes p 1; } request b(); }
resource p: 3 consumable = 3;"""


def test_a_level_below_zero_leaves_everything_unknown_that_no_run_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is damaged is that the tables look at the level before they consume."""
    made = compiled(model_of(f"spec s; {HUNGRY}"))
    (entry,) = (row.entry for row in made.tables.stocks)
    nodes = tuple(
        replace(node, low=node.high) if node.code == entry and node.code >= 0 else node for node in made.tables.nodes
    )
    assert nodes != made.tables.nodes
    damaged = replace(made, tables=replace(made.tables, nodes=nodes))
    monkeypatch.setattr(engine, "PASSES", range(2, 4))
    found = judged(damaged, NO_PROPERTIES)
    assert {each.verdict for key, each in found.items() if key[0] == "safety"} <= {"unknown"}
    others = [each for each in found.values() if each.method != "witness"]
    assert {each.verdict for each in others} == {"unknown"}
    assert UNSETTLED in {each.message for each in others} <= {UNSETTLED, NO_FORMULA}


@pytest.mark.parametrize("spec", [WAITS, SELF, STOCK, LATCH], ids=["waits", "self", "stock", "latch"])
def test_damaged_tables_are_never_a_fault_but_that_they_disagree(spec: str) -> None:
    made = compiled(model_of(f"spec s; {spec}"))
    counts: Counter[str] = Counter()
    source = mutants(made.tables, Random(5))
    formed = (each for each in source if each[0] in ("bound", "swapped"))
    for way, tables in islice(formed, 4):
        try:
            judged(replace(made, tables=tables), NO_PROPERTIES)
        except Disagreement:
            counts["disagreement"] += 1
        counts[way] += 1
    assert counts["disagreement"]


def test_opinions_are_formed_as_answers_come_in_and_not_each_time_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    formed, form = Counter[int](), Evidence.opinion

    def opinion(mine: Evidence, question: RunQuestion, claim: Claim) -> Opinion:
        formed[size] += 1
        return form(mine, question, claim)

    monkeypatch.setattr(Evidence, "opinion", opinion)
    for size in (4, 8):
        judged(compiled(model_of(queues(size))), NO_PROPERTIES)
    assert formed[8] < LINEAR * formed[4]
