"""The data of the page as one JSON object: findings, runs, rules, the interaction graph, the tables with names.

It is no public interface: page and object are written by the same version of exover.
"""

import json
from base64 import b64encode
from collections import Counter
from collections.abc import Iterable, Iterator

from exover.checks.finding import Finding, FindingWord
from exover.checks.questions import SEVERITY
from exover.emit.describe import Description
from exover.explain.source_text import written
from exover.graph.interactions import InteractionGraph, interactions
from exover.graph.words import told
from exover.manual import page
from exover.model.model import Location, Model, Parameter
from exover.model.trace import Moment
from exover.model.types import Enum, Type
from exover.model.wire import Json, answer_line, event_json
from exover.model.wire_reading import domain
from exover.ocrd.tables import Tables
from exover.page.rules import RuleText, rules
from exover.report.policy import excuse_text
from exover.report.summary import Summary
from exover.report.text import last_line
from exover.source import Source

WORDS: tuple[FindingWord, ...] = ("violated", "unknown", "warning", "note", "ok")
"""The words for findings, the worst first: the order of the runs."""
MOST_SOURCE = 200_000
"""The most characters of a spec, with its parts, whose text is shown; a page has to stay below 2 MB."""


def document(summary: Summary, source: Source, tables: Tables | None, data: bytes, audit: Json | None = None) -> Json:
    """Return the object for the findings of a spec, its text and its tables; `data`: the bytes of the tables.

    `audit`: the JSON object that `exover audit` has printed.

    Without tables, `table` and `names` are null.
    """
    model = summary.model
    findings = summary.findings
    shown = [number for number, finding in enumerate(findings) if finding.trace]
    runs = sorted(shown, key=lambda number: WORDS.index(findings[number].word))
    run_of = {number: run for run, number in enumerate(runs)}
    return {
        "version": summary.version,
        "spec": model.name,
        "file": summary.file,
        "properties": summary.properties.file if summary.properties else None,
        "verdict": summary.verdict,
        "outcome": last_line(summary),
        "figures": _figures(summary),
        "checks": [_check(name, severity) for name, severity in SEVERITY.items()],
        "skipped": list(summary.skipped),
        "findings": [_finding(summary, finding, run_of.get(number)) for number, finding in enumerate(findings)],
        "runs": [_run(model, number, findings[number]) for number in runs],
        "rules": [_rule(rule) for rule in rules(model, written(source))],
        **({"audit": audit} if audit else {}),
        "graph": _graph(interactions(model)),
        "files": _files(source),
        "table": b64encode(data).decode() if tables else None,
        "names": _names(Description(model, tables)) if tables else None,
    }


def _figures(summary: Summary) -> list[list[str]]:
    """Return the sizes of spec and tables, as pairs of a name and a figure."""
    figures, tables = summary.figures, summary.tables
    found: list[tuple[str, object]] = [("requests", figures.requests), ("rules", figures.rules)]
    if figures.state_bits is not None:
        found.append(("state bits", figures.state_bits))
    if tables:
        found += [("nodes", tables.nodes), ("depth", tables.depth), ("bytes of tables", tables.bytes)]
        found += [("bytes of RAM", tables.ram_bytes), ("sha256 of the tables", tables.sha256)]
    return [[name, str(value)] for name, value in found]


def _files(source: Source) -> list[Json] | None:
    """Return the text of the spec and of the parts that it includes; None if they are longer than MOST_SOURCE."""
    if sum(len(each.text) for each in source.files) > MOST_SOURCE:
        return None
    return [{"name": each.name, "text": each.text} for each in source.files]


def _place(location: Location) -> Json | None:
    return {"file": location.file, "line": location.line} if location.line else None


# ---- findings and runs ----


def _check(name: str, severity: str) -> Json:
    found = page(name)
    return {"name": name, "severity": severity, "iff": found.iff if found else "", "mend": found.mend if found else ""}


def _finding(summary: Summary, finding: Finding, run: int | None) -> Json:
    return {
        "check": finding.check,
        "subject": finding.subject,
        "word": finding.word,
        "counts": summary.counts(finding),
        "engine": finding.engine,
        "method": finding.method,
        "message": finding.message,
        "place": _place(finding.location),
        "excuse": excuse_text(finding.excuse) if finding.excuse else None,
        "run": run,
    }


def _run(model: Model, number: int, finding: Finding) -> Json:
    """Return a run, its events and answers as JSON texts: as JSON numbers, JavaScript would round them."""
    trace = finding.trace
    assert trace
    return {
        "finding": number,
        "events": [json.dumps(event_json(model, moment.event), ensure_ascii=False) for moment in trace.moments],
        "answers": list(_answers(model, trace.moments)),
        "loop_start": trace.loop_start,
    }


def _answers(model: Model, moments: Iterable[Moment]) -> Iterator[str]:
    for step, moment in enumerate(moments, 1):
        yield answer_line(model, step, moment.actions)


# ---- rules, and the interaction graph ----


def _rule(rule: RuleText) -> Json:
    return {
        "name": rule.name,
        "kind": rule.kind,
        "request": rule.request,
        "written": rule.written,
        "because": rule.because,
        "place": _place(rule.location),
    }


def _graph(graph: InteractionGraph) -> Json:
    return {
        "nodes": [{"id": each.id, "kind": each.kind, "name": each.name} for each in graph.participants],
        "edges": [
            {
                "kind": edge.kind,
                "from": edge.source,
                "to": edge.target,
                "rules": list(edge.rules),
                "sometimes": edge.sometimes,
                "text": told(edge),
            }
            for edge in graph.interactions
        ],
    }


# ---- names for the tables ----


def _names(words: Description) -> Json:
    model = words.model
    texts: dict[str, int] = {}
    nodes = [
        texts.setdefault(words.action(node) if node.code < 0 else words.test(node), len(texts))
        for node in words.tables.nodes
    ]
    return {
        "requests": [
            {
                "name": request.name,
                "params": [_named(parameter) for parameter in request.params],
                "results": [_named(parameter) for parameter in request.results],
                "statuses": list(request.statuses),
            }
            for request in model.requests
        ],
        "variables": [_named(Parameter(*variable)) for variable in words.variables],
        "stocks": [
            {"name": resource.name, "domain": f"an integer in 0 .. {resource.capacity}"}
            for resource in model.resources
            if resource.consumable
        ],
        "reasons": [{"rule": reason.rule, "because": reason.because} for reason in words.reasons],
        "roots": [{"label": label, "node": node} for label, node in _roots(words)],
        "texts": list(texts),
        "nodes": nodes,
    }


def _roots(words: Description) -> Iterator[tuple[str, int]]:
    """Yield the label and the root of each diagram; the second of one label, as for the slots of a `fail`, gets
    `NAME (2)`.
    """
    seen: Counter[str] = Counter()
    for label, node in words.roots():
        seen[label] += 1
        yield (label if seen[label] == 1 else f"{label} ({seen[label]})"), node


def _named(parameter: Parameter) -> Json:
    return {"name": parameter.name, "domain": domain(parameter.type), **_values(parameter.type)}


def _values(kind: Type) -> Json:
    return {"values": list(kind.values)} if isinstance(kind, Enum) else {}
