"""What the start alone shows, lassos of what every run breaks, and contradictions: every engine shows the same run."""

import pytest

from exover.checks.questions.property import is_contradiction
from exover.checks.run import check_all
from exover.checks.schedule.engines import EngineName
from exover.checks.schedule.plan import CheckPlan
from exover.pipeline import load_properties
from exover.source import Source
from tests.support.agreement import every_engine
from tests.support.engines import model_of
from tests.support.needed import needs_nusmv
from tests.support.small import compiled

SPEC = "spec s; module m { request a(); } forbid f: not past(m.a) and not active(m.a) by kill m.a;"
PROPERTIES = """for s;
property never_so: never not past(m.a);
property always_so: always past(m.a);
property all_so: ctl AG past(m.a);
property first: ltl G not active(m.a);
property at_once: ltl G past(m.a);
property ever: ltl G not launched(m.a);
property from_here: from not past(m.a) possible asked(m.a) and ended(m.a);
property at_last: active(m.a) until past(m.a);
property from_anywhere: always possible asked(m.a) and ended(m.a);
"""
ENGINES = ("aig", "bdd", "z3", pytest.param("nusmv", marks=needs_nusmv))


@pytest.mark.parametrize("name", ENGINES)
def test_a_run_of_no_step_shows_what_is_false_at_the_start_and_ltl_has_a_lasso(name: EngineName) -> None:
    model = model_of(SPEC)
    properties = load_properties(Source("s.prop", PROPERTIES), model).properties
    assert properties is not None
    asked = {"consistency", "property"}
    outcome = check_all(compiled(model), lambda _: None, CheckPlan(asked, properties, every_engine((name,))))
    runs = {each.subject: each.trace for each in outcome.findings}
    assert {each.verdict for each in outcome.findings} == {"violated"}
    for subject in ("f", "never_so", "always_so", "all_so", "at_last", "from_here", "from_anywhere"):
        trace = runs[subject]
        assert trace is not None and trace.moments == ()
    for subject in ("first", "at_once", "ever"):
        trace = runs[subject]
        assert trace is not None and trace.loop_start is not None


STEPLESS = "assume always launched(m.a);"
"""After one launch there is no other."""
UNFAIR = "assume always active(m.a); assume never ended(m.a); assume fair reports;"


@pytest.mark.parametrize(
    ("name", "assumed", "steps"),
    [
        *((name, STEPLESS, 1) for name in ("aig", "bdd")),
        ("bdd", UNFAIR, 0),
        *(pytest.param("nusmv", assumed, steps, marks=needs_nusmv) for assumed, steps in ((STEPLESS, 1), (UNFAIR, 0))),
    ],
)
def test_a_run_leads_to_where_the_assumptions_contradict_each_other(name: EngineName, assumed: str, steps: int) -> None:
    model = model_of(SPEC)
    properties = load_properties(Source("s.prop", f"{PROPERTIES}{assumed}"), model).properties
    assert properties is not None
    outcome = check_all(compiled(model), lambda _: None, CheckPlan({"property"}, properties, every_engine((name,))))
    for each in outcome.findings:
        assert each.verdict == "violated" and is_contradiction(each.message)
        assert each.trace is not None and len(each.trace.moments) == steps
