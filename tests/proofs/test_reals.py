"""Sets that tell states apart by how reals compare are said in proofs, and taken: posters, arguments, and both."""

from itertools import permutations
from typing import Any

import pytest

from exover.certificate.verify import Verified, read, verify
from exover.model.property import NO_PROPERTIES
from exover.pipeline import build, check, claimed
from exover.proofs.certify import certificate, render
from exover.proofs.operators import CHOSEN
from tests.support.engines import model_of

SPEC = """spec reals;
poster limit: real in 0 .. 10 = 5;
poster speed: real in 0 .. 10 = 0;
module m {
    request ahead(v: real in 0 .. 10) { wait until v <= limit or not active(m.back); }
    request back(v: real in 0 .. 10, w: real in 0 .. 10);
    request calm() { wait until speed <= limit or not active(m.back); }
    request rest() { wait until not active(m.back with v < w); }
    request slow(v: real in 0 .. 10) { check v <= limit; }
}
"""
Json = dict[str, Any]
LED = ("deadlock", "lockout", "starvation", "reachability", "rule-use")


@pytest.fixture(scope="module")
def made() -> tuple[Json, Verified]:
    built = build(model_of(SPEC))
    findings = check(built, lambda _: None).findings
    found = certificate(built.compiled, built.data, findings, NO_PROPERTIES, "0", lambda what: None)
    return found, verify(built.data, read(render(found)), claimed(built.model, NO_PROPERTIES), 20)


def test_comparisons_of_reals_are_said_in_proofs(made: tuple[Json, Verified]) -> None:
    certificate, verified = made
    unproved = {(each["check"], each["subject"]): why for each, why in verified.unproved if each["check"] in LED}
    assert unproved["lockout", "m.slow"] == CHOSEN
    assert {check for check, _ in unproved} <= {"lockout", "rule-use"}
    said = str([each["proof"] for each in certificate["findings"]])
    for pair in (("reading.0", "reading.1"), ("arg.1.0", "arg.1.1")):
        assert any(f"({how} {left} {right})" in said for how in "<=" for left, right in permutations(pair)), pair
