"""Reals that change and are compared: arguments with posters, posters with each other."""

import pytest

from exover.checks.finding import Finding
from exover.library import NO_PROPERTIES, check, loads
from exover.loop.claim import APPROXIMATE
from exover.pipeline import build, load
from exover.source import Source
from tests.support.diagrams import check_by_diagrams

LIMITED = """spec limited;
poster limit: real in 0 .. 2 = 1;
module base {
    request go(v: real in 0 .. 1.5) { check allowed: v <= limit; fail fast: when v > limit; }
    request creep(v: real in 0 .. 1.5) { wait slow: until v < limit; interrupts self; }
}
"""
PAIR = """spec pair;
poster near: real in 0 .. 2 = 0;
poster far: real in 0 .. 2 = 1;
module m { request go() { check ahead: near < far; fail close: when near >= far; } }
"""
ENDS = {
    "the greatest": "wait until v < limit;",
    "the least": "wait until limit < v;",
    "beside a constant": "wait until v < limit and limit < 1;",
    "beside another": "wait until v < limit and limit < w;",
}
"""Waits that no reading ends for some arguments of 0 .. 2, though both sides of each comparison lie in one interval."""


def findings_of(text: str) -> dict[tuple[str, str], Finding]:
    model = load(Source("s.exo", text)).model
    assert model is not None
    found = check_by_diagrams(build(model).compiled).findings
    return {(finding.check, finding.subject): finding for finding in found}


@pytest.mark.parametrize("text", [LIMITED, PAIR], ids=["limited", "pair"])
def test_all_holds_where_what_may_break_is_killed(text: str) -> None:
    found = [finding for finding in findings_of(text).values() if finding.verdict != "holds"]
    violated = {finding.check for finding in found if finding.verdict == "violated"}
    assert violated <= {"starvation"}, "nothing says that a limit is ever observed"
    assert {finding.message for finding in found if finding.verdict == "unknown"} <= {APPROXIMATE}
    assert {f.check for f in check(loads(text), NO_PROPERTIES) if f.verdict != "holds"} <= {"starvation"}


@pytest.mark.parametrize("wait", ENDS.values(), ids=ENDS)
def test_a_reading_that_would_end_a_wait_is_not_taken_for_granted(wait: str) -> None:
    text = (
        "spec s; poster limit: real in 0 .. 2 = 1; module m { request go(v: real in 0 .. 2, w: real in 0 .. 2) { %s } }"
    )
    by_diagrams, found = findings_of(text % wait), check(loads(text % wait), NO_PROPERTIES)
    for name in ("deadlock", "lockout"):
        assert by_diagrams[name, "m.go"].message == APPROXIMATE
        assert [finding.verdict for finding in found.of(name)] == ["violated"]


def test_a_guard_that_a_rule_always_beats_is_dead() -> None:
    check, fail = "check allowed: v <= limit;", "fail fast: when v > limit;"
    swapped = LIMITED.replace(f"{check} {fail}", f"{fail} {check}")
    assert findings_of(swapped)["rule-use", "base.go.allowed"].verdict == "violated"


def test_what_waits_for_a_comparison_is_reached_by_a_concrete_run() -> None:
    text = LIMITED.replace("wait slow: until v < limit;", "wait slow: until v == limit;")
    finding = findings_of(text)["reachability", "base.creep"]
    assert finding.verdict == "holds"
    assert finding.trace is not None
