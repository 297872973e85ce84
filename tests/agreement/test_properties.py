"""What the temporal engine says of random properties is what explicit search says, and its runs show it."""

from collections import Counter
from dataclasses import dataclass, field, replace
from functools import cache
from random import Random

import pytest

from exover.checks import property as property_check
from exover.checks import starvation, vacuity
from exover.checks.finding import Finding
from exover.checks.question import Check, Context, Question
from exover.checks.run import check_all
from exover.engines.bdd.analysis import Analysis
from exover.model.event import AbortWaiting, Args, Event, Launched, Rejected, Report
from exover.model.expression import Status
from exover.model.model import NOWHERE, Launch, Model
from exover.model.property import (
    NO_PROPERTIES,
    Assumption,
    Atom,
    Conjunction,
    Form,
    Formula,
    Happened,
    Negation,
    Properties,
    Property,
    SomeAlways,
    SomeUntil,
    Until,
    all_always,
    all_finally,
    all_until,
    always,
    atoms,
    finally_,
    formulas,
    implies,
    some_finally,
)
from exover.model.semantics import Reference, Step
from exover.model.state import State
from exover.ocrd.compile import Compiled
from tests.support import explicit_ctl, explicit_ltl
from tests.support.engines import model_of
from tests.support.formulas import Formulas
from tests.support.moments import Moment, Moments, looked_at, moments_of
from tests.support.oracle import Edge, Graph, explore, verdicts
from tests.support.representatives import Representatives
from tests.support.small import compiled, small_spec_of
from tests.support.words import Word, word_of

MOST_STATES, MOST_STEPS = 300, 1500
SEEDS = (
    *(3, 6, 8, 16, 17, 26, 29, 36, 38, 39, 41, 51, 56, 60, 62, 67, 73, 103, 106, 107, 109, 111, 119, 123, 130, 246),
    *(253, 258, 261, 269, 275, 276),
)
WAITING = (0, 3, 4, 7, 8, 14, 15, 16, 17, 23, 26, 27, 28, 29)
"""Seeds of specs small enough to go through them moment by moment; in the latter some request can wait."""


@dataclass(frozen=True)
class Case:
    """A spec with properties, its moments one by one, and what the checks say."""

    spec: str
    made: Compiled
    properties: Properties
    moments: Moments
    found: dict[tuple[str, str], Finding]
    linear: dict[str, Formula | None]
    """By property the formula of LTL that says the same of one run."""

    @property
    def contradictory(self) -> bool:
        """Whether the assumptions leave some moment without a step, or no fair run at all."""
        return bool(self.moments.dead) or 0 not in explicit_ctl.fair(self.moments)

    @property
    def asked(self) -> list[Atom | Happened]:
        """What the formulas ask of moments."""
        return [atom for formula in formulas(self.properties) for atom in atoms(formula)]

    def word(self, finding: Finding) -> Word:
        """Return the run of a finding as the moments that it has."""
        assert finding.trace is not None
        return word_of(self.made.model, finding.trace, list(formulas(self.properties)))


def paired(of: Formulas) -> list[tuple[Property, Formula | None]]:
    """Return a property of each form of the language, with the formula of LTL that says the same of one run."""
    p, q = of.condition(1), of.condition(1)
    first = Until(Negation(p), Conjunction((q, Negation(p))))
    forms: list[tuple[Form, Formula, Formula | None]] = [
        ("never", Negation(some_finally(p)), always(Negation(p))),
        ("always", all_always(p), always(p)),
        ("possible", some_finally(p), None),
        ("always possible", all_always(some_finally(p)), None),
        ("from possible", all_always(implies(p, some_finally(q))), None),
        ("leads to", all_always(implies(p, all_finally(q))), always(implies(p, finally_(q)))),
        ("precedes", Negation(SomeUntil(Negation(p), Conjunction((q, Negation(p))))), Negation(first)),
        ("until", all_until(p, q), Until(p, q)),
        ("ctl", all_finally(p), finally_(p)),
    ]
    chosen = of.random.sample(forms, 4)
    return [(Property(form, None, form, formula, q, NOWHERE), linear) for form, formula, linear in chosen]


@cache
def case_of(seed: int) -> Case:
    """Return the case of this seed."""
    spec = small_spec_of(seed)
    made = compiled(model_of(spec))
    of = Formulas(Random(seed), made.model)
    properties = of.properties(2, of.random.randint(1, 3))
    pairs = paired(of)
    properties = replace(properties, properties=(*properties.properties, *(each for each, _ in pairs)))
    moments = moments_of(made.model, properties, MOST_STATES, MOST_STEPS)
    found = decided(made, properties, (property_check.CHECK, vacuity.CHECK))
    return Case(spec, made, properties, moments, found, {each.name: linear for each, linear in pairs})


def decided(made: Compiled, properties: Properties, checks: tuple[Check, ...]) -> dict[tuple[str, str], Finding]:
    """Return what these checks say, by check and subject."""
    context = Context(made, Analysis(made, Reference(made.model), lambda what: None, properties))
    return {
        (check.name, subject): check.decide(context, Question(check.name, check.severity, subject, location))
        for check in checks
        for subject, location in check.subjects(made.model, properties)
    }


@pytest.fixture(scope="module", params=SEEDS)
def case(request: pytest.FixtureRequest) -> Case:
    """One case after the other."""
    return case_of(request.param)


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


@dataclass(frozen=True)
class Leaving(Reference):
    """The reference interpreter, which notes at which requests what stood in the waiting place does so no longer."""

    gone: set[str] = field(default_factory=set)

    def left(self, state: State, event: Event) -> set[str]:
        """Return these requests for one step."""
        self.gone.clear()
        self.step(state, event)
        return self.gone | ({event.request} if isinstance(event, AbortWaiting) else set())

    def _ask(self, step: Step, name: str, args: Args, required: Launch | None = None) -> Step:
        after = super()._ask(step, name, args, required)
        for action in after.actions[len(step.actions) :]:
            refused = isinstance(action, Rejected) and action.request == name and action.rule != "superseded"
            if isinstance(action, Launched | Rejected) and not refused:
                self.gone.add(action.request)
        return after

    def _settle(self, step: Step) -> Step:
        after = super()._settle(step)
        self.gone.update(a.request for a in after.actions[len(step.actions) :] if isinstance(a, Launched | Rejected))
        return after


def starved(graph: Graph, request: str) -> bool:
    """Return whether on some fair run one and the same request waits for ever, by explicit search."""
    leaving = Leaving(graph.model)
    number: dict[Moment, int] = {}
    found = Moments(graph.model, graph.states, fair=True)

    def moment(state: int, reported: frozenset[tuple[str, int]]) -> int:
        made = Moment(state, frozenset(), reported)
        if made not in number:
            number[made] = len(number)
            found.moments.append(made)
            found.after.append([])
        return number[made]

    out: dict[int, list[tuple[int, frozenset[tuple[str, int]]]]] = {}
    for edge in graph.edges:
        stays = graph.states[edge.source].places[request] and graph.states[edge.target].places[request]
        if stays and request not in leaving.left(graph.states[edge.source], edge.event):
            event = edge.event
            reported = frozenset({(event.request, event.slot)}) if isinstance(event, Report) else frozenset()
            out.setdefault(edge.source, []).append((edge.target, reported))
    for state in range(len(graph.states)):
        moment(state, frozenset())
    for source in found.moments:
        found.after[number[source]] = [moment(*step) for step in out.get(source.state, [])]
    waiting = Atom(Status("waiting", request))
    return bool(explicit_ctl.satisfying(found, SomeAlways(waiting)))


@pytest.mark.parametrize("seed", WAITING)
def test_starvation_is_what_explicit_search_finds(seed: int) -> None:
    spec = small_spec_of(seed)
    made = compiled(model_of(spec))
    graph = explore(made.model, MOST_STATES, 2 * MOST_STEPS)
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
    findings = check_all(made, lambda what: None, properties=Properties((), assumptions)).findings
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
