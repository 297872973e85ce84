"""Each check finds what its claim says: the one decides its own way, the other is a formula for any engine."""

from dataclasses import replace
from random import Random

import pytest

from exover.checks import CHECKS, claims
from exover.checks.question import Context, Question
from exover.model.model import NOWHERE
from exover.model.property import NO_PROPERTIES, Negation
from tests.support.engines import model_of
from tests.support.formulas import Formulas
from tests.support.judging import analysed, judged
from tests.support.small import compiled, small_spec_of

SEEDS = range(8)


@pytest.mark.parametrize("seed", SEEDS)
def test_what_is_found_is_what_is_claimed(seed: int) -> None:
    spec = small_spec_of(seed)
    made = compiled(model_of(spec))
    of = Formulas(Random(seed), made.model)
    properties = of.properties(2, seed % 3)
    context = Context(made, analysed(made, properties))
    deciding = {check.name: check for check in CHECKS}
    contradictory = context.analysis.temporal.stranded() is not None
    for claim in claims(made.model, properties):
        if claim.formula is not None and (claim.coherent or not contradictory):
            check = deciding[claim.check]
            found = check.decide(context, Question(check.name, check.severity, claim.subject, NOWHERE))
            wanted = "holds" if judged(made, properties, claim) else "violated"
            assert found.verdict == wanted, f"{spec}\n{properties}\n{claim}"


def test_only_what_is_not_about_runs_claims_nothing() -> None:
    made = compiled(model_of(small_spec_of(3)))
    silent = {claim.check for claim in claims(made.model, NO_PROPERTIES) if claim.formula is None}
    assert silent == {"tables", "redundancy"}


def test_the_opposite_of_a_claim_is_judged_otherwise() -> None:
    made = compiled(model_of(small_spec_of(3)))
    for claim in claims(made.model, NO_PROPERTIES):
        if claim.formula is not None:
            opposite = replace(claim, formula=Negation(claim.formula))
            assert judged(made, NO_PROPERTIES, claim) != judged(made, NO_PROPERTIES, opposite)
