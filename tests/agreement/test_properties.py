"""What the temporal engine says of random properties is what explicit search says, and its runs show it."""

from collections import Counter
from dataclasses import replace
from random import Random

import pytest

from exover.checks.questions import starvation
from exover.model.model import NOWHERE, Model
from exover.model.property import (
    NO_PROPERTIES,
    Assumption,
    Negation,
    Properties,
    SomeUntil,
    atoms,
)
from tests.support import explicit_ctl, explicit_ltl
from tests.support.constructs import seldom
from tests.support.diagrams import check_by_diagrams
from tests.support.engines import model_of
from tests.support.formulas import Formulas
from tests.support.moments import looked_at
from tests.support.oracle import Edge, Graph, explore, verdicts
from tests.support.property_cases import (
    MANY,
    MOST_STATES,
    MOST_STEPS,
    SEEDS,
    WAITING,
    Case,
    asked,
    case_of,
    decided,
)
from tests.support.representatives import Representatives
from tests.support.small import compiled, explored, small_spec_of
from tests.support.starving import starved
from tests.support.words import Word, word_of


@pytest.fixture(scope="module", params=SEEDS)
def case(request: pytest.FixtureRequest) -> Case:
    """One case after the other."""
    return case_of(request.param)


def test_the_cases_have_every_construct() -> None:
    models = {seed: model_of(small_spec_of(seed)) for seed in MANY}
    few, many = ([(models[seed], asked(seed, models[seed])[0]) for seed in seeds] for seeds in (SEEDS, MANY))
    assert not seldom(few, many, 2)


def test_every_verdict_is_that_of_explicit_search(case: Case) -> None:
    for each in case.properties.properties:
        logic = explicit_ltl if each.form == "ltl" else explicit_ctl
        wanted = not case.contradictory and logic.holds(case.moments, each.formula)
        told = f"{case.spec}\n{case.properties}\n{each}"
        assert case.found["property", each.name].verdict == ("holds" if wanted else "violated"), told
        if each.premise is not None:
            possible = explicit_ctl.can_be(case.moments, each.premise)
            assert case.found["vacuity", each.name].verdict == ("holds" if possible else "violated"), told


def test_every_run_is_one_that_the_assumptions_leave(case: Case) -> None:
    for finding in case.found.values():
        if finding.trace is not None:
            word = case.word(finding)
            steps = set(range(1, len(word.states)))
            assert all(steps <= word.where(each.formula) for each in case.properties.assumptions), case.spec
            if word.back is not None and case.properties.fair:
                assert word.is_fair(), f"{case.spec}\n{finding}"


def test_every_run_shows_what_its_finding_says(case: Case) -> None:
    for each in case.properties.properties:
        finding = case.found["property", each.name]
        if finding.trace is None or case.contradictory:
            continue
        word, told = case.word(finding), f"{case.spec}\n{each}\n{finding}"
        if finding.verdict == "holds":
            match each.formula:
                case SomeUntil(_, right) if each.form == "possible":
                    assert len(word.states) - 1 in word.where(right), told
        elif each.form == "ltl":
            assert finding.trace.loop_start is not None
            assert not word.satisfies(each.formula), told
        elif (formula := case.linear.get(each.name)) is not None:
            assert not word.satisfies(formula), told


def test_contradictions_are_shown_by_a_run_into_them(case: Case) -> None:
    if not case.contradictory:
        return
    for each in case.properties.properties:
        finding = case.found["property", each.name]
        assert "contradict" in finding.message
        assert finding.trace is not None
        end = case.word(finding).states[-1]
        dead = {case.moments.moments[number].state for number in case.moments.dead}
        values = Representatives(looked_at(case.made.model, case.asked))
        assert not dead or any(values.canonical(end).key() == case.moments.states[k].key() for k in dead)


def test_the_cases_have_verdicts_of_every_kind() -> None:
    """Else the agreement above would say little."""
    kinds: Counter[object] = Counter()
    for case in map(case_of, SEEDS):
        kinds["contradictory", case.contradictory] += 1
        for each in case.properties.properties if not case.contradictory else ():
            found = case.found["property", each.name]
            kinds[each.form, found.verdict] += 1
            kinds[case.properties.fair, bool(case.properties.assumptions), found.verdict] += 1
            kinds["lasso", found.trace is not None and found.trace.loop_start is not None] += 1
    forms = ("never", "always", "possible", "always possible", "from possible", "leads to", "precedes", "until")
    wanted: list[object] = [(form, verdict) for form in (*forms, "ctl", "ltl") for verdict in ("holds", "violated")]
    wanted += [("contradictory", True), ("contradictory", False), ("lasso", True), ("lasso", False)]
    wanted += [(fair, some, said) for fair in (True, False) for some in (True, False) for said in ("holds", "violated")]
    assert [kind for kind in wanted if not kinds[kind]] == []


# ---- starvation ----


@pytest.mark.parametrize("seed", WAITING)
def test_starvation_is_what_explicit_search_finds(seed: int) -> None:
    spec, graph = small_spec_of(seed), explored(seed)
    made = compiled(graph.model)
    findings = decided(made, NO_PROPERTIES, (starvation.CHECK,))
    assert any(finding.method != "tables" for finding in findings.values()), "some request can wait"
    for (_, name), finding in findings.items():
        wanted = starved(graph, name)
        assert finding.verdict == ("violated" if wanted else "holds"), f"{spec}\n{name}"
        if finding.trace is not None:
            word = word_of(made.model, finding.trace, [])
            assert word.is_fair(), f"{spec}\n{finding}"
            assert all(word.states[k].places[name] for k in range(word.back or 0, len(word.states)))


# ---- the other checks under assumptions ----


@pytest.mark.parametrize("seed", SEEDS)
def test_other_checks_look_only_at_what_is_assumed(seed: int) -> None:
    spec = small_spec_of(seed)
    made = compiled(model_of(spec))
    of = Formulas(Random(seed), made.model, steps=False)
    assumptions = tuple(Assumption(Negation(of.condition(1)), NOWHERE) for _ in range(2))
    conditions = [atom for each in assumptions for atom in atoms(each.formula)]
    graph = explore(looked_at(made.model, conditions), 2 * MOST_STATES, 4 * MOST_STEPS)
    word = Word(made.model, graph.states, [frozenset()] * len(graph.states), [], None)
    allowed = set.intersection(*(word.where(each.formula) for each in assumptions))
    findings = check_by_diagrams(made, properties=Properties((), assumptions)).findings
    wanted = verdicts(assumed(graph, allowed, made.model))
    left = ("safety", "completeness", "reachability", "deadlock", "obligation", "rule-use", "lockout")
    found = {(each.check, each.subject): each.verdict for each in findings if each.check in left}
    assert {key: wanted[key] for key in found} == found, f"{spec}\n{assumptions}"


def assumed(graph: Graph, allowed: set[int], model: Model) -> Graph:
    """Return what is left of a graph if only steps into `allowed` are taken; its states keep their order."""
    after: dict[int, list[Edge]] = {}
    for edge in graph.edges:
        if edge.target in allowed:
            after.setdefault(edge.source, []).append(edge)
    kept, edges = [0], []
    number = {0: 0}
    for source in kept:
        for edge in after.get(source, []):
            if edge.target not in number:
                number[edge.target] = len(kept)
                kept.append(edge.target)
            edges.append(replace(edge, source=number[source], target=number[edge.target]))
    return Graph(model, [graph.states[state] for state in kept], edges)
