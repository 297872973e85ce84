"""Findings, the answers of checks, as values."""

from datetime import date
from typing import Literal

from exover.dataclass import dataclass
from exover.diagnostics import Severity
from exover.loop.claim import Verdict
from exover.model.model import Location
from exover.model.trace import Trace

SEVERITIES: tuple[Severity, ...] = ("error", "warning", "note")
FindingWord = Literal["ok", "violated", "warning", "note", "unknown"]
"""The word for a finding in reports: only a violated check of severity `error` is called violated."""
BaselineStanding = Literal["new", "unchanged", "updated"]
"""How a finding stands to the baseline: not in it, with the same verdict, with another one."""
FindingKey = tuple[str, str]
"""The check and the subject of a finding, unique in a report."""


@dataclass(frozen=True, slots=True)
class Counted:
    """The number of reachable states, or the reason why it is not known."""

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
"""Why a finding that does not hold does not count."""


@dataclass(frozen=True, slots=True)
class Finding:
    """The answer of one check for one subject (docs/checks.md).

    `method` says how a `holds` was proved, `message` what was found, for a reader who knows the spec and not the tool.
    `seconds` is wall-clock time spent on this finding. `standing` is there if there is a baseline. `exhausted`: it is
    `unknown` since its engine has taken all the steps, or all the memory, that it may take.
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
    exhausted: bool = False

    @property
    def key(self) -> FindingKey:
        """The check and the subject."""
        return self.check, self.subject

    @property
    def word(self) -> FindingWord:
        """The word for the finding in reports."""
        return word(self.severity, self.verdict)


def word(severity: Severity, verdict: Verdict) -> FindingWord:
    """Return the word in reports for a finding of this severity with this verdict."""
    if verdict == "violated":
        return "violated" if severity == "error" else severity
    return "ok" if verdict == "holds" else verdict
