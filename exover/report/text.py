"""The findings for people: what is open first, with the runs that show it, then the counts and the tables."""

from collections.abc import Iterator
from typing import assert_never

from exover.checks.finding import Finding, Verdict
from exover.model.event import (
    Abort,
    AbortWaiting,
    Action,
    Args,
    Ask,
    Event,
    Invalid,
    Killed,
    Launched,
    Observe,
    Rejected,
    Report,
    Violated,
    Waits,
)
from exover.model.model import Model, Parameter
from exover.model.trace import Trace
from exover.model.types import Value
from exover.model.wire import number
from exover.report.summary import Summary, overall

ORDER: tuple[Verdict, ...] = ("violated", "unknown", "holds")
WORDS: dict[Verdict, tuple[str, str]] = {
    "violated": ("violated", "violated"),
    "unknown": ("unknown", "unknown"),
    "holds": ("holds", "hold"),
}
"""What is said of one finding with this verdict, and of several."""


def render(summary: Summary, timings: bool = False) -> str:
    """Return the report with a final newline; seconds are in it only with `timings`."""
    return "".join(f"{_visible(line)}\n" for line in _lines(summary, timings))


def _lines(summary: Summary, timings: bool) -> Iterator[str]:
    model, tables = summary.model, summary.tables
    requests = _count(summary.figures.requests, "request")
    yield f"{summary.file}: spec {model.name}, {requests}, {_count(summary.figures.rules, 'rule')}"
    yield ""
    groups: dict[str, list[Finding]] = {}
    for finding in summary.findings:
        groups.setdefault(finding.check, []).append(finding)
    for check, group in sorted(groups.items(), key=lambda item: ORDER.index(_worst(item[1]))):
        yield from _group(model, check, group, timings)
    yield ""
    yield (
        f"tables: {_count(tables.nodes, 'node')}, depth {tables.depth}, "
        f"{_count(tables.tests, 'test')} before the first action, "
        f"{_count(tables.bytes, 'byte')}, {_count(tables.ram_bytes, 'byte')} of RAM"
    )
    yield f"{model.name}: {_outcome(summary)}"


def _worst(group: list[Finding]) -> Verdict:
    return overall(group, frozenset({"error", "warning", "note"}))


def _group(model: Model, check: str, group: list[Finding], timings: bool) -> Iterator[str]:
    """Yield a line of counts for a check, then each of its findings that does not hold."""
    severity = group[0].severity
    counts = [(verdict, sum(finding.verdict == verdict for finding in group)) for verdict in ORDER]
    parts = ", ".join(f"{count} {WORDS[verdict][count > 1]}" for verdict, count in counts if count)
    methods = dict.fromkeys(finding.method for finding in group if finding.verdict == "holds")
    proof = f" ({', '.join(methods)})" if methods else ""
    seconds = f", {sum(finding.seconds for finding in group):.3f} s" if timings else ""
    yield f"{check}{'' if severity == 'error' else f' ({severity})'}: {parts}{proof}{seconds}"
    for verdict in ("violated", "unknown"):
        for finding in group:
            if finding.verdict == verdict:
                yield from _finding(model, finding)


def _finding(model: Model, finding: Finding) -> Iterator[str]:
    where = finding.location
    place = f" at {where.file}:{where.line}:{where.column}" if where.line else ""
    yield f"  {finding.subject} {finding.verdict}{place}: {finding.message}"
    if finding.trace is not None:
        yield from (f"    {line}" for line in trace_lines(model, finding.trace))


def _outcome(summary: Summary) -> str:
    total = len(summary.findings)
    holding = sum(finding.verdict == "holds" for finding in summary.findings)
    if holding == total:
        return f"holds: all of {_count(total, 'finding')}"
    violated = [finding.severity for finding in summary.findings if finding.verdict == "violated"]
    parts = [_count(violated.count(s), s) for s in ("error", "warning", "note") if s in violated]
    unknown = total - holding - len(violated)
    parts += [f"{unknown} unknown"] if unknown else []
    return (
        f"{summary.verdict}: {', '.join(parts)}; {holding} of {_count(total, 'finding')} {WORDS['holds'][holding > 1]}"
    )


def _count(count: int, noun: str) -> str:
    return f"{count} {noun}{'' if count == 1 else 's'}"


def _visible(line: str) -> str:
    # Texts of the spec may hold control characters, which must not steer a terminal.
    return "".join(character if character.isprintable() else "\ufffd" for character in line)


# ---- runs ----


def trace_lines(model: Model, trace: Trace) -> Iterator[str]:
    """Yield a numbered line for each event and, indented, one for each action that answered it."""
    width = len(str(len(trace.moments)))
    for step, moment in enumerate(trace.moments, 1):
        yield f"{step:>{width}}. {event_text(model, moment.event)}"
        yield from (f"{'':>{width}}    {action_text(model, action)}" for action in moment.actions)
    if trace.loop_start is not None:
        yield f"{'':>{width}}  and again from step {trace.loop_start + 1}, for ever"


def event_text(model: Model, event: Event) -> str:
    """Return an event in the words of docs/language.md section 4."""
    match event:
        case Ask(name, args):
            return f"ask {name}({_named(model.request[name].params, args)})"
        case Report(name, slot, "ok", results):
            declared = model.request[name].results
            return f"report {_slot(model, name, slot)} ok" + (f"({_named(declared, results)})" if declared else "")
        case Report(name, slot, outcome, _, status):
            return f"report {_slot(model, name, slot)} {outcome}" + (f"({status})" if status else "")
        case Observe(name, value, broken):
            return f"observe {name} broken, taken as {_value(value)}" if broken else f"observe {name} = {_value(value)}"
        case Abort(name, slot):
            return f"abort {_slot(model, name, slot)}"
        case AbortWaiting(name):
            return f"abort {name} waiting"
        case _:
            assert_never(event)


def action_text(model: Model, action: Action) -> str:
    """Return an action in the words of docs/language.md section 5."""
    match action:
        case Launched(name, slot, args, rule, because):
            launched = f"launch {_slot(model, name, slot)}({_named(model.request[name].params, args)})"
            return launched + (_why(rule, because) if rule else "")
        case Waits(name, rule, because):
            return f"wait {name}{_why(rule, because)}"
        case Rejected(name, rule, because):
            return f"reject {name}{_why(rule, because)}"
        case Killed(name, slot, rule, because):
            return f"kill {_slot(model, name, slot)}{_why(rule, because)}"
        case Violated(rule, because):
            return f"violation{_why(rule, because)}"
        case Invalid(code, detail):
            return f"invalid {code}" + (f": {detail}" if detail else "")
        case _:
            assert_never(action)


def _why(rule: str, because: str | None) -> str:
    return f" [{rule}]" + ("" if because is None else f" {because}")


def _slot(model: Model, name: str, slot: int) -> str:
    return f"{name}[{slot}]" if model.request[name].instances > 1 else name


def _named(parameters: tuple[Parameter, ...], values: Args) -> str:
    return ", ".join(f"{p.name} = {_value(value)}" for p, value in zip(parameters, values, strict=True))


def _value(value: Value) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return str(number(value)) if isinstance(value, float) else str(value)
