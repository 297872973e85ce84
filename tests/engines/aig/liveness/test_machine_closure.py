"""Whether assumptions let runs go on is seen, and where they do not it is not claimed."""

import pytest

from exover.checks.questions import property as property_check
from exover.engines.aig.circuit.answer import Answer, Unreachable
from exover.engines.aig.circuit.graph import Circuit
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.engine import Aig
from exover.engines.aig.induction.pdr import decide
from exover.engines.aig.liveness.machine_closure import can_go_on, unreported
from exover.loop.claim import CONTRADICTION, CONTRADICTORY, Opinion
from exover.model.event import Ask, Event, Report
from exover.pipeline import build, load, load_properties
from exover.source import Source

SPEC = """spec small;
poster charge: int in 0 .. 100 = 50;
module m { request go() { fail low: when charge < 10; } request stop(); }
"""


def excluded(circuit: Circuit) -> set[int]:
    answers: dict[int, Answer] = {}
    decide(circuit, answers.__setitem__)
    return {number for number, answer in answers.items() if isinstance(answer, Unreachable)}


@pytest.mark.parametrize(
    ("assumed", "wanted"),
    [
        ("", True),
        ("assume always (charge >= 5);", True),  # the least reading is not allowed, but an ask is
        ("assume never (charge < 5); assume fair reports;", True),
        ("assume never (last(m.go) == ok);", True),  # it may fail
        ("assume never (killed(m.go)); assume always (charge < 10 implies not active(m.go));", True),
        ("assume never (ended(m.go));", False),  # what runs is never reported
        ("assume always (charge > 100);", False),
    ],
)
def test_runs_go_on_as_far_as_assumptions_let_them(assumed: str, wanted: bool) -> None:
    model = load(Source("small.exo", SPEC)).model
    assert model is not None
    properties = load_properties(Source("small.prop", f"for small; {assumed}"), model).properties
    assert properties is not None
    encoding = Encoding(build(model).compiled, properties)
    assert (can_go_on(encoding, excluded) and not unreported(encoding, excluded)) is wanted


@pytest.mark.parametrize(
    ("assumed", "events"),
    [
        ("assume always charge < 20; assume always charge > 60;", ()),
        ("assume never past(m.go) and not ended(m.go);", (Ask("m.go"), Report("m.go", 0, "ok"))),
    ],
    ids=["at the start", "later"],
)
def test_where_no_step_is_allowed_assumptions_contradict_each_other(assumed: str, events: tuple[Event, ...]) -> None:
    properties = (
        "property a: possible active(m.stop); property b: active(m.go) precedes past(m.go); "
        "property c: always possible active(m.stop);"
    )
    said = judged(f"for small; {assumed} {properties}")
    assert [(each.verdict, each.message) for each in said] == [("violated", CONTRADICTION)] * 3
    assert [each.trace.events for each in said if each.trace] == [events] * 3


def test_what_assumptions_let_go_on_is_not_said_to_be_contradictory() -> None:
    (said,) = judged("for small; assume never ended(m.go); property a: never running(m.stop) and charge == 7;")
    assert said.verdict == "violated"
    assert CONTRADICTORY not in said.message


@pytest.mark.parametrize(
    ("assumed", "verdict"),
    [
        ("assume never (ended(m.go) and charge < 90);", "holds"),  # it can be charged first
        ("assume never (ended(m.go) and charge < 90); assume always (charge < 90);", "unknown"),
    ],
)
def test_what_can_be_reported_later_lets_runs_go_on_fairly(assumed: str, verdict: str) -> None:
    (said,) = judged(f"for small; assume fair reports; {assumed} property a: always possible active(m.stop);")
    assert said.verdict == verdict


def judged(text: str) -> list[Opinion]:
    """Return what is said of the properties of a text, without ABC."""
    model = load(Source("small.exo", SPEC)).model
    assert model is not None
    properties = load_properties(Source("small.prop", text), model).properties
    assert properties is not None
    claims = [property_check.claim(model, properties, each.name) for each in properties.properties]
    found: dict[int, Opinion] = {}
    Aig(build(model).compiled, properties).judge_all(claims, found.__setitem__)
    return [found[number] for number in range(len(claims))]
