"""What the checks find by decision diagrams is what plain enumeration finds, and every trace shows what it says."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import pytest

from exover.checks.finding import Finding
from exover.model.event import Launched, Violated
from exover.model.model import Model
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import Trace
from exover.ocrd.compile import Compiled
from exover.run.native import NativeEngine
from tests.support.constructs import seldom
from tests.support.engines import model_of
from tests.support.oracle import Graph, verdicts, wrong
from tests.support.representatives import Representatives
from tests.support.small import ENUMERABLE, VARIED, compiled, differences, explored, findings_of, small_spec_of
from tests.support.watch import Watched, watched

SEEDS = (4, 14, 24, 27, 30, 69, 71, 90, 95, 96, 98, 101, 109, 112, 130)
"""Those that are looked at: every construct and every verdict of all is in two of them."""
IN_C = VARIED[::2]
"""Whose traces are replayed on the compiled C as well: compiling takes a second."""


@dataclass(frozen=True)
class Case:
    """A spec, all its states and steps, and what the checks say of it."""

    spec: str
    made: Compiled
    graph: Graph
    findings: tuple[Finding, ...]


@cache
def case_of(seed: int) -> Case:
    spec = small_spec_of(seed)
    made = compiled(model_of(spec))
    return Case(spec, made, explored(seed), findings_of(made))


@pytest.fixture(scope="module", params=SEEDS)
def case(request: pytest.FixtureRequest) -> Case:
    """One case after the other."""
    return case_of(request.param)


def test_every_verdict_is_that_of_the_oracle(case: Case) -> None:
    different = differences(case.graph, case.findings)
    messages = {
        (each.check, each.subject): each.message for each in case.findings if (each.check, each.subject) in different
    }
    assert not different, f"{case.spec}\noracle, checks: {different}\n{messages}"


def test_every_violation_that_a_run_can_show_has_one(case: Case) -> None:
    bare = {each.check for each in case.findings if each.verdict == "violated" and each.trace is None}
    assert bare <= {"reachability", "rule-use", "redundancy", "idle-guard"}, case.spec


def test_every_trace_shows_what_its_finding_says(case: Case) -> None:
    states, model = wrong(case.graph), case.made.model
    for finding in case.findings:
        if finding.trace is None:
            continue
        end = last_state(model, finding.trace)
        actions = finding.trace.moments[-1].actions if finding.trace.moments else ()
        told = f"{case.spec}\n{finding}"
        match finding.check:
            case "consistency":
                assert not finding.trace.moments, told
            case "completeness":
                assert any(isinstance(action, Violated) and action.rule == finding.subject for action in actions), told
            case "reachability":
                assert any(isinstance(action, Launched) and action.request == finding.subject for action in actions)
            case "redundancy":
                assert finding.subject in changed_in(finding.trace, watched(model)), told
            case check:
                assert finding.trace.moments or check not in ("safety", "obligation"), told
                key = Representatives(model).canonical(end).key()
                assert case.graph.number[key] in states[check, finding.subject], told


def changed_in(trace: Trace, watch: Watched) -> set[str]:
    """Return the rules without which something would have been decided otherwise in a run."""
    state = watch.start()
    for event in trace.events:
        state, _ = watch.step(state, event)
    return watch.changed


def last_state(model: Model, trace: Trace) -> State:
    """Return the state in which a trace ends, after it was found to be a run of the reference interpreter."""
    reference = Reference(model)
    state = reference.start()
    for moment in trace.moments:
        state, actions = reference.step(state, moment.event)
        assert actions == moment.actions
    return state


@pytest.mark.parametrize("seed", IN_C)
def test_every_trace_is_a_run_of_the_compiled_c(seed: int) -> None:
    case = case_of(seed)
    traces = [finding.trace for finding in case.findings if finding.trace]
    with NativeEngine(case.made.model, case.made.tables) as engine:
        for trace in traces:
            answers = tuple(moment.actions for moment in trace.moments)
            assert engine.replay(trace.events) == answers, f"{case.spec}\n{trace}"


def test_the_specs_have_every_construct() -> None:
    few, some, many = ([(model_of(small_spec_of(seed)),) for seed in seeds] for seeds in (VARIED, SEEDS, ENUMERABLE))
    assert not seldom(some, many, 2)
    assert not seldom(few, many, 1)


@pytest.mark.parametrize("seeds", [SEEDS, VARIED])
def test_the_specs_have_verdicts_of_every_kind(seeds: Sequence[int]) -> None:
    """Else the agreement above would say little."""
    kinds: Counter[tuple[str, str]] = Counter()
    for seed in seeds:
        kinds.update((check, verdict) for (check, _), verdict in verdicts(case_of(seed).graph).items())
    checks = ("consistency", "safety", "completeness", "reachability", "deadlock", "obligation", "rule-use", "lockout")
    checks += ("redundancy", "idle-guard")
    missing = [(check, verdict) for check in checks for verdict in ("holds", "violated") if not kinds[check, verdict]]
    assert not missing
