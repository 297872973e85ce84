"""What Z3 says of claims is what decision diagrams say, and where these give up it is what the numbers say."""

from collections import Counter
from fractions import Fraction
from math import nextafter
from random import Random

import pytest

from exover.checks.questions import claims
from exover.engines.smt import Smt
from exover.engines.smt.concretize import SpuriousModel, as_doubles
from exover.engines.smt.houdini import Houdini
from exover.engines.smt.solver import Clock, Prover
from exover.engines.smt.system import System
from exover.engines.smt.unrolling import Taken
from exover.equivalence.engine import Z3
from exover.loop.claim import Claim, Opinion
from exover.loop.exact.events import Kind
from exover.model.event import Ask, Observe
from exover.model.model import Model
from exover.model.property import NO_PROPERTIES, Properties
from exover.pipeline import load_properties
from exover.source import Source
from tests.support.diagrams import check_by_diagrams
from tests.support.engines import model_of
from tests.support.formulas import Formulas
from tests.support.judging import judged
from tests.support.small import compiled, small_spec_of

SECONDS = 60.0
FEW = 5.0
"""Seconds for claims that may be too hard."""
SEEDS = (4, 6, 27, 42, 96, 112)
WITH_PROPERTIES = (6, 42, 96, 112)
SAFE = ("consistency", "safety", "completeness", "reachability", "rule-use")
"""Checks that are answered of every small spec below."""


def opinions(
    model: Model, properties: Properties = NO_PROPERTIES, seconds: float = SECONDS
) -> dict[tuple[str, str], tuple[Claim, Opinion]]:
    """Return what is said of every claim."""
    smt = Z3(compiled(model), properties, seconds)
    return {(claim.check, claim.subject): (claim, smt.judge(claim)) for claim in claims(model, properties)}


def verdicts(spec: str, properties: str = "") -> dict[tuple[str, str], str]:
    """Return the verdicts on a spec and the text of its properties."""
    model = model_of(spec)
    found = NO_PROPERTIES
    if properties:
        loaded = load_properties(Source("numbers.prop", f"for numbers;\n{properties}"), model)
        assert loaded.properties is not None, loaded.diagnostics
        found = loaded.properties
    return {key: opinion.verdict for key, (_, opinion) in opinions(model, found).items()}


def compare(seed: int, properties: Properties, seconds: float = SECONDS) -> Counter[str]:
    """Compare all verdicts with those of the diagrams; return how many are unknown by check."""
    made = compiled(model_of(small_spec_of(seed)))
    found = {(f.check, f.subject): f for f in check_by_diagrams(made, properties=properties).findings}
    unknown: Counter[str] = Counter()
    for key, (claim, opinion) in opinions(made.model, properties, seconds).items():
        if claim.formula is None and claim.check != "tables":
            assert opinion.verdict == "unknown"
        elif opinion.verdict == "unknown":
            assert opinion.message, claim
            unknown[claim.check] += 1
        else:
            assert opinion.verdict == found[key].verdict, f"{small_spec_of(seed)}\n{properties}\n{claim}\n{opinion}"
            assert opinion.method
    return unknown


@pytest.mark.parametrize("seed", SEEDS)
def test_verdicts_are_those_of_decision_diagrams(seed: int) -> None:
    unknown = compare(seed, NO_PROPERTIES)
    assert not any(unknown[check] for check in SAFE), unknown
    assert unknown.total() <= 1, unknown


@pytest.mark.parametrize("seed", WITH_PROPERTIES)
def test_verdicts_on_properties_are_those_of_decision_diagrams(seed: int) -> None:
    model = model_of(small_spec_of(seed))
    compare(seed, Formulas(Random(seed), model).properties(2, seed % 3), FEW)


def test_facts_of_the_loop_exclude_what_no_single_step_does() -> None:
    """Here r0 is launched only once it was interrupted, which it cannot be before it is launched."""
    made = compiled(model_of(small_spec_of(21)))
    smt = Smt(made, NO_PROPERTIES, SECONDS)
    (claim,) = (c for c in claims(made.model, NO_PROPERTIES) if (c.check, c.subject) == ("reachability", "ma.r0"))
    assert smt.judge(claim).verdict == "violated"
    assert smt.steps.invariants
    others = Houdini(smt.steps, Prover(Clock()))
    others.random = Random(1)
    for state in others._visited():
        assert all(smt.steps.terms.replaced(each, state) is smt.steps.terms.true for each in smt.steps.invariants)


# ---- numbers that diagrams do not follow ----

LARGE = """spec numbers;
poster depth: int in -2000000000 .. 2000000000 = 0;
poster limit: int in 0 .. 1000000000 = 500000000;
poster speed: real in 0 .. 100 = 0;
poster most: real = 50;
resource fuel: 1000000 consumable;
module m {
    request dive(to: int in 0 .. 1000000000) {
        check bounded: 3 * depth + 2 * limit <= 1000000001;
        consumes fuel 999999;
    }
    request drive(v: real) { check slow: v <= most; fail fast: when v > most; }
    request never() { check impossible: depth > limit and limit > depth + 5; }
}
forbid deep: active(m.dive) and depth + limit > 1500000000 by kill m.dive;
"""


def test_large_ranges_and_sums_are_exact() -> None:
    found = verdicts(LARGE)
    assert found["safety", "deep"] == found["completeness", "deep"] == "holds"
    assert found["reachability", "m.dive"] == found["reachability", "m.drive"] == "holds"
    assert found["reachability", "m.never"] == "violated"
    assert found["lockout", "m.never"] == "violated"
    assert found["lockout", "m.drive"] == "holds"
    assert found["rule-use", "m.drive.fast"] == found["rule-use", "m.drive.slow"] == "holds"


def test_a_bound_that_one_value_reaches_is_reached() -> None:
    found = verdicts(
        LARGE,
        """property running: never (running(m.dive) and depth + limit > 1500000000);
        property equal: never (running(m.dive) and depth + limit >= 1500000000);
        property above: never (active(m.dive) and depth + limit > 1500000000);
        property held: never (active(m.drive with v > 50) and most <= 50 and running(m.drive));
        property fast: possible active(m.drive with v > 1e308);
        property once: never (level(fuel) <= 0 and active(m.dive));
        property spent: possible (level(fuel) <= 1 and active(m.dive));
        """,
    )
    assert found["property", "above"] == found["property", "equal"] == "violated"  # what is killed is active still
    assert found["property", "running"] == "holds"
    assert found["property", "held"] == "holds"
    assert found["property", "fast"] == found["property", "spent"] == "holds"


NEIGHBOURS = """spec numbers;
module m {
    request narrow(v: real in 0 .. 1) { check between: v > 0.3 and v < 0.30000000000000004; }
    request wide(v: real in 0 .. 1) { check between: v > 0.3 and v < 0.3000000000000001; }
}
"""


def test_nothing_lies_between_neighbouring_doubles() -> None:
    found = verdicts(NEIGHBOURS)
    assert found["reachability", "m.narrow"] == "violated"
    assert found["reachability", "m.wide"] == "holds"


def test_fractions_become_doubles_in_the_same_order() -> None:
    third, fixed = Fraction(1, 3), [Fraction(0), Fraction(0.5), Fraction(1)]
    values = [third, third + Fraction(1, 10**40), Fraction(0.5), Fraction(3, 4)]
    found = as_doubles(values, fixed)
    doubles = [found[value] for value in values]
    assert doubles[0] < doubles[1] < doubles[2] == 0.5 < doubles[3] < 1
    with pytest.raises(SpuriousModel):
        as_doubles([Fraction(0.5) + Fraction(1, 10**40)], [Fraction(0.5), Fraction(nextafter(0.5, 1))])


LASTING = """spec numbers;
module m {
    request work();
    request next() { wait until not active(m.work); }
}
"""


def test_who_waits_for_reports_alone_waits_no_longer_in_the_end() -> None:
    served = "ltl G (waiting(m.next) -> F !waiting(m.next))"
    found = verdicts(LASTING, f"property served: {served};\nassume fair reports;")
    assert found["starvation", "m.next"] == found["property", "served"] == "holds"
    assert verdicts(LASTING, f"property served: {served};")["property", "served"] == "violated"


UNFAIR = """for unfair;
assume fair reports;
assume never ended(m.a);
property after_a: from active(m.a) possible active(m.b);
property of_trees: ctl AG (active(m.a) -> EF active(m.b));
property after_c: from active(m.c) possible active(m.b);
property from_start: always possible active(m.b);
"""


def test_a_moment_without_a_way_counts_only_if_a_fair_run_comes_there() -> None:
    """What launches `m.a` cannot report it: no fair run does. `m.b` is never launched."""
    made = compiled(model_of("spec unfair; module m { request a(); request b() { check past(m.b); } request c(); }"))
    loaded = load_properties(Source("unfair.prop", UNFAIR), made.model).properties
    assert loaded is not None
    asked = [each for each in claims(made.model, loaded) if each.check == "property" and each.subject != "assumptions"]
    smt = Smt(made, loaded, SECONDS)
    found = {claim.subject: smt.judge(claim).verdict for claim in asked}
    assert found == {"after_a": "unknown", "of_trees": "unknown", "after_c": "violated", "from_start": "violated"}
    known = dict(zip((claim.subject for claim in asked), judged(made, loaded, asked), strict=True))
    assert known == {"after_a": True, "of_trees": True, "after_c": False, "from_start": False}


# ---- what a run must be ----


def test_a_run_that_is_none_is_a_fault() -> None:
    smt = Smt(compiled(model_of(NEIGHBOURS)), NO_PROPERTIES)
    (claim,) = (c for c in claims(smt.compiled.model, NO_PROPERTIES) if (c.check, c.subject) == ("lockout", "m.wide"))
    assert claim.formula is not None
    system = System(smt.steps, NO_PROPERTIES, claim.formula)
    taken = [Taken(Kind("ask", "m.wide"), {"ask m.wide: v": Fraction(0.5)})]
    values = smt._runs.followed(system, taken, (Ask("m.wide", (0.5,)),))
    assert smt._runs.events(system, taken) == (Ask("m.wide", (0.5,)),)
    assert set(values) == set(system.vars.values())


def test_traces_are_concrete() -> None:
    model = model_of(LARGE)
    _, opinion = opinions(model)["rule-use", "m.drive.fast"]
    assert opinion.trace is not None
    assert any(isinstance(event, Observe) for event in opinion.trace.events)


def test_time_that_is_over_is_unknown() -> None:
    made = compiled(model_of(LARGE))
    smt = Smt(made, NO_PROPERTIES, 1e-9)
    said = [smt.judge(claim) for claim in claims(made.model, NO_PROPERTIES) if claim.check == "lockout"]
    assert {(each.verdict, each.message) for each in said} == {("unknown", "time limit")}


def test_a_formula_of_runs_is_refuted_part_by_part() -> None:
    """None of these is of the shape of one question, and no lasso shows that they hold."""
    made = compiled(
        model_of(
            """spec parts; poster hot: bool = false;
            module m { request a(); request b() { check past(m.a); } request c() { wait until not active(m.a); } }
            mutex m.a, m.c by wait;"""
        )
    )
    said = """for parts;
    property both: ltl (G (active(m.b) -> past(m.a))) & (G !(active(m.a) & active(m.c)));
    property either: ltl (G !(active(m.a) & active(m.c))) | (G hot);
    property since: ltl G (waiting(m.c) -> F !waiting(m.c)) | F hot;
    property until_then: ltl !(hot U (active(m.b) & !past(m.a)));
    property wrong: ltl (G !active(m.b)) | (G !hot);
    assume fair reports;"""
    loaded = load_properties(Source("parts.prop", said), made.model).properties
    assert loaded is not None
    smt = Smt(made, loaded, SECONDS)
    asked = [claim for claim in claims(made.model, loaded) if claim.check == "property"]
    found = {claim.subject: smt.judge(claim).verdict for claim in asked}
    judgements = zip(asked, judged(made, loaded, asked), strict=True)
    known = {claim.subject: "holds" if holds else "violated" for claim, holds in judgements}
    assert found["wrong"] == "violated" and {found[name] for name in ("both", "either", "until_then")} == {"holds"}
    assert {name: verdict for name, verdict in found.items() if verdict != "unknown"}.items() <= known.items()
