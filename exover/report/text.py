"""The text report: findings that do not hold first, with the runs that show them, then counts and tables."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping

from exover.checks.finding import SEVERITIES, Baselined, Counted, Finding, FindingKey, Waived
from exover.escaping import visible_lines
from exover.loop.claim import VERDICTS, Verdict
from exover.model.model import Model
from exover.model.property import Properties
from exover.model.trace import Trace
from exover.model.wording import counted
from exover.report.grouped import grouped
from exover.report.policy import excuse_text
from exover.report.story import story_lines, story_of
from exover.report.summary import BoundFigures, Summary, overall

LONG = 200
"""A finding with more characters than this is broken into lines, one for each part of its message."""


def render(summary: Summary, timings: bool = False) -> str:
    """Return the report with a final newline; it has seconds only with `timings`."""
    return visible_lines(_lines(summary, timings))


def _lines(summary: Summary, timings: bool) -> Iterator[str]:
    model, tables = summary.model, summary.tables
    requests = counted(summary.figures.requests, "request")
    yield f"{summary.file}: spec {model.name}, {requests}, {counted(summary.figures.rules, 'rule')}"
    if summary.properties is not None:
        yield f"properties: {_properties(summary.properties)}"
    yield ""
    groups: dict[str, list[Finding]] = {}
    for finding in summary.findings:
        groups.setdefault(finding.check, []).append(finding)
    causes = grouped(summary.findings)
    effects = _effects(summary.findings, causes)
    shown: dict[Trace, Finding] = {}
    for check, group in sorted(groups.items(), key=lambda item: VERDICTS.index(_worst(item[1]))):
        yield _counts(summary, check, group, causes, timings)
        for finding in _told(group, causes):
            yield from _finding(summary.model, finding, effects.get(finding.key, ()), shown)
    if summary.skipped:
        yield f"not asked: {', '.join(summary.skipped)}"
    yield ""
    yield from _engines(summary.findings)
    if summary.figures.state_bits is None:
        yield "state bits: unknown, for the time was over, or the loop is too large for decision diagrams"
    if summary.figures.states is not None:
        yield f"states: {_states(summary.figures.states)}"
    if tables is None:
        yield "tables: none, the command ended before they were made"
    else:
        yield (
            f"tables: {counted(tables.nodes, 'node')}, depth {tables.depth}, "
            f"{counted(tables.tests, 'test')} before the first action, "
            f"{counted(tables.bytes, 'byte')}, {counted(tables.ram_bytes, 'byte')} of RAM"
        )
        if tables.bounds:
            yield from _bounds(tables.bounds)
    yield last_line(summary)


def _properties(properties: Properties) -> str:
    """Return the properties file with the number of its properties, or where none was found."""
    if properties.file is None:
        return "none, no .prop file of this spec was found beside it, in properties/ or in ../properties/"
    parts = [counted(len(properties.properties), "property", "properties")]
    assumptions = len(properties.assumptions) + properties.fair
    parts += [counted(assumptions, "assumption")] if assumptions else []
    return ", ".join([properties.file, *parts])


def _bounds(bounds: BoundFigures) -> Iterator[str]:
    (tests, most), (answers, more), (passes, last) = (
        bounds.worst("tests"),
        bounds.worst("answers"),
        bounds.worst("passes"),
    )
    yield (
        f"bounds: an event takes at most {counted(tests, 'test')} ({most}), {counted(answers, 'answer')} ({more}) and "
        f"{counted(passes, 'pass', 'passes')} ({last}), by {bounds.method}"
    )
    yield f"stack: a call takes at most {counted(bounds.stack_bytes, 'byte')} with {bounds.stack_target}"


def _engines(findings: Iterable[Finding]) -> Iterator[str]:
    """Yield how many findings each engine has answered, unless the engine `bdd` has answered all."""
    answered = Counter(finding.engine for finding in findings if finding.verdict != "unknown")
    if answered.keys() - {"bdd"}:
        yield from (f"answered by {engine}: {counted(number, 'finding')}" for engine, number in answered.items())


def _states(states: Counted) -> str:
    return f"unknown, {states.reason}" if states.number is None else f"{states.number} reachable"


def _worst(group: list[Finding]) -> Verdict:
    return overall(group, frozenset(SEVERITIES))


def _effects(findings: Iterable[Finding], causes: Mapping[FindingKey, Finding]) -> dict[FindingKey, list[Finding]]:
    """Return for the key of each cause the findings that are told under it, in their order."""
    effects: dict[FindingKey, list[Finding]] = {}
    for finding in findings:
        if finding.key in causes:
            effects.setdefault(causes[finding.key].key, []).append(finding)
    return effects


def _counts(
    summary: Summary, check: str, group: list[Finding], causes: Mapping[FindingKey, Finding], timings: bool
) -> str:
    """Return the line of counts of a check; `causes`: as `grouped` returns them."""
    parts = ", ".join(
        _part([each for each in group if each.verdict == verdict], causes)
        for verdict in VERDICTS
        if any(each.verdict == verdict for each in group)
    )
    methods = dict.fromkeys(finding.method for finding in group if finding.verdict == "holds")
    proof = f" ({', '.join(methods)})" if methods else ""
    seconds = f", {sum(finding.seconds for finding in group):.3f} s" if timings else ""
    alone = ", of the assumptions alone" if check in summary.skipped else ""
    return f"{check}: {parts}{proof}{alone}{seconds}"


def _told(group: Iterable[Finding], causes: Mapping[FindingKey, Finding]) -> list[Finding]:
    """Return the findings that do not hold, violated ones first, but for those in `causes`."""
    told = [finding for finding in group if finding.verdict != "holds" and finding.key not in causes]
    return sorted(told, key=lambda finding: VERDICTS.index(finding.verdict))


def _part(alike: list[Finding], causes: Mapping[FindingKey, Finding]) -> str:
    """Return the number of findings, all with one word, and the checks under which some of them are told."""
    word = alike[0].word
    count = counted(len(alike), word) if word in SEVERITIES else f"{len(alike)} {word}"
    elsewhere = [causes[finding.key].check for finding in alike if finding.key in causes]
    if not elsewhere:
        return count
    number = "" if len(elsewhere) == len(alike) else f"{len(elsewhere)} "
    return f"{count}, {number}told under {', '.join(dict.fromkeys(elsewhere))}"


def _finding(model: Model, finding: Finding, others: Iterable[Finding], shown: dict[Trace, Finding]) -> Iterator[str]:
    """Yield the lines of a finding; `others`: of the same cause; `shown`: by run that is printed, its finding."""
    where = finding.location
    place = f" at {where}" if where.line else ""
    yield from _in_lines(f"  {finding.subject} {finding.word}{place}: {finding.message}")
    also = ", ".join(f"{other.check} {other.subject}" for other in others)
    if also:
        yield f"    the same cause: {also}"
    if finding.excuse is not None:
        yield f"    {excuse_text(finding.excuse)}"
    if finding.trace is None:
        return
    before = shown.setdefault(finding.trace, finding)
    if before is finding or not finding.trace.moments:
        yield from (f"    {line}" for line in story_lines(story_of(model, finding.trace)))
    else:
        yield f"    by the run of {before.check} {before.subject}"


def _in_lines(told: str) -> Iterator[str]:
    """Yield the lines of a finding: one, or one for each part if it is long."""
    parts = told.split("; ") if len(told) > LONG else [told]
    for number, part in enumerate(parts):
        yield f"{'      ' if number else ''}{part}{';' if number + 1 < len(parts) else ''}"


def last_line(summary: Summary) -> str:
    """Return the name of the spec and the verdict over all, with the counts behind it."""
    skipped = f"; {counted(len(summary.skipped), 'check')} not asked" if summary.skipped else ""
    return f"{summary.model.name}: {_outcome(summary)}{skipped}"


def _outcome(summary: Summary) -> str:
    total = len(summary.findings)
    holding = sum(finding.verdict == "holds" for finding in summary.findings)
    if holding == total:
        return f"holds: all of {counted(total, 'finding')}"
    unmet = [finding for finding in summary.findings if finding.verdict != "holds" and not finding.excuse]
    violated = [finding.severity for finding in unmet if finding.verdict == "violated"]
    parts = [counted(violated.count(s), s) for s in SEVERITIES if s in violated]
    excuses = [type(finding.excuse) for finding in summary.findings]
    others = {
        "unknown": len(unmet) - len(violated),
        "waived": excuses.count(Waived),
        "known": excuses.count(Baselined),
    }
    parts += [f"{count} {word}" for word, count in others.items() if count]
    return f"{summary.verdict}: {', '.join(parts)}; {holding} of {counted(total, 'finding')} ok"
