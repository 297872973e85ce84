"""A rule that a step breaks and no remedy restores: the finding says what to write."""

import pytest

from exover.checks.causes.remedy import advice as told
from exover.model.event import Ask, Observe, Violated
from exover.model.semantics import Reference
from tests.support.diagrams import check_by_diagrams
from tests.support.engines import model_of
from tests.support.small import compiled

WORLD = """spec s; poster p: bool = false; resource power: 9;
module m { request a(x: int in 0 .. 3) { uses power 2; } request b(); request c() { uses power 2; } }
resource load: 3 by wait;
module n { request up() { uses load 1; } request cue() { uses load 2; }
request down() instances 2 { uses load 1; } } """
ADVICE = [
    ("forbid f: p and active(m.a);", "write `by reject or kill m.a`"),
    ("forbid f: p and active(m.a) by wait;", "write `by wait or kill m.a`"),
    ("forbid f: p and (active(m.b) or active(m.a)) by kill m.b;", "write `by kill m.a, m.b`"),
    ("forbid f: p and active(m.a, m.b, m.c) by kill m.c or kill m.a or kill m.b;", "write `by kill m.a, m.b, m.c`"),
    ("forbid f: p and active(m.a, m.b) by kill m.a or wait;", "write `by kill m.a or wait or kill m.a, m.b`"),
    (
        "forbid f: p and (active(m.b) or active(m.a with x > 1)) by kill m.b;",
        "write `by kill m.b or kill m.a, m.b`",
    ),
    (
        "forbid f: p and active(m.a, m.b) and (active(m.b) or active(m.c) or past(m.b)) by kill m.b;",
        "write `by kill m.b or kill m.a, m.b`",
    ),
    ("forbid f: p and used(power) > 2;", "write `by reject or kill m.a`"),
    ("forbid f: p and used(power) > 1;", "write `by reject or kill m.a, m.c`"),
    (
        "forbid f: p and used(load) > 1 by kill n.up or wait;",
        "write `by kill n.up or wait or kill n.up, n.cue, n.down`",
    ),
    ("forbid f: p and not active(m.b) and active(m.a with x > 2);", "write `by reject or kill m.a`"),
    ("forbid f: p and (active(m.a) or past(m.b) and past(m.c));", "`by reject or kill m.a` would restore it there"),
    ("forbid f: p;", "no kill would: let its condition name `active(…)` of what can be ended, or take the rule out"),
]


@pytest.mark.parametrize(("rule", "advice"), ADVICE)
def test_the_remedy_to_add_is_told_and_mends_the_rule(rule: str, advice: str) -> None:
    def found(text: str) -> dict[str, tuple[str, str]]:
        findings = check_by_diagrams(compiled(model_of(text)), {"completeness"}).findings
        return {each.check: (each.verdict, each.message) for each in findings if each.subject == "f"}

    verdict, message = found(WORLD + rule)["completeness"]
    assert verdict == "violated" and message.endswith(f"; {advice}")
    if advice.startswith("write"):
        mended = rule.partition(" by ")[0].rstrip(";") + f" {advice.split('`')[1]};"
        assert found(WORLD + mended)["completeness"][0] == "holds"


@pytest.mark.parametrize(
    ("rule", "advice"),
    [
        ("active(m.a) or active(m.c) or not active(m.b)", "`by reject or kill m.a, m.c` would restore it there"),
        ("active(m.a) or not active(m.b)", "`by kill m.b or kill m.a` would restore it there"),
    ],
)
def test_a_kill_that_has_to_spare_another_request_is_found(rule: str, advice: str) -> None:
    by = " by kill m.b" if "kill m.b" in advice else ""
    model = model_of(f"{WORLD} forbid f: p and ({rule}){by};")
    reference = Reference(model)
    state = reference.start()
    for event in (Ask("m.a", (0,)), Ask("m.b", ()), Ask("m.c", ()), Observe("p", True)):
        state, actions = reference.step(state, event)
    assert any(isinstance(each, Violated) for each in actions)
    assert told(reference, state, "f") == advice
