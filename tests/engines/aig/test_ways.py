"""Whether there is a way from everywhere is what plain enumeration finds."""

from collections.abc import Callable, Mapping

import pytest

from exover.checks import deadlock, lockout
from exover.engines.aig import pdr, ways
from exover.engines.aig.answer import Answer
from exover.engines.aig.concretize import Concretizer
from exover.engines.aig.encoder import Encoding
from exover.engines.aig.graph import Circuit
from exover.engines.aig.implicants import StatesOfKind
from exover.engines.aig.questions import CutOff, Questions, questions_in
from exover.engines.aig.ways import NeverCutOff, ShownCutOff, WayAnswer, Ways, WaysBudget, judge_ways
from exover.model.property import NO_PROPERTIES
from exover.model.semantics import Reference
from exover.ocrd.compile import Compiled
from tests.engines.aig.runs import known_runs
from tests.support.engines import model_of
from tests.support.oracle import explore, verdicts, wrong
from tests.support.representatives import Representatives
from tests.support.small import compiled, small_spec_of

SEEDS = (0, 4, 7, 8, 14, 15, 23, 24, 26, 27, 28, 30, 32, 37, 40)
BUDGET = WaysBudget(rounds=3)
CHECKS = (deadlock.CHECK, lockout.CHECK)


def decide(circuit: Circuit, say: Callable[[int, Answer], None], stop: Callable[[], bool]) -> None:
    pdr.decide(circuit, say, stop=stop, budget=20_000_000)


def judged(made: Compiled) -> tuple[Encoding, dict[tuple[str, str], WayAnswer]]:
    """Return what is said of deadlock and lockout of each request."""
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
    keys = list(asked)
    found: dict[tuple[str, str], WayAnswer] = {}

    def say(index: int, verdict: WayAnswer) -> None:
        assert keys[index] not in found
        found[keys[index]] = verdict

    judge_ways(encoding, list(asked.values()), known_runs(encoding), decide, say, BUDGET)
    return encoding, found


def test_questions_with_few_steps_are_asked_first_and_all_are_answered_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each that lets the graph grow is the last of its part."""
    made = compiled(model_of(small_spec_of(SEEDS[2])))
    _, together = judged(made)
    reach, turns = Ways._reach, list[list[int]]()

    def noted(self: Ways, part: Mapping[int, StatesOfKind]) -> bool:
        turns.append([sum(map(len, self.rehearsal.chosen(index))) for index in part])
        return reach(self, part)

    monkeypatch.setattr(Ways, "_reach", noted)
    monkeypatch.setattr(ways, "GROWTH", 0)
    _, found = judged(made)
    assert {key: type(each) for key, each in found.items()} == {key: type(each) for key, each in together.items()}
    assert len(turns) > 2
    assert turns[0] < turns[1]
    assert all(turn == sorted(turn) for turn in turns)


@pytest.mark.parametrize("seed", SEEDS)
def test_verdicts_are_those_of_the_oracle(seed: int) -> None:
    spec = small_spec_of(seed)
    made = compiled(model_of(spec))
    graph = explore(made.model, 1500, 6000)
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
