"""A report on several specs: a part for each, made by the process that checked the spec, and their join."""

from collections import Counter
from collections.abc import Sequence
from typing import Any, Literal, assert_never

from exover import __version__
from exover.escaping import visible
from exover.loop.claim import VERDICTS, Verdict, worst
from exover.model.wire import indented
from exover.model.wording import counted
from exover.report import github, json, junit, sarif, text
from exover.report.summary import Summary, Unchecked

ReportFormat = Literal["text", "json", "sarif", "junit", "github"]


def part(report: Summary | Unchecked, form: ReportFormat, timings: bool) -> Any:
    """Return the part of one spec in a report of this format, for `joined`."""
    if isinstance(report, Unchecked):
        return _unchecked(report, form, timings)
    match form:
        case "text":
            return text.render(report, timings)
        case "json":
            return json.document(report, timings)
        case "sarif":
            return sarif.run_of(report, timings)
        case "junit":
            return junit.suites_of(report, timings, f"{report.model.name}.")
        case "github":
            return github.render(report, timings)
        case _:
            assert_never(form)


def _unchecked(report: Unchecked, form: ReportFormat, timings: bool) -> Any:
    match form:
        case "text":
            return visible(f"{report.file}: not checked: {report.reason}") + "\n"
        case "json":
            return _document(report)
        case "sarif":
            return sarif.run_that_failed(report)
        case "junit":
            return junit.suite_that_failed(report, timings)
        case "github":
            return github.error(report.file, report.reason)
        case _:
            assert_never(form)


def _document(unchecked: Unchecked) -> dict[str, Any]:
    return {"file": unchecked.file, "verdict": unchecked.verdict, "error": unchecked.reason}


def joined(parts: Sequence[Any], verdicts: Sequence[Verdict], form: ReportFormat, timings: bool) -> str:
    """Return the report that joins these parts, with a final newline."""
    match form:
        case "text":
            return "\n".join([*parts, _last(verdicts)])
        case "json":
            told = {"tool": "exover", "version": __version__, "verdict": worst(verdicts), "specs": list(parts)}
            return indented(told)
        case "sarif":
            return sarif.written(list(parts))
        case "junit":
            return junit.written("exover", parts, timings)
        case "github":
            return "".join([*parts, _last(verdicts)])
        case _:
            assert_never(form)


def _last(verdicts: Sequence[Verdict]) -> str:
    counts = Counter(verdicts)
    words = {each: "hold" if each == "holds" and counts[each] > 1 else each for each in VERDICTS}
    told = [f"{counts[each]} {words[each]}" for each in VERDICTS if counts[each]]
    return f"{counted(len(verdicts), 'spec')}: {', '.join(told)}\n"
