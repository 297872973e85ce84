"""Specs as teams write them: what is known of each stands in its `// expect:` lines.

Errors are listed completely. Of warnings and notes only what somebody put there or has argued for is listed. What has
no answer after a short time is left open here; `make teams` gives more of it, and wants all to be answered.
"""

import os
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from time import monotonic

import pytest

from benchmarks.engines import TEAMS
from exover.checks.engines import PORTFOLIO, Engines
from exover.checks.finding import Finding
from exover.checks.limits import limits_from
from exover.checks.run import check_all
from exover.cli.files import read_properties, read_spec
from exover.engines.aig import abc
from exover.engines.process import NotRunnable
from exover.model.semantics import Reference
from exover.model.trace import run
from exover.pipeline import build

SPECS = [Path(__file__).parents[1] / "specs" / f"{name}.exo" for name in TEAMS]
WHOLE = "EXOVER_TEAMS" in os.environ
"""Whether everything has to be answered."""
SECONDS = 600.0 if WHOLE else 30.0


def engines() -> Engines:
    """Return the engines that are asked by default here."""
    try:
        return replace(PORTFOLIO, abc=abc.find())
    except NotRunnable:
        return PORTFOLIO


def named(findings: Sequence[Finding]) -> set[str]:
    return {f"{finding.check} {finding.subject} {finding.verdict}" for finding in findings}


@pytest.mark.parametrize("path", SPECS, ids=TEAMS)
def test_a_spec_has_the_findings_that_are_expected(path: Path) -> None:
    model = read_spec(str(path))
    properties = read_properties(str(path), None, model)
    limits = limits_from(monotonic(), 2, SECONDS)
    made = build(model).compiled
    found = check_all(made, lambda what: None, properties=properties, limits=limits, engines=engines()).findings
    expected = set(re.findall(r"^// expect: (.*?)\s*$", path.read_text(encoding="utf-8"), re.MULTILINE))

    unanswered = {(finding.check, finding.subject) for finding in found if finding.verdict == "unknown"}
    known = {line for line in expected if (line.split()[0], " ".join(line.split()[1:-1])) not in unanswered}
    assert not (WHOLE and unanswered)
    assert known <= named(found)
    assert all(finding.verdict == "holds" for finding in found if finding.check == "tables")
    violated = [finding for finding in found if finding.verdict == "violated"]
    assert named([finding for finding in violated if finding.severity == "error"]) <= expected
    for finding in violated:
        if finding.trace:
            trace = finding.trace
            assert run(Reference(model), trace.events, trace.loop_start) == trace


def test_a_spec_of_a_team_has_properties() -> None:
    assert [path for path in SPECS if not path.with_suffix(".prop").exists()] == []
