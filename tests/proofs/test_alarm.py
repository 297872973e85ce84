"""What looks for a proof ends when its time is over, and is not believed in what it has half done."""

from math import inf
from time import process_time

import pytest

from exover.engines.bdd.analysis import Analysis
from exover.model.property import NO_PROPERTIES
from exover.pipeline import build
from exover.proofs import search
from exover.proofs.alarm import Late, bounded
from exover.proofs.certify import certificate
from exover.proofs.operators import LATE
from exover.proofs.prove import FOR_PROOF
from tests.support.diagrams import check_by_diagrams
from tests.support.engines import model_of

SPEC = """spec late;
module m { request a() {} request b() {} }
mutex one: m.a, m.b;
"""


def test_what_goes_on_is_ended() -> None:
    with pytest.raises(Late), bounded(process_time() + 0.05):
        while True:
            pass


def test_what_is_done_in_time_is_not_ended() -> None:
    for deadline in (process_time() + 100, inf):
        with bounded(deadline):
            done = True
        assert done


def test_what_takes_too_long_has_no_proof_and_the_rest_has(monkeypatch: pytest.MonkeyPatch) -> None:
    made = build(model_of(SPEC))
    findings = check_by_diagrams(made.compiled).findings

    def endless(*given: object) -> Analysis:
        while True:
            pass

    monkeypatch.setattr(search, "GRACE", 0.2 - FOR_PROOF)
    monkeypatch.setattr(search, "Analysis", endless)
    asked = [each for each in findings if each.check in ("safety", "deadlock")]
    found = certificate(made.compiled, made.data, asked, NO_PROPERTIES, "0", lambda what: None)
    reasons = {each["check"]: each["proof"].get("reason") for each in found["findings"]}
    assert reasons == {"safety": None, "deadlock": LATE}
