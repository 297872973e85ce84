"""Specs as teams write them: what is known of each stands in its `// expect:` lines.

Errors are listed completely. Of warnings and notes only what somebody put there or has argued for is listed. Here only
errors are asked for, until a few are answered; that tables hold and that the start is consistent is asked apart, to the
end. `make known` asks for all and gives a minute for each spec; `make teams` gives more time, and wants all to be
answered.
"""

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from time import monotonic

import pytest

from benchmarks.engines import TEAMS
from exover.checks.finding import Finding
from exover.checks.questions import CHECKS
from exover.checks.run import NOBODY, Audience, Nobody, check_all
from exover.checks.schedule.engines import PORTFOLIO, Engines
from exover.checks.schedule.plan import CheckPlan
from exover.cli.files import read_properties, read_spec
from exover.engines.aig.abc import prover
from exover.engines.process import NotRunnable
from exover.limits import limits_from
from exover.model.semantics import Reference
from exover.model.trace import run
from exover.pipeline import build
from tests.checks.work import silent
from tests.support.diagrams import check_by_diagrams
from tests.support.expected import expected

SPECS = [Path(__file__).parents[1] / "specs" / f"{name}.exo" for name in TEAMS]
WHOLE = "EXOVER_TEAMS" in os.environ
"""Whether everything is asked; the variable says for how many seconds."""
ANSWERED = "EXOVER_ANSWERED" in os.environ
"""Whether everything has to be answered."""
SECONDS, JOBS = float(os.environ.get("EXOVER_TEAMS", "120")), 2 if WHOLE else 1
APART = {"tables", "consistency"}
"""What the rules themselves answer at once."""
ASKED = None if WHOLE else {check.name for check in CHECKS if check.severity == "error"} - APART
FEW = 6
"""Answers after which nothing more is asked, unless all is."""


class Asker(Nobody):
    """Somebody who presses Ctrl-C after a few answers."""

    answers = 0

    def finds(self, finding: Finding) -> None:
        """Count what is known."""
        self.answers += finding.verdict != "unknown"
        if self.answers == FEW:
            raise KeyboardInterrupt


def engines() -> Engines:
    """Return the engines that are asked by default here."""
    try:
        return replace(PORTFOLIO, abc=prover.find())
    except NotRunnable:
        return PORTFOLIO


def named(findings: Sequence[Finding]) -> set[str]:
    return {f"{finding.check} {finding.subject} {finding.verdict}" for finding in findings}


@pytest.mark.parametrize("path", SPECS, ids=TEAMS)
def test_a_spec_has_the_findings_that_are_expected(path: Path) -> None:
    model = read_spec(str(path))
    properties = read_properties(str(path), None, model)
    limits = limits_from(monotonic(), JOBS, SECONDS)
    made = build(model).compiled
    audience: Audience = NOBODY if WHOLE else Asker()
    plan = CheckPlan(ASKED, properties, engines())
    found = check_all(made, silent, plan, limits=limits, audience=audience).findings
    wanted = expected(path)

    unanswered = {(finding.check, finding.subject) for finding in found if finding.verdict == "unknown"}
    asked = {finding.check for finding in found}
    known = {line for line in wanted if line.split()[0] in asked}
    known -= {line for line in known if (line.split()[0], " ".join(line.split()[1:-1])) in unanswered}
    assert not (ANSWERED and unanswered)
    assert len(found) - len(unanswered) >= FEW
    assert known <= named(found)
    violated = [finding for finding in found if finding.verdict == "violated"]
    assert named([finding for finding in violated if finding.severity == "error"]) <= wanted
    for finding in violated:
        if finding.trace:
            trace = finding.trace
            assert run(Reference(model), trace.events, trace.loop_start) == trace


@pytest.mark.parametrize("path", SPECS, ids=TEAMS)
def test_the_tables_of_a_spec_hold_and_it_starts_consistent(path: Path) -> None:
    found = check_by_diagrams(build(read_spec(str(path))).compiled, APART).findings
    assert {finding.check for finding in found} == APART
    assert {finding.verdict for finding in found} == {"holds"}


def test_a_spec_of_a_team_has_properties() -> None:
    assert [path for path in SPECS if not path.with_suffix(".prop").exists()] == []
