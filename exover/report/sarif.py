"""The findings in SARIF 2.1.0 (OASIS, Static Analysis Results Interchange Format, 2020), for viewers of other tools.

Paragraph numbers are those of that standard.
"""

from collections.abc import Mapping
from hashlib import sha256
from pathlib import PurePath
from typing import Any
from urllib.parse import quote

from exover.checks.finding import Finding
from exover.checks.questions import CHECKS, SEVERITY
from exover.loop.claim import Verdict
from exover.manual import Page, pages
from exover.model.event import Event, Observe
from exover.model.model import NOWHERE, Location, Model
from exover.model.trace import Trace
from exover.model.wire import escaped, indented
from exover.model.wording import action_text, event_text
from exover.report.policy import excuse_text
from exover.report.summary import Summary, Unchecked

SCHEMA = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"
KINDS: dict[Verdict, str] = {"holds": "pass", "violated": "fail", "unknown": "open"}
FINGERPRINT = "exover/v1"
IFF = {check.name: check.iff for check in CHECKS}
"""By check, the condition under which its finding holds."""


def render(summary: Summary, timings: bool = False) -> str:
    """Return a log of one run as text with a final newline; it has seconds only with `timings`."""
    return written([run_of(summary, timings)])


def written(runs: list[dict[str, Any]]) -> str:
    """Return a log of these runs as text with a final newline."""
    log = {"$schema": SCHEMA, "version": "2.1.0", "runs": runs}
    return indented(log)


def run_that_failed(unchecked: Unchecked) -> dict[str, Any]:
    """Return a run without results, for a spec that could not be checked (3.20.21)."""
    place = location_of(NOWHERE, unchecked.file)
    notice = {"level": "error", "message": {"text": unchecked.reason}, "locations": [place]}
    return {
        "tool": {"driver": {"name": "exover", "version": unchecked.version, "rules": []}},
        "invocations": [{"executionSuccessful": False, "toolExecutionNotifications": [notice]}],
        "results": [],
    }


def run_of(summary: Summary, timings: bool) -> dict[str, Any]:
    """Return the run object for a spec."""
    checks = {finding.check: finding.severity for finding in summary.findings}
    checks |= {check: SEVERITY[check] for check in summary.skipped if check not in checks}
    numbers = {check: number for number, check in enumerate(checks)}
    return {
        "tool": {
            "driver": {
                "name": "exover",
                "version": summary.version,
                "rules": [_rule(check, severity) for check, severity in checks.items()],
            }
        },
        "automationDetails": {"id": f"exover/{summary.model.name}/"},
        "invocations": [{"executionSuccessful": True, **_disabled(summary, numbers)}],
        "columnKind": "unicodeCodePoints",
        "results": [_result(summary, finding, numbers[finding.check], timings) for finding in summary.findings],
        "properties": {"spec": summary.model.name, "verdict": summary.verdict, **_skipped(summary)},
    }


def _disabled(summary: Summary, numbers: Mapping[str, int]) -> dict[str, Any]:
    """Return the overrides that disable the rules of checks that were not asked (3.20.5); empty if all were."""
    rules = [{"id": f"exover/{check}", "index": numbers[check]} for check in summary.skipped]
    off = [{"descriptor": rule, "configuration": {"enabled": False}} for rule in rules]
    return {"ruleConfigurationOverrides": off} if off else {}


def _skipped(summary: Summary) -> dict[str, Any]:
    return {"skipped": list(summary.skipped)} if summary.skipped else {}


def _rule(check: str, severity: str) -> dict[str, Any]:
    page = pages().get(check, Page(check, "", "the pages are not installed", ""))
    return {
        "id": f"exover/{check}",
        "shortDescription": {"text": f"{check}: {IFF[check]}"},
        "helpUri": page.uri,
        "help": {"text": page.text, "markdown": page.markdown},
        "defaultConfiguration": {"level": severity},
    }


def _result(summary: Summary, finding: Finding, rule: int, timings: bool) -> dict[str, Any]:
    kind = KINDS[finding.verdict]
    trace, excuse = finding.trace, finding.excuse
    known = *finding.key, finding.verdict
    measured = {"seconds": round(finding.seconds, 6)} if timings else {}
    return {
        "ruleId": f"exover/{finding.check}",
        "ruleIndex": rule,
        "kind": kind,
        "level": finding.severity if kind == "fail" else "none",  # 3.27.10: only a failure has a level
        "message": {"text": f"{finding.subject}: {finding.message}"},
        "locations": [location_of(finding.location, summary.file)],
        "partialFingerprints": {FINGERPRINT: fingerprint_of(summary.model.name, *known)},
        **({"codeFlows": [_flow(summary, trace)]} if trace and trace.moments else {}),
        # 3.27.23 and 3.27.24: all results of a run have these, or none has.
        "suppressions": [_suppression(excuse_text(excuse))] if excuse else [],
        **({"baselineState": finding.standing} if finding.standing else {}),
        "properties": {"subject": finding.subject, "engine": finding.engine, "method": finding.method, **measured},
    }


def fingerprint_of(*known: str) -> str:
    """Return the fingerprint of a result: a hash of these texts, which do not change when lines are moved."""
    return sha256(escaped("\0".join(known)).encode("utf-8")).hexdigest()


def _suppression(justification: str) -> dict[str, str]:
    return {"kind": "external", "status": "accepted", "justification": justification}


def location_of(declared: Location, file: str) -> dict[str, Any]:
    """Return the location object of a declaration; one without a file is in `file`."""
    region = {"region": {"startLine": declared.line, "startColumn": declared.column}} if declared.line else {}
    return {"physicalLocation": {"artifactLocation": {"uri": uri(declared.file or file)}, **region}}


def uri(file: str) -> str:
    """Return a file name as a URI: relative to where the command was run, as the name is, or absolute."""
    path = PurePath(file)
    return path.as_uri() if path.is_absolute() else quote(path.as_posix(), errors="surrogateescape")


def _flow(summary: Summary, trace: Trace) -> dict[str, Any]:
    """Return a run as a code flow of one thread: its steps, each at the declaration of what its event is about."""
    steps = []
    for moment in trace.moments:
        answers = [action_text(summary.model, action) for action in moment.actions]
        text = "; ".join([event_text(summary.model, moment.event), *answers])
        declared = location_of(_declared(summary.model, moment.event), summary.file)
        steps.append({"location": {**declared, "message": {"text": text}}})
    again = {} if trace.loop_start is None else {"properties": {"loopStart": trace.loop_start}}
    return {"threadFlows": [{"locations": steps, **again}]}


def _declared(model: Model, event: Event) -> Location:
    """Return where the request, poster or consumable of an event is declared."""
    if not isinstance(event, Observe):
        return model.request[event.request].location
    if event.name in model.variable:
        return model.variable[event.name].location
    return model.resource[event.name].location
