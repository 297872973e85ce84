"""Random small specs have certificates, and what the engines say of them is proved wherever it can be said."""

import pytest

from exover.certificate.verify import read, verify
from exover.checks.run import check_all
from exover.model.property import NO_PROPERTIES
from exover.pipeline import build, claimed
from exover.proofs.certify import certificate, render
from tests.support.engines import model_of
from tests.support.small import small_spec_of

UNSAID = {"tables", "redundancy", "idle-guard", "starvation"}
"""Checks whose claims have no form that has proofs."""


@pytest.mark.parametrize("seed", (1, 5))
def test_findings_are_proved(seed: int) -> None:
    built = build(model_of(small_spec_of(seed)))
    outcome = check_all(built.compiled, lambda what: None)
    made = certificate(built.compiled, built.data, outcome.findings, NO_PROPERTIES, "0", lambda what: None)
    found = verify(built.data, read(render(made)), claimed(built.model, NO_PROPERTIES), 20)
    missing = [(each["check"], each["subject"], why) for each, why in found.unproved if each["check"] not in UNSAID]
    assert not [each for each in missing if "does not prove it" in each[2]]
    assert {each["check"] for each in found.proved} >= {"reachability"}
