"""What a check found out, as a value."""

from dataclasses import dataclass
from typing import Literal

from exover.model.model import Location
from exover.model.trace import Trace

Severity = Literal["error", "warning", "note"]
Verdict = Literal["holds", "violated", "unknown"]


@dataclass(frozen=True, slots=True)
class Finding:
    """The answer of one check for one subject (docs/checks.md).

    `method` says how a `holds` was proved, `message` what was found, for a reader who knows the spec and not the tool.
    `seconds` is wall-clock time spent on this finding.
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
