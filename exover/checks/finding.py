"""What a check found out, as a value."""

from datetime import date
from typing import Literal

from exover.dataclass import dataclass
from exover.diagnostics import Severity
from exover.loop.claim import Verdict
from exover.model.model import Location
from exover.model.trace import Trace

SEVERITIES: tuple[Severity, ...] = ("error", "warning", "note")
FindingWord = Literal["ok", "violated", "warning", "note", "unknown"]
"""What people are told of a finding: only what decides a verdict is violated."""
BaselineStanding = Literal["new", "unchanged", "updated"]
"""How a finding stands to the baseline: not in it, with the same verdict, with another one."""


@dataclass(frozen=True, slots=True)
class Counted:
    """How many states are reachable, or why that is not known."""

    number: int | None
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Waived:
    """A waiver excuses the finding, through the day on which it expires."""

    reason: str
    expires: date


@dataclass(frozen=True, slots=True)
class Baselined:
    """The baseline has the finding already, and no better."""


Excuse = Waived | Baselined
"""Why a finding that does not hold does not count all the same."""


@dataclass(frozen=True, slots=True)
class Finding:
    """The answer of one check for one subject (docs/checks.md).

    `method` says how a `holds` was proved, `message` what was found, for a reader who knows the spec and not the tool.
    `seconds` is wall-clock time spent on this finding. `standing` is there if there is a baseline.
    """

    check: str
    subject: str
    severity: Severity
    verdict: Verdict
    engine: str
    method: str
    message: str
    location: Location
    trace: Trace | None = None
    seconds: float = 0.0
    standing: BaselineStanding | None = None
    excuse: Excuse | None = None

    @property
    def word(self) -> FindingWord:
        """What people are told of the finding."""
        return word(self.severity, self.verdict)


def word(severity: Severity, verdict: Verdict) -> FindingWord:
    """Return what people are told of a finding of this severity with this verdict."""
    if verdict == "violated":
        return "violated" if severity == "error" else severity
    return "ok" if verdict == "holds" else verdict
