"""The graph takes the steps of the reference interpreter: states, marks and what is asked of moments, step by step."""

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from random import Random

import pytest

from exover.engines.aig.circuit.graph import FALSE, Circuit
from exover.engines.aig.circuit.solver import Solver
from exover.engines.aig.circuit.words import lit
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.simulation.coverage import CoverageGoals
from exover.engines.aig.simulation.exploration import LANES, Exploration
from exover.engines.aig.simulation.reached import reached
from exover.engines.aig.simulation.reduction import reduced
from exover.engines.aig.simulation.runs import simulate
from exover.engines.aig.simulation.stimulus import RandomStimulus
from exover.model.event import Abort, Ask, Event, Report
from exover.model.model import NOWHERE
from exover.model.property import (
    NO_PROPERTIES,
    Assumption,
    Atom,
    Broken,
    Conjunction,
    Happened,
    Negation,
    Properties,
    Property,
)
from exover.ocrd.compile import Compiled
from tests.support.engines import model_of
from tests.support.followed import Following, Inverse
from tests.support.formulas import Formulas
from tests.support.fuzz import spec_of
from tests.support.seldom import SELDOM as OTHERS
from tests.support.small import compiled, small_spec_of

ROOT = Path(__file__).parents[4]
FILES = [*sorted((ROOT / "specs").glob("*.exo")), *sorted((ROOT / "tests" / "vectors").glob("*.exo"))]
SMALL = (0, 2, 3, 4, 7, 12, 16, 26)
LARGE = (0, 1, 3, 4, 5, 12, 13)
Smaller = Callable[[Circuit], Circuit]


def followed(
    text: str,
    seed: int,
    steps: int = 16,
    lanes: int = 12,
    passes: int = 2,
    atoms: int = 6,
    smaller: Smaller | None = None,
) -> Counter[str]:
    """Follow random runs of a spec; return what was seen in them."""
    made = compiled(model_of(text))
    encoding, asked = encoded(made, seed, passes, atoms, smaller)
    following = Following(encoding, asked, lanes, seed)
    following.run(steps)
    return following.counts


def encoded(
    made: Compiled, seed: int, passes: int, atoms: int, smaller: Smaller | None = None
) -> tuple[Encoding, list[Atom | Happened | Broken]]:
    """Return the encoding of a model, and what is asked of its moments: random atoms, and whether rules are broken."""
    of = Formulas(Random(seed), made.model)
    asked = list(dict.fromkeys(of.atom() for _ in range(atoms)))
    properties = Properties(tuple(Property("p", None, "ctl", each, None, NOWHERE) for each in asked), (), False)
    rules = [Broken(rule, calm) for rule in made.model.rules[:6] for calm in (False, True)]
    encoding = Encoding(made, properties, passes)
    if smaller is not None:
        encoding.rewrite(smaller(encoding.whole()))
    return encoding, [*asked, *rules]  # type: ignore[list-item]


def swept(circuit: Circuit) -> Circuit:
    """Return a circuit that equals another, with fewer nodes."""
    latches = tuple(replace(latch, next=latch.node * 2) for latch in circuit.latches)  # all states are reached
    still = replace(circuit, latches=latches, bad=(*circuit.bad, *(latch.next for latch in circuit.latches)))
    runs = simulate(still, lanes=64, steps=2)
    found = reduced(still, reached(still.support(still.bad), runs))
    count = len(circuit.bad)
    after = zip(circuit.latches, found.bad[count:], strict=True)
    return replace(found, latches=tuple(replace(old, next=each) for old, each in after), bad=found.bad[:count])


@pytest.mark.parametrize("seed", SMALL[::2])
def test_a_smaller_graph_takes_the_same_steps(seed: int) -> None:
    assert followed(small_spec_of(seed), seed, smaller=swept)["given event"]


def conjunctions(circuit: Circuit) -> int:
    """Return how many there are."""
    nodes = circuit.cone([*circuit.bad, *(latch.next for latch in circuit.latches)])
    return sum(circuit.fanins[node] is not None for node in nodes)


@pytest.mark.parametrize("file", FILES[:4], ids=lambda file: file.stem)
def test_the_graph_of_a_spec_that_was_made_smaller_takes_the_same_steps(file: Path) -> None:
    sizes: list[bool] = []

    def smaller(circuit: Circuit) -> Circuit:
        found = swept(circuit)
        sizes.append(conjunctions(circuit) > 1.4 * conjunctions(found))
        return found

    assert followed(file.read_text(), 1, steps=8, lanes=8, passes=3, smaller=smaller)["given event"]
    assert sizes == [True], "the graph has hardly become smaller"


@cache
def small(seed: int) -> Counter[str]:
    return followed(small_spec_of(seed), seed)


@pytest.mark.parametrize("seed", SMALL)
def test_small_specs_are_followed(seed: int) -> None:
    assert small(seed)["given event"]


@pytest.mark.parametrize("seed", LARGE)
def test_specs_over_the_whole_language_are_followed(seed: int) -> None:
    assert followed(spec_of(seed), seed, steps=10, lanes=8)["given event"]


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_specs_of_the_project_are_followed(file: Path) -> None:
    assert followed(file.read_text(), 1, steps=8, lanes=6, passes=3)["given event"]


def test_the_runs_do_all_kinds_of_things() -> None:
    """Else that they agree would say little."""
    counts = sum((small(seed) for seed in SMALL), Counter[str]())
    wanted = ["event", "given event", "0 passes", "1 passes"]
    wanted += [f"mark {name}" for name in ("rule", "launch", "left", "reject", "wait", "settle", "kill", "abort")]
    wanted += [f"{kind} {truth}" for kind in ("Atom", "Happened", "Broken") for truth in (True, False)]
    assert [name for name in wanted if not counts[name]] == []


SELDOM = OTHERS | {
    "a launch rule is tried once in a step": (
        """module m {
            state x: bool = false;
            request a() { check x; }
            request b() { wait until not active(m.c); on launch set x = true; }
            request c();
        }
        launch l: m.a() when not active(m.c);""",
        ["ask c", "ask b", "ok c", "ask c", "ok b"],
    ),
}


@pytest.mark.parametrize(("text", "events"), SELDOM.values(), ids=SELDOM)
def test_what_is_seldom_met_is_followed(text: str, events: list[str]) -> None:
    made = compiled(model_of(f"spec s; {text}"))
    script: list[Event] = []
    for event in events:
        kind, name = event.split()
        match kind:
            case "ask":
                script.append(Ask(f"m.{name}"))
            case "ok":
                script.append(Report(f"m.{name}", 0, "ok"))
            case _:
                script.append(Abort(f"m.{name}", 0))
    following = Following(Encoding(made, NO_PROPERTIES, 3), (), 4, 1, script)
    following.run(len(script))
    assert following.counts["given event"] == 2 * len(script)


# ---- reals that are compared with each other ----

REALS = """spec s;
module m {
    poster limit: real in 0 .. 2 = 1;
    poster other: real in 0 .. 2 = 0.5;
    request go(v: real in 0 .. 2, w: real in -1 .. 1) returns (d: real in 0 .. 2) instances 2 {
        check v <= limit; check v != w;
        wait until v > m.other;
        fail when v > m.limit;
    }
    request slow(v: real in 0 .. 0.5) { check limit >= v; interrupts self; settle until not active(m.go); }
}
module n {
    poster limit: real in 0 .. 2 = 1;
    poster other: real in 0 .. 2 = 0.5;
    request go(v: real in 0 .. 2, w: real in -1 .. 1) returns (d: real in 0 .. 2) instances 2 {
        check v <= limit; check v != w;
        wait until v > n.other;
    }
}
poster third: real = 0;
forbid far: active(m.go with v > 0.3) and third > 0.30000000000000004 by kill m.go;
forbid between: active(m.go with v > 0.3 and v < 0.30000000000000004) by wait;
launch back: m.slow(0.25) when third < 0 and past(m.go with d >= 0.1);
"""


def test_reals_that_are_compared_with_each_other_are_followed() -> None:
    counts = followed(REALS, 3, steps=24, lanes=24, atoms=12)
    assert counts["given event"] > 100
    assert counts["event"] > 50


ALIKE = """module {0} {{
    poster limit: real in 0 .. 2 = 1;
    request go(v: real in 0 .. 2) instances 2 {{ check v <= limit; }}
}}
"""


def test_reals_of_another_module_do_not_stand_in_the_way() -> None:
    """The reals of m and n lie on grids that are alike, but are not compared with each other."""
    counts = followed("spec s;" + ALIKE.format("m") + ALIKE.format("n"), 4, steps=24, lanes=32, atoms=0)
    assert counts["event"] > 50
    assert counts["spurious"] == 0


def test_reals_move_only_to_where_they_compare_as_before() -> None:
    """Two limits, and what waits and runs between them: whatever the inputs, the order of no two changes."""
    text = REALS[: REALS.index("module n")]
    encoding = Encoding(compiled(model_of(text)), NO_PROPERTIES, 1)
    terms, layout = encoding.terms, encoding.latches
    moved = sorted(encoding.reembedded)
    pairs = [(one, other) for one in moved for other in moved if layout.spans[one].grid == layout.spans[other].grid]
    assert len(pairs) > 9
    before = [lit(terms.at_most(layout.vars[one], layout.vars[other])) for one, other in pairs]
    after = [lit(terms.at_most(encoding.reembedded[one], encoding.reembedded[other])) for one, other in pairs]
    wrong = [encoding.graph.differ(*each) for each in zip(before, after, strict=True)]
    free = [encoding.legal, encoding.moments.domain]
    solver = Solver(encoding.circuit([*free, *wrong, *after]))
    for pair, bad, here in zip(pairs, wrong, after, strict=True):
        assert not solver.satisfiable([solver.literal(each) for each in (*free, bad)]), pair
        assert solver.satisfiable([solver.literal(each) for each in (*free, here)]), pair


def test_there_is_a_place_for_every_real_that_is_held_or_comes_with_an_event() -> None:
    for text in (REALS, *map(small_spec_of, (2, 7, 12))):
        encoding = Encoding(compiled(model_of(text)), NO_PROPERTIES, 1)
        inverse, layout = Inverse(encoding), encoding.latches
        for group, names in inverse.groups.items():
            grid = layout.spans[names[0]].grid
            assert grid is not None
            fresh = [sum(inverse.group(e, g) == group for g in e.given) for e in encoding.events]
            assert len(names) + max(fresh) <= 1 << grid.places, names


# ---- passes ----

CHAIN = """spec s;
poster hot: bool = false;
module m {
    request a() { wait until not active(m.b); }
    request b() { wait until not active(m.c); }
    request c() { wait until not active(m.d); }
    request d();
    state x: int in 0 .. 3 = 0;
    request e() { wait until x >= 2; on launch set x = 3; }
    request f() { wait until x == 1; on launch set x = 2; }
    request g() { wait until not hot; on launch set x = 1; on ok set x = 0; }
}
launch l: m.f() when hot;
"""
"""Requests that let each other go, the last one first: it takes a pass for each."""


@pytest.mark.parametrize("passes", [1, 2, 3, 4])
def test_a_step_is_unsettled_iff_it_takes_more_passes(passes: int) -> None:
    counts = followed(CHAIN, 5, steps=40, lanes=8, passes=passes, atoms=0)
    assert counts["2 passes"] and counts["3 passes"]


@pytest.mark.parametrize("passes", [1, 2])
def test_what_is_unsettled_is_told_by_the_parts_of_a_pass(passes: int) -> None:
    """There are several, and random runs come to one of them, but to no unsettled step that none of them tells."""
    encoding = Encoding(compiled(model_of(CHAIN)), NO_PROPERTIES, passes)
    parts = [literal for literal in encoding.unsettled_parts if literal != FALSE]
    others = encoding.graph.conjunction(encoding.unsettled, encoding.graph.any(parts) ^ 1)
    circuit = encoding.circuit([others, *parts])
    seen = Exploration(
        circuit, range(len(circuit.bad)), RandomStimulus(encoding, LANES).stimulus(), CoverageGoals()
    ).run(16)
    assert len(parts) > 1 and seen and 0 not in seen


# ---- assumptions ----


@pytest.mark.parametrize("seed", [3, 7, 16])
def test_a_step_that_is_assumed_away_changes_nothing(seed: int) -> None:
    made = compiled(model_of(small_spec_of(seed)))
    of, first = Formulas(Random(seed), made.model), made.model.requests[0].name
    assumed = Negation(Conjunction((of.atom(), of.atom()))), Negation(Happened("asked", first))
    assumptions = tuple(Assumption(each, NOWHERE) for each in assumed)
    encoding = Encoding(made, Properties((), assumptions, False), 2)
    following = Following(encoding, [], 16, seed)
    following.run(12)
    assert following.counts["forbidden"]
    assert following.counts["given event"]


@pytest.mark.parametrize("seed", SMALL)
def test_two_graphs_of_a_loop_number_their_states_and_inputs_alike(seed: int) -> None:
    """Also where questions were asked of one and the other is smaller: what is proved of one is known of the other."""
    made = compiled(model_of(small_spec_of(seed)))
    one, other = (Encoding(made, NO_PROPERTIES) for _ in range(2))
    assert one.graph == other.graph and one.following == other.following
    latches, inputs = tuple(one.graph.latches), tuple(one.graph.inputs)
    one.graph.latch(False)
    other.rewrite(swept(other.whole()))
    assert tuple(one.graph.latches)[: len(latches)] == latches == tuple(other.graph.latches)
    assert inputs == tuple(other.graph.inputs)
