"""A launch rule is in use as soon as it is tried, whatever comes of that; every engine and plain enumeration say so."""

import pytest

from exover.checks.run import check_all
from exover.checks.schedule.engines import Engines
from exover.checks.schedule.plan import CheckPlan
from exover.pipeline import load_properties
from exover.source import Source
from tests.support.agreement import every_engine
from tests.support.engines import model_of
from tests.support.needed import NO_NUSMV
from tests.support.oracle import explore, verdicts
from tests.support.small import compiled

FENCE = """
spec fence;
poster out: bool = false;
module nav { request orbit(); request hold() { CLAUSE } }
launch stop: nav.hold() when out and running(nav.orbit) and EXTRA;
"""
"""Where an orbit runs, the launch is tried; nothing starts at once, for the orbit has to stop first."""


@pytest.mark.parametrize(
    ("clause", "extra", "verdict"),
    [
        pytest.param("interrupts nav.orbit;", "out", "holds", id="its way is cleared, and that ends the condition"),
        pytest.param("check not active(nav.orbit);", "out", "holds", id="it is refused"),
        pytest.param("wait until not active(nav.orbit);", "out", "holds", id="it waits"),
        pytest.param("interrupts nav.orbit;", "not out", "violated", id="it is never due"),
    ],
)
def test_a_launch_rule_that_is_tried_is_in_use(clause: str, extra: str, verdict: str) -> None:
    made = compiled(model_of(FENCE.replace("CLAUSE", clause).replace("EXTRA", extra)))
    assert verdicts(explore(made.model, 1000, 10_000))["rule-use", "stop"] == verdict
    engines = Engines(("bdd", "z3"), compared=True) if NO_NUSMV else every_engine()
    findings = check_all(made, lambda what: None, CheckPlan({"rule-use"}, engines=engines)).findings
    (found,) = (each for each in findings if (each.check, each.subject) == ("rule-use", "stop"))
    assert found.verdict == verdict
    assert found.engine.split("+") == list(engines.names)


def test_a_refusal_that_is_not_answered_again_is_one() -> None:
    made = compiled(
        model_of("""spec s; poster low: bool = false;
        module m { request home() { check not low; } }
        launch go: m.home() when low;""")
    )
    text = "for s; property refused: always (low and not active(m.home) implies rejected(m.home));"
    properties = load_properties(Source("s.prop", text), made.model).properties
    assert properties is not None
    engines = Engines(("bdd", "z3"), compared=True) if NO_NUSMV else every_engine()
    findings = check_all(made, lambda what: None, CheckPlan(properties=properties, engines=engines)).findings
    assert {each.subject: each.verdict for each in findings if each.check == "property"}["refused"] == "holds"
