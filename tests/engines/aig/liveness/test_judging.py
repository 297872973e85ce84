"""Answers about infinite runs of random small specs are what explicit search says; lassos show what they say."""

from collections import Counter
from collections.abc import Sequence
from functools import cache

import pytest

from exover.checks.questions import starvation
from exover.engines.aig.circuit.answer import Open, Unreachable
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.encoding.questions import LassoQuestion
from exover.engines.aig.induction.pdr import decide
from exover.engines.aig.liveness.judging import Judging, LassoAnswer, NoLasso, ShownLasso
from exover.loop.formula_classes import path_of
from exover.model.expression import And, Cond, Last
from exover.model.model import Model
from exover.model.property import (
    NO_PROPERTIES,
    Atom,
    Conjunction,
    Disjunction,
    Happened,
    Negation,
    Properties,
    always,
    finally_,
)
from exover.ocrd.compile import Compiled
from tests.engines.aig.runs import known_runs
from tests.support import explicit_ltl
from tests.support.confirming import confirms
from tests.support.engines import model_of
from tests.support.property_cases import WAITING, Case, case_of
from tests.support.small import compiled, explored, small_spec_of
from tests.support.starving import starved
from tests.support.words import word_of

FEW = (17, 29, 51, 73, 119, 246, 253)
"""The random specs that are asked about here: their questions are soon answered."""
PASSES = 5
"""How many passes settle all of these specs."""


def judged(
    made: Compiled, properties: Properties, questions: list[LassoQuestion]
) -> tuple[Encoding, dict[int, LassoAnswer]]:
    """Return the answers, after a look at the invariants among them."""
    encoding = Encoding(made, properties, PASSES)
    found: dict[int, LassoAnswer] = {}

    def say(index: int, answer: LassoAnswer) -> None:
        assert index not in found, "it is answered twice"
        found[index] = answer

    Judging(encoding, questions, decide, say).run(known_runs(encoding))
    for answer in found.values():
        if isinstance(answer, NoLasso):
            assert confirms(encoding.circuit([answer.bad]), answer.bad, Unreachable(answer.invariant))
    return encoding, found


def questions_of(case: Case) -> list[LassoQuestion]:
    """Return questions about runs: what breaks each property that says something of every run, and what keeps it."""
    linear = [formula for formula in case.linear.values() if formula is not None]
    linear += [each.formula for each in case.properties.properties if each.form == "ltl"]
    return [LassoQuestion(asked, case.properties.fair) for each in linear for asked in (Negation(each), each)]


@cache
def answers_of(seed: int) -> dict[LassoQuestion, LassoAnswer]:
    """Return the answers to the questions of a case."""
    case = case_of(seed)
    questions = questions_of(case)
    found = judged(case.made, case.properties, questions)[1]
    return {question: found[index] for index, question in enumerate(questions)}


@pytest.mark.parametrize("seed", FEW)
def test_runs_are_found_where_there_are_some(seed: int) -> None:
    case = case_of(seed)
    for question, answer in answers_of(seed).items():
        told = f"{case.spec}\n{case.properties}\n{question}\n{answer}"
        some = not explicit_ltl.holds(case.moments, Negation(question.path))
        if isinstance(answer, ShownLasso):
            assert some, told
            word = word_of(
                case.made.model, answer.trace, [question.path, *(a.formula for a in case.properties.assumptions)]
            )
            assert word.back is not None
            assert word.satisfies(question.path), told
            assert not question.fair or word.is_fair(), told
            steps = set(range(1, len(word.states)))
            assert all(steps <= word.where(each.formula) for each in case.properties.assumptions), told
        elif isinstance(answer, NoLasso):
            assert not some, told


def test_most_questions_are_answered() -> None:
    """Else the agreement above would say little."""
    kinds = Counter(type(answer) for seed in FEW for answer in answers_of(seed).values())
    assert kinds[Open] * 20 < kinds[ShownLasso] + kinds[NoLasso]
    assert min(kinds[ShownLasso], kinds[NoLasso]) > 10


@pytest.mark.parametrize("seed", WAITING)
def test_starvation_is_what_explicit_search_finds(seed: int) -> None:
    made, answers = found_to_starve(seed)
    for name, answer in answers.items():
        if isinstance(answer, ShownLasso):
            word, told = word_of(made.model, answer.trace, []), f"{small_spec_of(seed)}\n{name}"
            assert word.is_fair(), told
            assert all(word.states[k].places[name] for k in range(word.back or 0, len(word.states))), told


@pytest.mark.parametrize("seed", WAITING)
def test_a_return_to_a_kept_state_is_found_where_a_request_starves(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing but liveness to safety is asked here."""
    only_returns(monkeypatch)
    assert found_to_starve(seed)[1]


def test_a_return_to_the_end_of_a_round_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is asked of one state shows lassos, and none where nothing starves."""
    monkeypatch.setattr(Judging, "_wander", lambda judging, begun, number: None)
    monkeypatch.setattr(Judging, "_return", lambda judging, place: None)
    kinds = Counter[type]()
    for seed in WAITING:
        spec, graph = small_spec_of(seed), explored(seed)
        made = compiled(graph.model)
        names = [request.name for request in made.model.requests]
        found = judged(made, NO_PROPERTIES, [starving(made.model, name) for name in names])[1]
        for index, name in enumerate(names):
            kinds[type(found[index])] += 1
            assert isinstance(found[index], (ShownLasso if starved(graph, name) else NoLasso) | Open), f"{spec}\n{name}"
    assert kinds[ShownLasso] > 3 and kinds[NoLasso] > 3


def found_to_starve(seed: int) -> tuple[Compiled, dict[str, LassoAnswer]]:
    """Return what is said of each request of a spec, which is what explicit search finds."""
    spec, graph = small_spec_of(seed), explored(seed)
    made = compiled(graph.model)
    names = [request.name for request in made.model.requests]
    found = judged(made, NO_PROPERTIES, [starving(made.model, name) for name in names])[1]
    for index, name in enumerate(names):
        assert isinstance(found[index], ShownLasso if starved(graph, name) else NoLasso), (
            f"{spec}\n{name}\n{found[index]}"
        )
    return made, {name: found[index] for index, name in enumerate(names)}


def only_returns(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let nothing but liveness to safety be asked."""

    def returns(judging: Judging) -> None:
        for place in list(judging.left):
            judging._return(place)

    monkeypatch.setattr(Judging, "_wander", lambda judging, begun, number: None)
    monkeypatch.setattr(Judging, "_ask_few_signals", lambda judging: None)
    monkeypatch.setattr(Judging, "_ask_all_signals", returns)


def starving(model: Model, name: str) -> LassoQuestion:
    """Return whether a request may wait for ever."""
    formula = starvation.claim(model, NO_PROPERTIES, name).formula
    path = path_of(formula, positive=False) if formula else None
    assert path is not None and path.exact
    return LassoQuestion(path.formula, fair=True)


ONCE = """spec s; module m {
    state st: {one, two} = one;
    request b() { check first: st == one; on launch set st = two; }
}
"""


def test_a_run_that_sees_all_once_does_not_return(monkeypatch: pytest.MonkeyPatch) -> None:
    only_returns(monkeypatch)
    again = always(finally_(Happened("ended", "m.b")))
    once = finally_(Happened("ended", "m.b"))
    found = judged(compiled(model_of(ONCE)), NO_PROPERTIES, [LassoQuestion(again, False), LassoQuestion(once, False)])[
        1
    ]
    assert isinstance(found[0], NoLasso) and isinstance(found[1], ShownLasso)


TWICE = """spec s; module m {
    state st: {one, two, three} = one;
    request a() { check first: st == one; on launch set st = two; }
    request b() { check second: st == two; on launch set st = three; }
}
"""
ROUND = TWICE.replace("request b", "request c() { check third: st == three; on launch set st = one; } request b")


ALWAYS = And(())
RISING = """spec s; module m {
    request a(v: int in 0 .. 2) { check up: not past(m.a with v >= self.v); }
    request b() { check never: past(m.b); }
}
"""
FALLING = RISING.replace("never: past(m.b)", "risen: past(m.a with v == 2)").replace(
    "; }\n}", "; on ok forget m.a; }\n}"
)


@pytest.mark.parametrize(
    ("spec", "how", "kind", "free"),
    [
        (TWICE, ALWAYS, NoLasso, [1, 0]),
        (ROUND, ALWAYS, ShownLasso, [1, 0]),
        (RISING, Last("m.a", "ok"), NoLasso, [3, 2]),
        (FALLING, Last("m.a", "ok"), ShownLasso, [3, 2]),
    ],
)
def test_values_that_differ_on_a_return_are_compared_then(
    spec: str, how: Cond, kind: type, free: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Once `m.a` has ended all flags are as they were; that a request ends is possible once more, or for ever."""
    asked: list[int] = []
    come_back = Judging._come_back

    def counted(judging: Judging, place: int, free: Sequence[frozenset[int]]) -> list[frozenset[int]] | None:
        asked.append(len(free))
        return come_back(judging, place, free)

    only_returns(monkeypatch)
    monkeypatch.setattr(Judging, "_come_back", counted)
    monkeypatch.setattr(Judging, "_back_to", lambda judging, place, run: None)
    ends = Disjunction((Happened("ended", "m.a"), Happened("ended", "m.b")))
    question = LassoQuestion(always(finally_(Conjunction((ends, Atom(how))))), False)
    assert isinstance(judged(compiled(model_of(spec)), NO_PROPERTIES, [question])[1][0], kind)
    assert asked == free
