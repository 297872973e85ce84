"""Whether there is a way from everywhere is what plain enumeration finds."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import pytest

from exover.checks.questions import deadlock, lockout
from exover.engines.aig.circuit.answer import Answer
from exover.engines.aig.circuit.graph import Circuit
from exover.engines.aig.encoding.concretize import Concretizer
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.encoding.questions import CutOff, Questions, questions_in
from exover.engines.aig.induction import pdr
from exover.engines.aig.induction.implicants import Decide, StatesOfKind
from exover.engines.aig.induction.reached_bmc import runs_from_start
from exover.engines.aig.simulation.exploration import Seed
from exover.engines.aig.ways import always_possible, word_search
from exover.engines.aig.ways.always_possible import NeverCutOff, ShownCutOff, WayAnswer, Ways, judge_ways
from exover.engines.aig.ways.beginnings import Beginnings
from exover.engines.aig.ways.home_states import HomeSpace
from exover.engines.aig.ways.preconditions import Preconditions
from exover.engines.aig.ways.word_search import WaysBudget, WordSearch
from exover.model.event import Ask
from exover.model.property import NO_PROPERTIES
from exover.model.semantics import Reference
from exover.ocrd.compile import Compiled
from exover.pipeline import load_properties
from exover.source import Source
from tests.engines.aig.runs import known_runs
from tests.support.engines import model_of
from tests.support.oracle import verdicts, wrong
from tests.support.representatives import Representatives
from tests.support.small import VARIED, compiled, explored, small_spec_of

BUDGET = WaysBudget(rounds=3)
CHECKS = (deadlock.CHECK, lockout.CHECK)


def decide(circuit: Circuit, say: Callable[[int, Answer], None], stop: Callable[[], bool]) -> None:
    pdr.decide(circuit, say, stop=stop, budget=20_000_000)


def asked_of(made: Compiled) -> tuple[Encoding, dict[tuple[str, str], CutOff]]:
    """Return the questions about deadlock and lockout of each request."""
    encoding = Encoding(made, NO_PROPERTIES)
    questions = Questions(encoding)
    asked: dict[tuple[str, str], CutOff] = {}
    for check in CHECKS:
        for request in made.model.requests:
            formula = check.claim(made.model, NO_PROPERTIES, request.name).formula
            assert formula is not None
            (question,) = questions_in(questions.of(formula))
            assert isinstance(question, CutOff)
            asked[check.name, request.name] = question
    return encoding, asked


def judged(made: Compiled) -> tuple[Encoding, dict[tuple[str, str], WayAnswer]]:
    """Return what is said of each question."""
    encoding, asked = asked_of(made)
    keys = list(asked)
    found: dict[tuple[str, str], WayAnswer] = {}

    def say(index: int, verdict: WayAnswer) -> None:
        assert keys[index] not in found
        found[keys[index]] = verdict

    judge_ways(encoding, list(asked.values()), known_runs(encoding), decide, say, BUDGET)
    return encoding, found


def test_questions_with_few_steps_are_asked_first_and_all_are_answered_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each that lets the graph grow is the last of its part."""
    made = compiled(model_of(small_spec_of(7)))
    _, together = judged(made)
    ask, turns = Ways._ask, list[list[int]]()

    def noted(self: Ways, part: Mapping[int, StatesOfKind]) -> bool:
        turns.append([sum(map(len, self.words.rehearsal.chosen(index))) for index in part])
        return ask(self, part)

    monkeypatch.setattr(Ways, "_ask", noted)
    monkeypatch.setattr(always_possible, "GROWTH", 0)
    _, found = judged(made)
    assert {key: type(each) for key, each in found.items()} == {key: type(each) for key, each in together.items()}
    assert len(turns) > 2
    assert turns[0] == min(turns) < max(turns), turns
    assert all(turn == sorted(turn) for turn in turns)


def unprepared(made: Compiled, decide: Decide = decide) -> Ways:
    """Return ways with all that is made before words are looked for, and samples."""
    encoding, asked = asked_of(made)
    found = Ways(encoding, list(asked.values()), known_runs(encoding), decide, lambda *_: None, BUDGET, runs_from_start)
    home, beginnings = HomeSpace(encoding), Beginnings(encoding, found.circuit, found.cone, found.fresh)
    preconditions = Preconditions(found.graph, found.circuit, found.aims, found.fresh, home.fixed, False)
    found.words = WordSearch(
        encoding, found.circuit, found.cone, found.left.keys(), beginnings, preconditions, (), BUDGET
    )
    found.words.take(beginnings.of(beginnings.passed(found.runs, 64)))
    return found


def test_random_runs_go_on_while_they_come_to_states_without_a_word(monkeypatch: pytest.MonkeyPatch) -> None:
    """A question that is hard has none from most states, which is no news."""
    found, drawn = unprepared(compiled(model_of(small_spec_of(7)))).words, list[int]()
    near = Beginnings.near

    def noted(self: Beginnings, seeds: Sequence[Seed]) -> list[Seed]:
        drawn.append(len(seeds))
        assert len(drawn) < 100, "it goes on for ever"
        return near(self, seeds)

    monkeypatch.setattr(Beginnings, "near", noted)
    found.hard = set(found.left)
    found.wander(found.rehearsal.samples)
    assert len(drawn) == word_search.VAIN
    found.hard = set()
    known = len(found.rehearsal.samples)
    found.wander(found.rehearsal.samples[:1])
    assert len(drawn) > 2 * word_search.VAIN
    assert len(found.rehearsal.samples) > known
    assert found.rehearsal.leading  # words were looked for from there
    found.budget, drawn[:] = replace(BUDGET, samples=len(found.rehearsal.samples)), []
    found.wander(found.rehearsal.samples)
    assert not drawn


def test_model_checkers_are_asked_for_words_where_random_runs_show_none(monkeypatch: pytest.MonkeyPatch) -> None:
    found = unprepared(compiled(model_of(small_spec_of(7))))
    monkeypatch.setattr(WordSearch, "_search", lambda *_: {})
    found.words.rehearse()
    assert not found.words.rehearsal.leading
    assert found.words.hard == {k for k in found.left if not found.words.rehearsal.helps(k)} != set()
    assert found.words.hard.isdisjoint(*found._parts())
    assert found._settle_hard()
    assert found.words.rehearsal.leading
    assert all(found.words.rehearsal.helps(k) for k in found.left)
    assert not found.words.hard
    assert found.left.keys() == {k for part in found._parts() for k in part} != set()


@pytest.mark.parametrize("seed", VARIED)
def test_verdicts_are_those_of_the_oracle(seed: int) -> None:
    spec = small_spec_of(seed)
    made = compiled(model_of(spec))
    graph = explored(seed)
    wanted, states = verdicts(graph), wrong(graph)
    encoding, found = judged(made)
    said = {NeverCutOff: "holds", ShownCutOff: "violated"}
    assert {key: said.get(type(each)) for key, each in found.items()} == {key: wanted[key] for key in found}, spec
    assert len(found) == 2 * len(made.model.requests)
    for key, verdict in found.items():
        if isinstance(verdict, ShownCutOff):
            state, reference = Reference(made.model).start(), Reference(made.model)
            for event in Concretizer(encoding).events(verdict.inputs):
                state, _ = reference.step(state, event)
            assert graph.number[Representatives(made.model).canonical(state).key()] in states[key], spec


WAITING_FOR_EACH_OTHER = """spec s;
poster p: int in 0 .. 99 = 0; poster q: int in 0 .. 99 = 0; poster ready: bool = false;
module m { request r(n: int in 0 .. 99) { check p != n; } request noise() { check q > 2; } }
module a { request left() { check ready; wait until active(b.right); } }
module b { request right() { wait until running(a.left); } }
"""


def test_a_run_to_where_there_is_no_way_has_no_step_too_many() -> None:
    """Its end is any state of the invariant that a proof from some state finds, not that state."""
    encoding, found = judged(compiled(model_of(WAITING_FOR_EACH_OTHER)))
    run = found["deadlock", "b.right"]
    assert isinstance(run, ShownCutOff)
    assert Concretizer(encoding).events(run.inputs) == (Ask("b.right"),)


ONE_WAY = """spec s;
poster low: bool = false;
module m {
    state at: {home, out} = home;
    request leave() { on ok set at = out; }
    request charge() { check at == home; }
}
"""


@pytest.mark.parametrize(
    ("premise", "verdict"),
    [("m.at == out and low", ShownCutOff), ("active(m.leave) and m.at == home", NeverCutOff)],
)
def test_where_some_home_state_has_no_way_the_states_of_the_premise_are_looked_at(
    premise: str, verdict: type[WayAnswer]
) -> None:
    """Home states are those in which nothing is active and `low` is false: no state of a premise is one."""
    made = compiled(model_of(ONE_WAY))
    encoding = Encoding(made, NO_PROPERTIES)
    text = f"for s; property p: from {premise} possible active(m.charge);"
    loaded = load_properties(Source("s.prop", text), made.model)
    assert loaded.properties is not None
    (question,) = questions_in(Questions(encoding).of(loaded.properties.properties[0].formula))
    assert isinstance(question, CutOff)
    found: list[WayAnswer] = []
    judge_ways(encoding, [question], known_runs(encoding), decide, lambda _, answer: found.append(answer), BUDGET)
    assert list(map(type, found)) == [verdict]


LOST = """spec s; poster q: int in 0 .. 9 = 0;
module m {
    request a() { wait until active(m.b); }
    request b() { check q == 3; wait until active(m.a); }
    request n(k: int in 0 .. 9) { check q == k; }
}
"""


def test_what_is_lost_from_the_start_is_shown_by_no_step() -> None:
    """Most questions are open where `m.a` waits. A proof that begins there speaks of no state before."""
    _, found = judged(compiled(model_of(LOST)))
    shown = {key: len(each.inputs) for key, each in found.items() if isinstance(each, ShownCutOff)}
    assert shown == {("lockout", "m.a"): 0, ("lockout", "m.b"): 0, ("deadlock", "m.a"): 1}
