"""What rules change, asked on the graph of the loop, is what enumeration and the decision diagrams find."""

from pathlib import Path

import pytest

from exover.cli.files import read_properties, read_spec
from exover.engines.aig.circuit.answer import Answer, Reachable, Unreachable
from exover.engines.aig.circuit.words import lit
from exover.engines.aig.encoding.concretize import Concretizer
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.induction.pdr import decide
from exover.engines.aig.redundancy import Contrasts, changes
from exover.loop.claim import APPROXIMATE
from exover.model.event import Ask, Event, Observe
from exover.model.expression import Status
from exover.model.model import NOWHERE, Model
from exover.model.property import NO_PROPERTIES, Assumption, Atom, Conjunction, Happened, Negation, Properties
from exover.ocrd.compile import Compiled
from tests.support.diagrams import check_by_diagrams
from tests.support.engines import model_of
from tests.support.oracle import verdicts
from tests.support.small import VARIED, compiled, explored, small_spec_of
from tests.support.watch import watched

SPECS = [*sorted(Path("specs").glob("*.exo")), Path("specs/violations/redundancy.exo")]


def verdicts_of(made: Compiled, properties: Properties = NO_PROPERTIES) -> dict[str, str]:
    """Return what is found by rule, two passes being enough: it holds iff a run shows what the rule changes."""
    encoding = Encoding(made, properties, observer=Contrasts(made))
    names = list(dict.fromkeys(rule.name for rule in made.model.rules))
    circuit = encoding.circuit([encoding.unsettled, *(changes(encoding, name) for name in names)])
    found: dict[int, Answer] = {}
    decide(circuit, found.__setitem__)
    assert isinstance(found[0], Unreachable)
    concretizer = Concretizer(encoding)
    by_rule = {}
    for number, name in enumerate(names, 1):
        answer = found[number]
        if isinstance(answer, Reachable):
            trace, _ = concretizer.walk(answer.inputs)
            assert name in changed_last(made.model, trace.events)
        by_rule[name] = {Reachable: "holds", Unreachable: "violated"}[type(answer)]
    return by_rule


def changed_last(model: Model, events: tuple[Event, ...]) -> set[str]:
    """Return the rules without which something would be decided otherwise in the last step of a run."""
    watch = watched(model)
    state = watch.start()
    for event in events[:-1]:
        state, _ = watch.step(state, event)
    watch.changed.clear()
    watch.step(state, events[-1])
    return watch.changed


def verdicts_of_text(text: str, properties: Properties = NO_PROPERTIES) -> dict[str, str]:
    return verdicts_of(compiled(model_of(text)), properties)


@pytest.mark.parametrize("seed", VARIED)
def test_every_verdict_is_that_of_the_oracle(seed: int) -> None:
    text = small_spec_of(seed)
    made = compiled(model_of(text))
    wanted = verdicts(explored(seed))
    for name, verdict in verdicts_of(made).items():
        assert verdict == wanted["redundancy", name], f"{text}\n{name}"


@pytest.mark.parametrize("path", SPECS, ids=[path.stem for path in SPECS])
def test_every_verdict_is_that_of_the_diagrams(path: Path) -> None:
    model = read_spec(str(path))
    written = Path("properties", f"{path.stem}.prop")
    properties = read_properties(str(path), str(written), model) if written.exists() else NO_PROPERTIES
    made = compiled(model)
    findings = check_by_diagrams(made, {"redundancy"}, properties=properties).findings
    found, wanted = verdicts_of(made, properties), [each for each in findings if each.check == "redundancy"]
    assert [each.subject for each in wanted] == list(found)
    assert {each.message for each in wanted if each.verdict == "unknown"} <= {APPROXIMATE}
    known = {each.subject: each.verdict for each in wanted if each.verdict != "unknown"}
    assert known.items() <= found.items() and len(known) > len(found) / 2


def while_active(state: str) -> str:
    """Return the clauses by which a state is true while their request is active."""
    endings = " ".join(f"on {outcome} set {state} = false;" for outcome in ("ok", "failed", "interrupted"))
    return f"on launch set {state} = true; {endings}"


WIND = "spec s; poster wind: int in 0 .. 4 = 0; module m { request a(); }"


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        (
            f"""{WIND} forbid gale: wind > 3 and active(m.a) by kill m.a;
            forbid storm: wind > 2 and active(m.a) by kill m.a;""",
            {"gale": "violated", "storm": "holds"},
        ),
        (
            f"{WIND.replace('a();', 'a() { check wind <= 2; }')} forbid storm: wind > 2 and active(m.a) by kill m.a;",
            {"storm": "holds"},
        ),
        (
            f"{WIND.replace('a();', 'a() { check wind <= 2; }')} forbid storm: wind > 2 and active(m.a) by reject;",
            {"storm": "holds"},
        ),
        (
            "spec s; module m { request a(); request b(); } mutex x: m.a, m.b; mutex y: m.b, m.a;",
            {"x": "violated", "y": "violated"},
        ),
        (
            "spec s; module m { request a(); request b(); } mutex x: m.a, m.b by wait; mutex y: m.b, m.a;",
            {"x": "violated", "y": "holds"},
        ),
        (
            """spec s; poster p: bool = false;
            module m {
                state s: bool = false;
                request b() { check not active(m.a); wait until p and waiting(m.d); on launch set s = true; }
                request a() { wait until p; }
                request d() { wait until p; on launch set s = false; }
            }
            forbid x: active(m.a) and m.s by reject;""",
            {"x": "holds"},
        ),
        (
            """spec s; module m { request a(); request b(); request c(); }
            forbid x: active(m.c) and (active(m.a) or active(m.a) and active(m.b)) by kill m.a, m.b;
            forbid y: active(m.c) and active(m.a) by kill m.a;""",
            {"x": "holds", "y": "violated"},
        ),
        (
            """spec s; resource power: 7;
            module m { request a() { uses power 2; } request b() { uses power 3; } request c() { uses power 2; } }
            mutex y: m.a, m.b;
            limit x: at most 2 of m.a, m.b, m.c;""",
            {"power": "violated", "y": "holds", "x": "violated"},
        ),
        (
            f"""spec s; poster p: bool = false;
            module m {{
                state s: bool = false;
                request a() {{ check not s; {while_active("s")} }}
                request b() {{ check not s; settle until p; {while_active("s")} }}
            }}
            forbid x: active(m.a) and active(m.b) by kill m.a, m.b;""",
            {"x": "holds"},
        ),
        (
            """spec s; forbid x: active(m.b) by wait;
            module m { request b() { consumes f 2; } } resource f: 2 consumable by wait;""",
            {"x": "holds"},
        ),
    ],
    ids=[
        "later kill",
        "restores",
        "violation",
        "twice",
        "reason",
        "within a step",
        "another kill",
        "never too many",
        "gives up",
        "a level that matters without it alone",
    ],
)
def test_what_is_easy_to_get_wrong(text: str, wanted: dict[str, str]) -> None:
    assert verdicts_of_text(text) == wanted


@pytest.mark.parametrize(
    ("guards", "verdict"),
    [
        ("check not busy;", "violated"),
        ("check not busy; wait until p;", "holds"),
        ("check not waiting(m.a); wait until not busy;", "holds"),
        ("check active(m.a) or not busy;", "violated"),
    ],
    ids=["never twice", "supersedes", "waits for itself", "counts itself out"],
)
def test_who_interrupts_itself_would_be_busy_without(guards: str, verdict: str) -> None:
    found = verdicts_of_text(f"""spec s; poster p: bool = true;
        module m {{
            state busy: bool = false;
            request a(k: bool) {{ {guards} interrupts self; {while_active("busy")} }}
        }}""")
    assert found["m.a.interrupts.self"] == verdict


def test_only_steps_that_are_assumed_are_looked_at() -> None:
    text = "spec s; module m { request a(); request b(); } mutex x: m.a, m.b;"
    both = [("m.a", "m.b"), ("m.b", "m.a")]
    never = [Negation(Conjunction((Happened("asked", a), Atom(Status("active", b, None))))) for a, b in both]
    assumed = Properties((), tuple(Assumption(each, NOWHERE) for each in never))
    assert verdicts_of_text(text)["x"] == "holds"
    assert verdicts_of_text(text, assumed)["x"] == "violated"


def test_what_the_last_pass_passes_is_of_the_step() -> None:
    """The launch is tried, and rejected, in the pass after the one in which b is launched: it changes no state."""
    made = compiled(
        model_of("""spec s; poster p: bool = false;
        module m { request a() { check shut: false; } request b() { wait until p; } }
        launch l: m.a() when active(m.b);""")
    )
    encoding = Encoding(made, NO_PROPERTIES, passes=1)
    (observed,) = (lit(event.chosen) for event in encoding.events if event.kind.verb == "observe")
    found: dict[int, Answer] = {}
    decide(
        encoding.circuit([encoding.graph.conjunction(observed, encoding.moments.mark(("reject", "m.a.shut")))]),
        found.__setitem__,
    )
    assert isinstance(found[0], Reachable)
    assert Concretizer(encoding).events(found[0].inputs) == (Ask("m.b"), Observe("p", True))
