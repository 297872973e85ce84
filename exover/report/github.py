"""The findings as workflow commands of GitHub Actions, which annotates the lines of the spec with them."""

from collections.abc import Iterator, Mapping

from exover.checks.finding import Finding
from exover.diagnostics import Severity
from exover.report import text
from exover.report.policy import excuse_text
from exover.report.story import story_lines, story_of
from exover.report.summary import Summary

COMMANDS: dict[Severity, str] = {"error": "error", "warning": "warning", "note": "notice"}
DATA = {"%": "%25", "\r": "%0D", "\n": "%0A"}
PROPERTY = {**DATA, ":": "%3A", ",": "%2C"}


def render(summary: Summary, timings: bool = False) -> str:
    """Return a command for each finding that does not hold, then the last line of the text report, each with a newline.

    Findings that are excused, and checks not asked, are notices. `timings` is ignored: no command shows times.
    """
    commands = [_command(summary, finding) for finding in summary.findings if finding.verdict != "holds"]
    if summary.skipped:
        commands.append(f"::notice title=checks not asked::{_escaped(', '.join(summary.skipped), DATA)}")
    return "".join(f"{line}\n" for line in (*commands, text.last_line(summary)))


def error(file: str, reason: str) -> str:
    """Return the command for a spec that could not be checked, with a newline."""
    return f"::error file={_escaped(file, PROPERTY)},title=not checked::{_escaped(reason, DATA)}\n"


def _command(summary: Summary, finding: Finding) -> str:
    location = finding.location
    properties = {"file": location.file or summary.file}
    if location.line:
        properties |= {"line": str(location.line), "col": str(location.column)}
    properties["title"] = f"{finding.check} {finding.subject} {finding.word}"
    listed = ",".join(f"{name}={_escaped(value, PROPERTY)}" for name, value in properties.items())
    command = "notice" if finding.excuse else COMMANDS[finding.severity]
    return f"::{command} {listed}::{_escaped(chr(10).join(_message(summary, finding)), DATA)}"


def _message(summary: Summary, finding: Finding) -> Iterator[str]:
    yield finding.message
    if finding.excuse:
        yield excuse_text(finding.excuse)
    if finding.trace is not None:
        yield from story_lines(story_of(summary.model, finding.trace))


def _escaped(value: str, signs: Mapping[str, str]) -> str:
    return "".join(signs.get(sign, sign) for sign in value)
