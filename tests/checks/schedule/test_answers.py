"""Answers that were given before: which questions are asked anew, and that nobody can tell the difference."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from random import Random
from typing import Any

import pytest

from exover.checks.finding import Finding
from exover.checks.run import CheckOutcome
from exover.checks.schedule.tasks import TaskRunner
from exover.model.property import Properties
from exover.model.wire import Json
from exover.ocrd.compile import Compiled
from exover.pipeline import build, load, load_properties
from exover.source import Source
from tests.support.diagrams import check_by_diagrams
from tests.support.edits import edited
from tests.support.engines import model_of
from tests.support.formulas import Formulas
from tests.support.small import compiled, small_spec_of

SPEC = """spec s;
poster p: int in 0 .. 9 = 0 else 9;
module m { request a() { check low: p < 5; } request b(); request c(); }
mutex ab: m.a, m.b by wait because "one of them";
"""
PROPERTIES = """for s;
property apart "as it should": never (active(m.a) and active(m.b));
property free: never (active(m.b) and active(m.c));
property ends: always (waiting(m.b) leads to not waiting(m.b));
property high: always (p > 5 implies not asked(m.a) or not launched(m.a));
"""
Key = tuple[str, str]


@dataclass
class Kept:
    """A store in memory, which holds JSON as one on disk would."""

    loops: dict[str, str] = field(default_factory=dict)

    def find(self, loop: str) -> Mapping[str, Any]:
        found: dict[str, Any] = json.loads(self.loops.get(loop, "{}"))
        return found

    def keep(self, loop: str, answers: Mapping[str, Json]) -> None:
        self.loops[loop] = json.dumps({**self.find(loop), **answers})

    def change(self, edit: Callable[[Any], Any]) -> None:
        """Put something else in the place of each answer that has a verdict."""
        for loop, text in self.loops.items():
            known = json.loads(text)
            changed = {key: edit(each) if "verdict" in each else each for key, each in known.items()}
            self.loops[loop] = json.dumps(changed)


@pytest.fixture
def put(monkeypatch: pytest.MonkeyPatch) -> list[Key]:
    """The questions that are put to diagrams, as they come."""
    found: list[Key] = []
    decided = TaskRunner._decided

    def noted(runner: TaskRunner, number: int, *rest: Any) -> Finding:
        question = runner.questions[number][1]
        found.append((question.check, question.subject))
        return decided(runner, number, *rest)

    monkeypatch.setattr(TaskRunner, "_decided", noted)
    return found


def asked(made: Compiled, properties: Properties, store: Kept) -> CheckOutcome:
    outcome = check_by_diagrams(made, properties=properties, store=store)
    assert outcome.settled
    outcome.settled.keep(replayed=True)
    return outcome


def plain(outcome: CheckOutcome) -> tuple[tuple[Finding, ...], int | None]:
    return tuple(replace(finding, seconds=0.0) for finding in outcome.findings), outcome.state_bits


def read(spec: str, properties: str) -> tuple[Compiled, Properties]:
    model = load(Source("s.exo", spec)).model
    assert model is not None
    found = load_properties(Source("s.prop", properties), model).properties
    assert found is not None
    return build(model).compiled, found


def after(spec: str, properties: str, put: list[Key], store: Kept) -> set[Key]:
    """Return what is asked of a spec with a store; what is found is what is found without."""
    made = read(spec, properties)
    put.clear()
    found = asked(*made, store)
    anew = set(put)
    assert plain(found) == plain(check_by_diagrams(made[0], properties=made[1]))
    return anew


@pytest.fixture
def store(put: list[Key]) -> Kept:
    found = Kept()
    assert len(after(SPEC, PROPERTIES, put, found)) > 30
    return found


@pytest.mark.parametrize(
    ("spec", "properties"),
    [
        (SPEC, PROPERTIES),
        ("// a comment\n\n" + SPEC.replace("; ", ";\n\n    "), PROPERTIES),
        (SPEC.replace("one of them", "not both"), PROPERTIES),
        (SPEC, PROPERTIES.replace("as it should", "as ever").replace("property", "\n// of these\nproperty")),
        (SPEC, "for s;\n" + "\n".join(reversed(PROPERTIES.splitlines()[1:]))),
    ],
    ids=["nothing", "layout", "because", "comments", "order"],
)
def test_what_means_the_same_is_asked_nothing(spec: str, properties: str, put: list[Key], store: Kept) -> None:
    assert after(spec, properties, put, store) == set()


@pytest.mark.parametrize(
    ("properties", "anew"),
    [
        (PROPERTIES + "property more: possible (active(m.c));", {("property", "more")}),
        (PROPERTIES.replace("property free", "property loose"), {("property", "loose"), ("vacuity", "loose")}),
        (PROPERTIES.replace("(active(m.b) and", "(waiting(m.b) and"), {("property", "free"), ("vacuity", "free")}),
        (PROPERTIES.replace("and active(m.c)", "and running(m.c)"), {("property", "free")}),
        (PROPERTIES.replace("p > 5", "p > 6"), {("property", "high"), ("vacuity", "high")}),
        (PROPERTIES.replace("property free: never (active(m.b) and active(m.c));\n", ""), set()),
    ],
    ids=["added", "renamed", "changed", "conclusion", "bound", "removed"],
)
def test_a_property_is_asked_if_it_has_changed(properties: str, anew: set[Key], put: list[Key], store: Kept) -> None:
    assert after(SPEC, properties, put, store) == anew


@pytest.mark.parametrize("assumption", ["assume fair reports;", "assume always (p < 9);"])
def test_an_assumption_changes_all_that_is_asked_of_runs(assumption: str, put: list[Key], store: Kept) -> None:
    anew = after(SPEC, PROPERTIES + assumption, put, store)
    assert {check for check, _ in anew}.isdisjoint({"tables", "consistency"})
    assert {("safety", "ab"), ("property", "apart"), ("lockout", "m.a")} <= anew
    assert after(SPEC, PROPERTIES, put, store) == set()


def test_a_rule_changes_all(put: list[Key], store: Kept) -> None:
    anew = after(SPEC.replace("p < 5", "p < 6"), PROPERTIES, put, store)
    assert len(anew) > 30


@pytest.mark.parametrize(
    "edit",
    [
        lambda kept: None,
        lambda kept: {**kept, "verdict": "unknown"},
        lambda kept: {**kept, "message": 1},
        lambda kept: {**kept, "events": 1},
        lambda kept: {**kept, "events": [{"ask": "m.d"}]},
        lambda kept: {**kept, "events": [{"ask": "m.c"}], "answers": kept["answers"] or ""},
        lambda kept: {**kept, "events": [3], "answers": ""},
        lambda kept: {**kept, "events": [], "answers": ""},
        lambda kept: {**kept, "events": [{"ask": "m.a"}], "loop_start": 0, "answers": ""},
    ],
)
def test_what_cannot_be_or_shows_no_run_is_asked_anew(edit: Callable[[Any], Any], put: list[Key], store: Kept) -> None:
    store.change(edit)
    assert len(after(SPEC, PROPERTIES, put, store)) > 30


def test_a_run_that_is_answered_otherwise_is_not_believed(put: list[Key], store: Kept) -> None:
    store.change(lambda kept: {**kept, "answers": "0" * 64} if kept["events"] else kept)
    assert ("property", "free") in after(SPEC, PROPERTIES, put, store)


def test_what_was_not_shown_on_c_is_not_kept(put: list[Key]) -> None:
    store = Kept()
    made, properties = read(SPEC, PROPERTIES)
    outcome = check_by_diagrams(made, properties=properties, store=store)
    assert outcome.settled
    outcome.settled.keep(replayed=False)
    broken = {(each.check, each.subject) for each in outcome.findings if each.verdict == "violated" and each.trace}
    assert ("property", "free") in broken
    assert after(SPEC, PROPERTIES, put, store) == broken


@pytest.mark.parametrize("seed", [4, 7, 42, 112])
def test_verdicts_are_those_without_a_store_and_what_is_as_it_was_is_told_so(seed: int) -> None:
    """What other properties tell apart may have an answer shown by another run, but not be another answer."""
    random, store = Random(seed), Kept()
    first = model_of(small_spec_of(seed))
    before: Properties = Formulas(random, first).properties(1, 2)
    versions = [(first, before)]
    for _ in range(2):
        model = edited(first, random) if random.random() < 0.5 else first
        more = Formulas(random, model).properties(2, 2)
        versions.append((model, replace(before, properties=(before.properties[0], *more.properties[1:]))))
    for model, properties in (*versions, versions[0]):
        made = compiled(model)
        warm, cold = asked(made, properties, store), check_by_diagrams(made, properties=properties)
        assert [each.verdict for each in warm.findings] == [each.verdict for each in cold.findings]
        assert warm.settled
        if len(warm.settled.answers.recalled) in (0, len(warm.findings)):
            assert plain(warm) == plain(cold)
    assert len(warm.settled.answers.recalled) == len(warm.findings)
