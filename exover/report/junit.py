"""The findings as JUnit XML: a suite for each check, a case for each subject.

A finding that decides the verdict is a failure or an error, one that does not hold but does not count is skipped: so
the file has the verdict of the command.
"""

import re
from collections.abc import Iterator, Sequence
from html import escape

from exover.checks.finding import Finding
from exover.dataclass import dataclass
from exover.report.policy import excuse_text
from exover.report.story import story_lines, story_of
from exover.report.summary import Summary, Unchecked

KEYS = ("tests", "failures", "errors", "skipped", "seconds")
FORBIDDEN = "[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]"
"""The characters that XML 1.0 forbids, even escaped."""


Counts = dict[str, float]
"""By KEYS: the number of cases, how many end in each way, and the seconds of all."""


@dataclass(frozen=True, slots=True)
class Suites:
    """The suites of a spec as lines, with their counts."""

    counts: Counts
    lines: tuple[str, ...]


def render(summary: Summary, timings: bool = False) -> str:
    """Return the document with a final newline; it has times only with `timings`."""
    return written(summary.model.name, [suites_of(summary, timings)], timings)


def written(name: str, parts: Sequence[Suites], timings: bool) -> str:
    """Return the document with the suites of one spec or several, with a final newline."""
    whole = {key: sum(part.counts[key] for part in parts) for key in KEYS}
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', f"<testsuites{_head(name, whole, timings)}>"]
    lines += [line for part in parts for line in part.lines]
    return "".join(f"{line}\n" for line in (*lines, "</testsuites>"))


def suites_of(summary: Summary, timings: bool, prefix: str = "") -> Suites:
    """Return a suite for each check, named by the prefix and the check."""
    groups: dict[str, list[Finding]] = {}
    for finding in summary.findings:
        groups.setdefault(finding.check, []).append(finding)
    lines = []
    for check, findings in groups.items():
        lines.append(f"<testsuite{_head(prefix + check, _counts(summary, findings), timings)}>")
        for finding in findings:
            lines += _case(summary, finding, timings)
        lines.append("</testsuite>")
    for check in summary.skipped:
        lines += _not_asked(summary, check, timings, prefix)
    return Suites(_counts(summary, summary.findings, len(summary.skipped)), tuple(lines))


def suite_that_failed(unchecked: Unchecked, timings: bool) -> Suites:
    """Return a suite with one case, an error, for a spec that could not be checked."""
    counts: Counts = {**dict.fromkeys(KEYS, 0), "tests": 1, "errors": 1}
    case = _attributes(classname=unchecked.file, name="check", file=unchecked.file)
    error = f"<error{_attributes(message=unchecked.reason)}/>"
    head = f"<testsuite{_head(unchecked.file, counts, timings)}>"
    return Suites(counts, (head, f"<testcase{case}>{error}</testcase>", "</testsuite>"))


def _not_asked(summary: Summary, check: str, timings: bool, prefix: str) -> Iterator[str]:
    """Yield a suite with one skipped case, for a check that was not asked."""
    case = _attributes(classname=f"{summary.model.name}.{check}", name=check, file=summary.file)
    yield f"<testsuite{_head(prefix + check, _counts(summary, (), 1), timings)}>"
    yield f"<testcase{case}><skipped{_attributes(message='not asked')}/></testcase>"
    yield "</testsuite>"


def _counts(summary: Summary, findings: Sequence[Finding], not_asked: int = 0) -> Counts:
    outcomes = [_outcome(summary, finding) for finding in findings]
    return {
        "tests": len(findings) + not_asked,
        "failures": outcomes.count("failure"),
        "errors": outcomes.count("error"),
        "skipped": outcomes.count("skipped") + not_asked,
        "seconds": sum(finding.seconds for finding in findings),
    }


def _head(name: str, counts: Counts, timings: bool) -> str:
    *numbers, seconds = KEYS
    time = f"{counts[seconds]:.3f}" if timings else None
    return _attributes(name=name, **{key: counts[key] for key in numbers}, time=time)


def _outcome(summary: Summary, finding: Finding) -> str:
    """Return the name of the element in a case that did not pass, empty if it passed."""
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
    yield f"<{outcome}{_attributes(message=message, type=kind)}>{escape(_legal(run), quote=False)}</{outcome}>"
    yield "</testcase>"


def _attributes(**values: object) -> str:
    from xml.sax.saxutils import quoteattr  # imported late: it loads the modules for HTTP

    return "".join(f" {name}={quoteattr(_legal(str(value)))}" for name, value in values.items() if value is not None)


def _legal(text: str) -> str:
    return re.sub(FORBIDDEN, "\ufffd", text)
