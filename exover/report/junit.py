"""The findings as JUnit XML: a suite for each check, a case for each subject.

What decides the verdict fails; what does not hold and decides nothing is skipped, so that a reader of the file comes to
the verdict of the command.
"""

import re
from collections.abc import Iterator
from xml.sax.saxutils import escape, quoteattr

from exover.checks.finding import Finding
from exover.report.policy import excuse_text
from exover.report.story import story_lines, story_of
from exover.report.summary import Summary

FORBIDDEN = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What no XML 1.0 document may hold, escaped or not."""


def render(summary: Summary, timings: bool = False) -> str:
    """Return the document with a final newline; times are in it only with `timings`."""
    suites: dict[str, list[Finding]] = {}
    for finding in summary.findings:
        suites.setdefault(finding.check, []).append(finding)
    lines = ['<?xml version="1.0" encoding="UTF-8"?>']
    lines.append(f"<testsuites{_head(summary, summary.model.name, list(summary.findings), timings)}>")
    for check, findings in suites.items():
        lines.append(f"<testsuite{_head(summary, check, findings, timings)}>")
        for finding in findings:
            lines += _case(summary, finding, timings)
        lines.append("</testsuite>")
    lines.append("</testsuites>")
    return "".join(f"{line}\n" for line in lines)


def _head(summary: Summary, name: str, findings: list[Finding], timings: bool) -> str:
    outcomes = [_outcome(summary, finding) for finding in findings]
    seconds = sum(finding.seconds for finding in findings)
    return _attributes(
        name=name,
        tests=len(findings),
        failures=outcomes.count("failure"),
        errors=outcomes.count("error"),
        skipped=outcomes.count("skipped"),
        time=f"{seconds:.3f}" if timings else None,
    )


def _outcome(summary: Summary, finding: Finding) -> str:
    """Return the element that tells how a case ended, empty if it passed."""
    if finding.verdict == "holds":
        return ""
    if not summary.counts(finding):
        return "skipped"
    return "failure" if finding.verdict == "violated" else "error"


def _case(summary: Summary, finding: Finding, timings: bool) -> Iterator[str]:
    head = _attributes(
        classname=f"{summary.model.name}.{finding.check}",
        name=finding.subject,
        file=finding.location.file or summary.file,
        line=finding.location.line or None,
        time=f"{finding.seconds:.3f}" if timings else None,
    )
    outcome = _outcome(summary, finding)
    if not outcome:
        yield f"<testcase{head}/>"
        return
    why = f" ({excuse_text(finding.excuse)})" if finding.excuse else ""
    message = f"{finding.word}: {finding.message}{why}"
    kind = None if outcome == "skipped" else finding.verdict
    run = "" if finding.trace is None else "\n".join(story_lines(story_of(summary.model, finding.trace)))
    yield f"<testcase{head}>"
    yield f"<{outcome}{_attributes(message=message, type=kind)}>{escape(_legal(run))}</{outcome}>"
    yield "</testcase>"


def _attributes(**values: object) -> str:
    return "".join(f" {name}={quoteattr(_legal(str(value)))}" for name, value in values.items() if value is not None)


def _legal(text: str) -> str:
    return FORBIDDEN.sub("\ufffd", text)
