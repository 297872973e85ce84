"""Random small specs and properties have certificates, and what the engines say of them is proved, but for little."""

from collections import Counter
from functools import cache
from random import Random
from typing import Any

import pytest

from exover.certificate.verify import Verified, read, verify
from exover.pipeline import build, claimed
from exover.proofs.certify import certificate, render
from exover.proofs.operators import ONE_MOMENT
from tests.support.diagrams import check_by_diagrams
from tests.support.engines import model_of
from tests.support.formulas import Formulas
from tests.support.small import small_spec_of

SEEDS = (17, 32, 41)
"""Small specs with every way of a proof, and of every check the verdicts that random ones have."""
UNSAID = {
    "the claim is not about the runs of one loop",
    "the checker does not know which demand has decided",
    "that the assumptions contradict each other is no part of the claim",
    ONE_MOMENT,
}
"""Why a finding has no proof."""


@cache
def verified(seed: int) -> Verified:
    built = build(model_of(small_spec_of(seed)))
    properties = Formulas(Random(seed), built.model).properties(3, 2)
    findings = check_by_diagrams(built.compiled, properties=properties).findings
    made = certificate(built.compiled, built.data, findings, properties, "0", lambda what: None)
    return verify(built.data, read(render(made)), claimed(built.model, properties), 20)


@pytest.mark.parametrize("seed", SEEDS)
def test_findings_are_proved(seed: int) -> None:
    found = verified(seed)
    assert {each["check"] for each in found.proved} >= {"reachability", "starvation"}
    assert not [(each["check"], each["subject"], why) for each, why in found.unproved if why not in UNSAID]


def test_most_properties_are_proved_in_every_way() -> None:
    proved = [each for seed in SEEDS for each in verified(seed).proved]
    unproved = [each for seed in SEEDS for each, _ in verified(seed).unproved if each["check"] == "property"]
    ways = Counter((each["verdict"], part["kind"]) for each in proved for part in parts(each))
    assert len([each for each in proved if each["check"] == "property"]) > 5 * len(unproved)
    assert {kind for _, kind in ways} == {"invariant", "closed", "layers", "run", "ranking"}
    assert {verdict for verdict, kind in ways if kind == "ranking"} == {"holds", "violated"}
    assert {verdict for verdict, kind in ways if kind == "layers"} == {"holds", "violated"}
    assert {verdict for verdict, kind in ways if kind == "closed"} == {"holds", "violated"}
    both = {"safety", "completeness", "reachability", "deadlock", "obligation", "property", "rule-use", "lockout"}
    both |= {"starvation", "idle-guard", "vacuity"}
    judged = {(each["check"], each["verdict"]) for each in proved}
    assert judged == {("consistency", "holds")} | {(check, said) for check in both for said in ("holds", "violated")}


def parts(finding: dict[str, Any]) -> list[dict[str, Any]]:
    return [part for part in finding["proof"]["parts"] if part is not None]
