"""The oracle for properties: what it says by hand of small specs, and its two logics against each other."""

from functools import cache
from random import Random

import pytest

from exover.model.event import Ask
from exover.model.model import NOWHERE
from exover.model.property import (
    TRUE,
    Assumption,
    Atom,
    Conjunction,
    Disjunction,
    Formula,
    Happened,
    Negation,
    Next,
    Properties,
    Property,
    SomeUntil,
    Until,
    all_always,
    all_finally,
    all_next,
    all_until,
    always,
    atoms,
    finally_,
    implies,
)
from exover.pipeline import load_properties
from exover.source import Source
from tests.support import explicit_ctl, explicit_ltl
from tests.support.engines import model_of
from tests.support.formulas import Formulas
from tests.support.moments import Moments, moments_of
from tests.support.representatives import TooLarge
from tests.support.small import small_spec_of

STOP_AND_GO = """
spec s;
module m {
    request a(n: int in 1 .. 2) { interrupts self; }
    request b() { wait until not active(m.a); }
}
"""
FAILING = """
spec s;
module m {
    request b();
    request c() { check past(m.b); fail when off; }
}
poster off: bool = false;
launch go: m.c() when off and last(m.c) == none;
"""


@cache
def said(text: str, spec: str = STOP_AND_GO) -> tuple[Moments, Properties]:
    """Return the moments of a spec under a properties file, and the file."""
    model = model_of(spec)
    loaded = load_properties(Source("s.prop", f"for s;\n{text}"), model)
    assert loaded.properties is not None, loaded.diagnostics
    return moments_of(model, loaded.properties, 1000, 20_000), loaded.properties


def holds(of: Moments, each: Property) -> bool:
    if each.form == "ltl":
        return explicit_ltl.holds(of, each.formula)
    return explicit_ctl.holds(of, each.formula)


def verdicts(text: str, spec: str = STOP_AND_GO) -> list[bool]:
    of, properties = said(text, spec)
    return [holds(of, each) for each in properties.properties]


def check(spec: str, forms: dict[str, bool]) -> None:
    text = "".join(f"property p{number}: {form};\n" for number, form in enumerate(forms))
    assert dict(zip(forms, verdicts(text, spec), strict=True)) == forms
    assert not said(text, spec)[0].dead


def test_forms_of_requests_that_come_in_each_others_way() -> None:
    check(
        STOP_AND_GO,
        {
            "always (asked(m.b) implies not rejected(m.b))": False,
            "possible (active(m.a with n == 1) and waiting(m.b))": True,
            "possible active(m.a with n == 3)": False,
            "always possible launched(m.b)": True,
            "from waiting(m.b) possible running(m.b)": True,
            "always (waiting(m.b) leads to not waiting(m.b))": False,
            "true until not active(m.b)": True,
            "ltl F active(m.a)": False,
            "ltl X (asked(m.a) | asked(m.b))": True,
            "ctl AG (launched(m.a) -> asked(m.a))": False,
            "ctl AG (killed(m.a) -> asked(m.a) | !rejected(m.a))": True,
            "ctl AG (rejected(m.a with n == 2) -> waiting(m.a))": False,
            "ctl EF (rejected(m.a with n == 2) & waiting(m.a with n == 1))": True,
            "ctl EF (rejected(m.a with n == 2) & waiting(m.a with n == 1) & asked(m.a with n == 2))": False,
            "ctl EF (killed(m.a with n == 2) & stopping(m.a with n == 2) & asked(m.a with n == 1))": True,
            "ctl EF (ended(m.a with n == 2) & launched(m.a with n == 1))": True,
            "ctl AG (ended(m.a with n == 2) & active(m.a) -> launched(m.a))": True,
        },
    )


def test_forms_of_a_request_that_fails_and_one_that_is_required() -> None:
    check(
        FAILING,
        {
            "never (launched(m.c) and not past(m.b))": True,
            "never launched(m.c)": False,
            "from off possible past(m.c)": True,
            "past(m.b) precedes active(m.c)": True,
            "past(m.c) precedes active(m.c)": False,
            "past(m.b) precedes past(m.b)": True,
            "not past(m.c) until active(m.c)": False,
            "ltl G (launched(m.c) -> past(m.b))": True,
            "ltl G (active(m.c) -> active(m.c) W ended(m.c))": True,
            "ltl X (asked(m.b) | asked(m.c) | off | !off)": True,
            "ctl EX active(m.b) & !EX active(m.c)": True,
            "ctl E [!active(m.c) U past(m.b)]": True,
            "ctl A [!past(m.c) W launched(m.c)]": True,
            "ctl AG (ended(m.c) -> !running(m.c))": True,
            "possible (rejected(m.c) and asked(m.c))": True,
            "possible (rejected(m.c) and not asked(m.c))": True,
            "possible (killed(m.c) and not off)": True,
        },
    )


def test_what_is_rejected_has_the_arguments_that_it_asked_with_or_waited_with() -> None:
    """A superseded request is not the one that was asked for; one that is given up was not asked for at all."""
    text = """
        property superseded: possible (rejected(m.a with n == 2) and asked(m.a with n == 1));
        property aborted: possible (rejected(m.a with n == 2) and not asked(m.a));
        property both: possible (rejected(m.a with n == 2) and rejected(m.a with n == 1));
    """
    assert verdicts(text) == [True, True, False]


FAIR = "property served: always (waiting(m.b) leads to not waiting(m.b)); property again: ltl G F !active(m.b);"


def test_reports_have_to_be_fair_for_a_wait_to_end() -> None:
    """Even then a request that interrupts itself may come again and again, unless it stays away."""
    assert verdicts(FAIR) == [False, False]
    assert verdicts(FAIR + "assume fair reports;") == [False, True]
    assert verdicts(FAIR + "assume fair reports; assume never (launched(m.a) and waiting(m.b));") == [True, True]


def test_assumptions_keep_steps_away_but_never_the_start() -> None:
    text = "assume always off; property o: always off; property n: ltl X G off;"
    assert verdicts(text, FAILING) == [False, True]


def test_assumptions_that_leave_no_step_are_told() -> None:
    assert said("assume never off; assume never not off;", FAILING)[0].dead == {0}
    assert said("assume never active(m.a with n == 1);")[0].dead == set()
    assert said("assume always (asked(m.a) and rejected(m.b));")[0].dead == {0}
    assert said("assume always launched(m.b);")[0].dead == said("assume always launched(m.b);")[0].everything - {0}


def test_runs_that_cannot_be_fair_do_not_count() -> None:
    """A slot that is never reported keeps every run on which it is active from being fair."""
    text = "property p: never active(m.a); property q: ltl G !active(m.a); assume never ended(m.a);"
    assert verdicts(text) == [False, False]
    assert verdicts(text + "assume fair reports;") == [True, True]
    assert 0 in explicit_ctl.fair(said(text + "assume fair reports;")[0])


def test_events_lead_from_moment_to_moment() -> None:
    of, _ = said("property p: possible launched(m.a);")
    first = next(number for number in of.after[0] if of.moments[number].happened)
    assert isinstance(of.events[0, first], Ask)
    assert set(of.events) == {(source, target) for source, after in enumerate(of.after) for target in after}


# ---- the two logics ----

SEEDS = (3, 6, 16, 17, 26, 28, 29, 38, 56, 67, 73, 76)


def common(p: Formula, q: Formula) -> list[tuple[Formula, Formula]]:
    """Return formulas of CTL and of LTL that say the same."""
    early = Conjunction((q, Negation(p)))
    return [
        (p, p),
        (all_next(p), Next(p)),
        (all_always(p), always(p)),
        (all_finally(p), finally_(p)),
        (all_until(p, q), Until(p, q)),
        (all_always(implies(p, all_finally(q))), always(implies(p, finally_(q)))),
        (Negation(SomeUntil(Negation(p), early)), Negation(Until(Negation(p), early))),
        (all_always(all_finally(p)), always(finally_(p))),
        (all_always(implies(p, all_next(q))), always(implies(p, Next(q)))),
        (all_until(p, all_always(q)), Until(p, always(q))) if p == TRUE else (all_next(all_next(q)), Next(Next(q))),
        (all_next(all_until(p, q)), Next(Until(p, q))),
    ]


@cache
def random_case(seed: int) -> tuple[Moments, Formula, Formula]:
    model = model_of(small_spec_of(seed))
    writer = Formulas(Random(seed), model)
    p, q = writer.condition(1), writer.condition(1)
    looked_at = Property("p", None, "ctl", Disjunction((p, q)), None, NOWHERE)
    properties = Properties((looked_at,), writer.assumptions(), seed % 2 == 0)
    return moments_of(model, properties, 100, 1000), p, q


@pytest.mark.parametrize("seed", SEEDS)
def test_ctl_and_ltl_say_the_same_where_they_can(seed: int) -> None:
    of, p, q = random_case(seed)
    if 0 in explicit_ctl.fair(of):
        for one, other in common(p, q):
            assert explicit_ctl.holds(of, one) is explicit_ltl.holds(of, other), (one, other)


def test_the_random_cases_say_something() -> None:
    """Each pair is true in some case and false in another, and few cases are too large."""
    verdicts: list[set[bool]] = [set() for _ in range(11)]
    for seed in SEEDS:
        of, p, q = random_case(seed)
        for index, (one, _) in enumerate(common(p, q)):
            verdicts[index].add(explicit_ctl.holds(of, one))
    assert verdicts == [{True, False}] * 11


def test_random_files_are_of_every_kind() -> None:
    made = [Formulas(Random(seed), model_of(small_spec_of(seed))).properties(2, 2) for seed in range(60)]
    assert {len(each.assumptions) for each in made} == {0, 1, 2}
    assert {each.fair for each in made} == {True, False}
    found = [atom for each in made for one in each.properties for atom in atoms(one.formula)]
    assert {atom.occurrence for atom in found if isinstance(atom, Happened)} == {
        *("asked", "launched", "rejected", "killed", "ended")
    }
    assert any(isinstance(atom, Atom) for atom in found)
    assert any(one.premise for each in made for one in each.properties)
    assert made[7] == Formulas(Random(7), model_of(small_spec_of(7))).properties(2, 2)


def test_too_large_models_are_refused() -> None:
    model = model_of(STOP_AND_GO)
    with pytest.raises(TooLarge):
        moments_of(model, Properties((), (Assumption(TRUE, NOWHERE),)), 5, 100)
