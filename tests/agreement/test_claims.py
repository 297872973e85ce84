"""Each check finds what its claim says: the one decides its own way, the other is a formula for any engine."""

from dataclasses import replace
from random import Random

import pytest

from exover.checks.questions import CHECKS, claims
from exover.checks.questions.question import Context, Question
from exover.model.model import NOWHERE
from exover.model.property import NO_PROPERTIES, Negation, Properties
from exover.ocrd.compile import Compiled
from tests.support.constructs import seldom
from tests.support.engines import model_of
from tests.support.formulas import Formulas
from tests.support.judging import analysed, judged
from tests.support.small import compiled, small_spec_of

MANY = range(8)
SEEDS = (1, 2, 3, 4, 5)
"""Of small specs with properties that have every construct of the many."""


def made_of(seed: int) -> tuple[str, Compiled, Properties]:
    spec = small_spec_of(seed)
    made = compiled(model_of(spec))
    return spec, made, Formulas(Random(seed), made.model).properties(2, seed % 3)


def test_few_have_every_construct() -> None:
    cases = {seed: made_of(seed) for seed in MANY}
    few, many = ([(cases[seed][1].model, cases[seed][2]) for seed in seeds] for seeds in (SEEDS, MANY))
    assert not seldom(few, many, 1)


@pytest.mark.parametrize("seed", SEEDS)
def test_what_is_found_is_what_is_claimed(seed: int) -> None:
    spec, made, properties = made_of(seed)
    context = Context(made, analysed(made, properties))
    deciding = {check.name: check for check in CHECKS}
    contradictory = context.analysis.temporal.stranded() is not None or context.analysis.temporal.is_unfair()
    asked = [claim for claim in claims(made.model, properties) if claim.formula is not None]
    asked = [claim for claim in asked if claim.coherent or not contradictory]
    for claim, holds in zip(asked, judged(made, properties, asked), strict=True):
        check = deciding[claim.check]
        found = check.decide(context, Question(check.name, check.severity, claim.subject, NOWHERE))
        assert found.verdict == ("holds" if holds else "violated"), f"{spec}\n{properties}\n{claim}"


def test_only_what_is_not_about_runs_claims_nothing() -> None:
    made = compiled(model_of(small_spec_of(3)))
    silent = {claim.check for claim in claims(made.model, NO_PROPERTIES) if claim.formula is None}
    assert silent == {"tables", "redundancy"}


def test_the_opposite_of_a_claim_is_judged_otherwise() -> None:
    made = compiled(model_of(small_spec_of(3)))
    said = [claim for claim in claims(made.model, NO_PROPERTIES) if claim.formula is not None]
    opposite = [replace(claim, formula=Negation(claim.formula)) for claim in said if claim.formula is not None]
    for claim, *answers in zip(
        said, judged(made, NO_PROPERTIES, said), judged(made, NO_PROPERTIES, opposite), strict=True
    ):
        assert sorted(answers) == [False, True], claim
