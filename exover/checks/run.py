"""All checks of a compiled model, their traces replayed on the tables."""

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter

from exover.checks import CHECKS
from exover.checks.finding import Finding, Severity
from exover.checks.question import Check, Context, Question
from exover.model.event import Event
from exover.model.property import NO_PROPERTIES, Properties
from exover.model.semantics import Reference
from exover.model.trace import Answers, confirm
from exover.ocrd.compile import Compiled
from exover.ocrd.machine import Machine
from exover.verify.bdd.analysis import Analysis, Progress
from exover.verify.bdd.witness import Spurious
from exover.verify.cells import TooLarge

SEVERITIES: tuple[Severity, ...] = ("error", "warning", "note")


@dataclass(frozen=True, slots=True)
class Outcome:
    """What the checks found, in the order of docs/checks.md, the number of bits of the loop's state, and a remark."""

    findings: tuple[Finding, ...] = ()
    state_bits: int = 0
    note: str = ""


def check_all(
    compiled: Compiled,
    progress: Progress,
    severities: Collection[Severity] = SEVERITIES,
    properties: Properties = NO_PROPERTIES,
) -> Outcome:
    """Return what every check says of a model and its tables, which should be those decoded from the emitted bytes.

    Only runs that `properties` assumes are looked at. Only checks of the given severities are asked. Traces are runs
    of the reference interpreter, confirmed on the tables. `progress` is told what is looked at.
    """
    analysis = Analysis(compiled, Reference(compiled.model), progress, properties)
    context = Context(compiled, analysis)
    questions = [
        (check, Question(check.name, check.severity, subject, location))
        for check in CHECKS
        if check.severity in severities
        for subject, location in check.subjects(compiled.model, properties)
    ]
    findings = tuple(_answer(context, check, question) for check, question in questions)
    for finding in findings:
        if finding.trace:
            confirm(finding.trace, "the walker of the tables", partial(_walk, compiled))
    return Outcome(findings, analysis.state_bits)


def _answer(context: Context, check: Check, question: Question) -> Finding:
    """Return the finding with the seconds it took; `unknown` where the engine cannot express the question."""
    context.analysis.progress(f"{question.check} {question.subject}")
    started = perf_counter()
    try:
        finding = check.decide(context, question)
    except (TooLarge, Spurious) as reason:
        finding = question.unknown(str(reason))
    return replace(finding, seconds=perf_counter() - started)


def _walk(compiled: Compiled, events: tuple[Event, ...]) -> tuple[Answers, ...]:
    machine = Machine(compiled.model, compiled.tables)
    return tuple(machine.step(event) for event in events)
