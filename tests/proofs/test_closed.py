"""Sets of states that no step leaves prove what never happens: from the first moment, or from the end of a run."""

from collections.abc import Callable
from copy import deepcopy
from typing import Any

import pytest

from exover.certificate.table import Refused
from exover.certificate.verify import read, verify
from exover.model.property import NO_PROPERTIES
from exover.pipeline import Build, build
from exover.proofs import prove
from exover.proofs.certify import certificate, render
from tests.support.diagrams import check_by_diagrams
from tests.support.engines import model_of

SPEC = """spec closed;
module m {
    state lock: int in 0 .. 2 = 0;
    request never() { check lock == 2; on ok set lock = 2; }
    request once() { check lock == 0; on ok set lock = 1; }
}
"""
Json = dict[str, Any]
NEVER, ONCE = ("reachability", "m.never"), ("lockout", "m.once")


@pytest.fixture(scope="module")
def built() -> Build:
    return build(model_of(SPEC))


@pytest.fixture(scope="module")
def made(built: Build) -> Json:
    """Return a certificate, made where no clauses are known that exclude anything."""
    findings = check_by_diagrams(built.compiled).findings
    kept = [each for each in findings if each.check in ("reachability", "deadlock", "lockout", "starvation")]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(prove, "invariant_clauses", lambda *asked: None)
        return certificate(built.compiled, built.data, kept, NO_PROPERTIES, "0", lambda what: None)


def finding(made: Json, which: tuple[str, str]) -> Json:
    (found,) = [each for each in made["findings"] if (each["check"], each["subject"]) == which]
    return found


def parts(made: Json, which: tuple[str, str]) -> list[Json]:
    found: list[Json] = finding(made, which)["proof"]["parts"]
    return found


def test_what_never_happens_is_proved_by_a_set(built: Build, made: Json) -> None:
    found = verify(built.data, read(render(made)), None, 20)
    kinds = {(f["check"], f["subject"]): [p and p["kind"] for p in f["proof"]["parts"]] for f in found.proved}
    assert kinds[NEVER] == ["closed"]
    assert kinds[ONCE] == ["run", None, "closed"]
    assert finding(made, NEVER)["verdict"] == finding(made, ONCE)["verdict"] == "violated"


BROKEN: dict[str, Callable[[Json], object]] = {
    "all states": lambda made: parts(made, NEVER)[0].update(states="true"),
    "no state": lambda made: parts(made, NEVER)[0].update(states="false"),
    "all states behind a run": lambda made: parts(made, ONCE)[2].update(states="true"),
    "no state behind a run": lambda made: parts(made, ONCE)[2].update(states="false"),
    "a run that does not lead there": lambda made: parts(made, ONCE)[0]["steps"].pop(),
    "no run": lambda made: parts(made, ONCE)[0].update(steps=[]),
    "a run from elsewhere": lambda made: parts(made, ONCE)[0].update({"from": 1}),
    "the set of an operator before": lambda made: parts(made, NEVER).__setitem__(0, None),
}


@pytest.mark.parametrize("what", BROKEN)
def test_a_set_that_proves_nothing_is_refused(built: Build, made: Json, what: str) -> None:
    changed = deepcopy(made)
    BROKEN[what](changed)
    with pytest.raises(Refused):
        verify(built.data, changed, None, 20)
