"""The policy of a project on findings: waivers, and a baseline of findings that were known before.

No waiver excuses what a checked spec guarantees (docs/language.md section 6), and no baseline excuses an error.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from datetime import date
from typing import Any, assert_never

from exover.checks.finding import Baselined, BaselineStanding, Excuse, Finding, FindingKey, Waived
from exover.dataclass import dataclass
from exover.diagnostics import Severity
from exover.loop.claim import VERDICTS, Verdict, worst
from exover.model.model import Location
from exover.report.json import UnreadableReport, loaded

WAIVABLE_ERRORS = frozenset({"reachability", "deadlock", "obligation", "property"})
"""The errors that may be waived for a while: nothing unsafe happens, but something that is wanted does not."""


@dataclass(frozen=True, slots=True)
class Waiver:
    """A waiver: it excuses the finding of a check and subject, of one spec or of all, through the day `expires`."""

    check: str
    subject: str
    reason: str
    expires: date
    spec: str | None
    location: Location

    @property
    def title(self) -> str:
        """The waiver in a message."""
        where = self.location
        return f"{where.file}:{where.line}: the waiver of {self.check} {self.subject}"


Baseline = Mapping[FindingKey, Verdict]
"""The verdicts of an earlier report by check and subject."""


@dataclass(frozen=True, slots=True)
class Policy:
    """The waivers in the order of their file, and the baseline, if there is one."""

    waivers: tuple[Waiver, ...] = ()
    baseline: Baseline | None = None


def waivable(check: str, severity: Severity) -> bool:
    """Return whether findings of a check may be waived."""
    return severity != "error" or check in WAIVABLE_ERRORS


def judge(findings: Iterable[Finding], policy: Policy, spec: str, today: date) -> tuple[Finding, ...]:
    """Return the findings with their standing against the baseline and, if they have one, their excuse.

    A finding that does not hold is excused by its first waiver that has not expired, if it may be waived; else iff it
    is no error and the baseline has it with the same verdict or a worse one.
    """
    waivers: dict[FindingKey, Waived] = {}
    for waiver in _of(policy, spec):
        if waiver.expires >= today:
            waivers.setdefault((waiver.check, waiver.subject), Waived(waiver.reason, waiver.expires))

    def judged(finding: Finding) -> Finding:
        standing = _standing(finding, policy.baseline)
        excuse: Excuse | None = None
        if finding.verdict != "holds":
            waived = waivers.get(finding.key)
            excuse = waived if waivable(finding.check, finding.severity) else None
            excuse = excuse or (Baselined() if _known(finding, policy.baseline) else None)
        return replace(finding, standing=standing, excuse=excuse)

    return tuple(map(judged, findings))


def remarks(findings: Iterable[Finding], policy: Policy, spec: str, today: date) -> Iterator[str]:
    """Yield a warning for each waiver of a spec that has expired, or that matches no open finding."""
    open_findings = {finding.key for finding in findings if finding.verdict != "holds"}
    for waiver in _of(policy, spec):
        if waiver.expires < today:
            yield f"{waiver.title} expired on {waiver.expires.isoformat()}: it no longer counts"
        elif (waiver.check, waiver.subject) not in open_findings:
            yield f"{waiver.title} matches nothing: no such finding of {spec} is open"


def _of(policy: Policy, spec: str) -> Iterator[Waiver]:
    return (waiver for waiver in policy.waivers if waiver.spec in (None, spec))


def _standing(finding: Finding, baseline: Baseline | None) -> BaselineStanding | None:
    if baseline is None:
        return None
    former = baseline.get(finding.key)
    if former is None:
        return "new"
    return "unchanged" if former == finding.verdict else "updated"


def _known(finding: Finding, baseline: Baseline | None) -> bool:
    if baseline is None or finding.severity == "error":
        return False
    former = baseline.get(finding.key, "holds")
    return worst((former, finding.verdict)) == former


def excuse_text(excuse: Excuse) -> str:
    """Return an excuse in words."""
    match excuse:
        case Waived(reason, expires):
            return f"waived until {expires.isoformat()}: {reason}"
        case Baselined():
            return "known: the baseline has it"
        case _:
            assert_never(excuse)


def read_baseline(text: str, spec: str, file: str = "") -> Baseline:
    """Return the verdicts of a report of `exover check --format json` about a spec.

    Raises `UnreadableReport` for any other text.

    In a report about several specs, the part of this spec counts, preferably of this file; empty if there is none.
    """
    report = loaded(text)
    if isinstance(report, dict) and isinstance(report.get("specs"), list):
        report = _part(report["specs"], spec, file)
    found = report.get("findings") if isinstance(report, dict) and report.get("tool") == "exover" else None
    if not isinstance(found, list):
        raise UnreadableReport("it is no report of `exover check --format json`")
    if report.get("spec") != spec:
        raise UnreadableReport(f"it is about the spec {report.get('spec')}, not {spec}")
    return dict(map(_entry, found))


def _part(reports: list[Any], spec: str, file: str) -> dict[str, Any]:
    """Return the report of a spec among several, preferably of this file; one without findings if there is none."""
    mine = [each for each in reports if isinstance(each, dict) and each.get("spec") == spec and "findings" in each]
    mine.sort(key=lambda each: each.get("file") != file)
    return mine[0] if mine else {"tool": "exover", "spec": spec, "findings": []}


def _entry(finding: Any) -> tuple[FindingKey, Verdict]:
    if isinstance(finding, dict):
        check, subject, verdict = (finding.get(key) for key in ("check", "subject", "verdict"))
        for known in VERDICTS:
            if isinstance(check, str) and isinstance(subject, str) and verdict == known:
                return (check, subject), known
    raise UnreadableReport("one of its findings has no check, subject or verdict")
