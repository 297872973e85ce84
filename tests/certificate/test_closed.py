"""Sets of states that no step leaves prove what never happens: from the first moment, or from the end of a run."""

from collections.abc import Callable
from copy import deepcopy
from typing import Any

import pytest

from exover.certificate.table import Refused
from exover.certificate.verify import read, verify
from exover.checks.run import check_all
from exover.model.property import NO_PROPERTIES
from exover.pipeline import Build, build
from exover.proofs.certify import certificate, render
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
    findings = check_all(built.compiled, lambda what: None).findings
    kept = [each for each in findings if each.check in ("reachability", "deadlock", "lockout")]
    return certificate(built.compiled, built.data, kept, NO_PROPERTIES, "0", lambda what: None)


def finding(made: Json, which: tuple[str, str]) -> Json:
    (found,) = [each for each in made["findings"] if (each["check"], each["subject"]) == which]
    return found


def test_what_never_happens_is_proved_by_a_set(built: Build, made: Json) -> None:
    found = verify(built.data, read(render(made)), None, 20)
    kinds = {(f["check"], f["subject"]): (f["verdict"], f["proof"]["kind"]) for f in found.proved}
    assert kinds[NEVER] == kinds[ONCE] == ("violated", "closed")
    assert not finding(made, NEVER)["proof"]["steps"]
    assert finding(made, ONCE)["proof"]["steps"]


def elsewhere(made: Json) -> None:
    """Begin behind a run: from there nothing leads to the goal, but from the first moment it may."""
    steps = finding(made, ONCE)["proof"]["steps"]
    finding(made, NEVER)["proof"].update(steps=steps, states="(and (= reading.0 1) (= phase.0 0))")


BROKEN: dict[str, Callable[[Json], object]] = {
    "all states": lambda made: finding(made, NEVER)["proof"].update(states="true"),
    "no state": lambda made: finding(made, NEVER)["proof"].update(states="false"),
    "states behind a run": elsewhere,
    "all states behind a run": lambda made: finding(made, ONCE)["proof"].update(states="true"),
    "a run that does not lead there": lambda made: finding(made, ONCE)["proof"]["steps"].pop(),
    "no run": lambda made: finding(made, ONCE)["proof"].update(steps=[]),
    "two claims": lambda made: finding(made, NEVER)["claim"].update(always="true"),
}


@pytest.mark.parametrize("what", BROKEN)
def test_a_set_that_proves_nothing_is_refused(built: Build, made: Json, what: str) -> None:
    changed = deepcopy(made)
    BROKEN[what](changed)
    with pytest.raises(Refused):
        verify(built.data, changed, None, 20)
