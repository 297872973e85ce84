"""The library: what `import exover` offers, documented with examples in docs/library.md.

All results are frozen values. Mistakes in a text raise `SpecError`, wrong tables `TablesError`, and unreadable files
`OSError`. Nothing is printed.
"""

import json
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field
from pathlib import Path
from time import monotonic
from typing import get_args

from exover import pipeline, rendering
from exover.checks.finding import Finding
from exover.checks.schedule.plan import CheckPlan
from exover.dataclass import dataclass
from exover.diagnostics import Diagnostic, render_all
from exover.engines.compiler import NativeUnavailable
from exover.limits import NO_LIMITS, TimeUp, interrupted, limits_from
from exover.loop.claim import Verdict
from exover.loop.tracked_predicates import property_conditions
from exover.model.canonical import digest
from exover.model.event import (
    Abort,
    AbortWaiting,
    Action,
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
from exover.model.model import Model
from exover.model.property import NO_PROPERTIES, Properties
from exover.model.reads import reads
from exover.model.trace import Moment, Trace
from exover.model.wire import answer_line
from exover.ocrd.packing import DamagedTable, decode
from exover.ocrd.structure import verify
from exover.ocrd.tables import UNCHECKED
from exover.pipeline import CheckerName, EmitTarget
from exover.places import advised, find_properties, read_part
from exover.report.several import ReportFormat
from exover.report.summary import ERRORS, Summary
from exover.run.simulate import answers
from exover.source import Source
from exover.syntax import decode as utf8
from exover.syntax.includes import ReadPart

__all__ = [
    "NO_PROPERTIES",
    "Abort",
    "AbortWaiting",
    "Action",
    "Answer",
    "Ask",
    "Diagnostic",
    "Event",
    "Finding",
    "Findings",
    "Invalid",
    "Killed",
    "Launched",
    "Moment",
    "NativeUnavailable",
    "Observe",
    "Properties",
    "Rejected",
    "Report",
    "Spec",
    "SpecError",
    "Tables",
    "TablesError",
    "Trace",
    "Violated",
    "Waits",
    "check",
    "compile",
    "load",
    "load_properties",
    "load_tables",
    "loads",
    "simulate",
]

File = str | os.PathLike[str]


class SpecError(ValueError):
    """A spec or a properties file has mistakes; `str` of it is what `exover check` prints of them."""

    def __init__(self, source: Source, diagnostics: tuple[Diagnostic, ...]) -> None:
        super().__init__(render_all(diagnostics, source))
        self.source = source
        self.diagnostics = diagnostics


class TablesError(ValueError):
    """Bytes are no tables, or the tables of another spec."""


@dataclass(frozen=True, slots=True)
class Spec:
    """A spec without errors: its text, with those of its parts, and its model.

    `warnings` are diagnostics that are no errors.

    `file` is the file that it was loaded from, None if it was given as a text.
    """

    source: Source
    model: Model
    warnings: tuple[Diagnostic, ...] = ()
    file: str | None = None

    @property
    def name(self) -> str:
        """The name after the word `spec`."""
        return self.model.name

    @property
    def requests(self) -> tuple[str, ...]:
        """The full names of the requests, in the order of the text."""
        return tuple(request.name for request in self.model.requests)


@dataclass(frozen=True, slots=True)
class Findings:
    """The findings of the checks on a spec in the order of docs/checks.md: a `Finding` for each subject."""

    spec: Spec
    summary: Summary = field(repr=False)

    def __iter__(self) -> Iterator[Finding]:
        return iter(self.summary.findings)

    def __len__(self) -> int:
        return len(self.summary.findings)

    @property
    def verdict(self) -> Verdict:
        """`violated` iff a finding of severity error is, else `unknown` iff one is, else `holds`."""
        return self.summary.verdict

    def of(self, check: str) -> tuple[Finding, ...]:
        """Return the findings of a check by its name, such as `deadlock`."""
        return tuple(finding for finding in self if finding.check == check)

    def render(self, form: ReportFormat = "text") -> str:
        """Return the output of `exover check --format FORM`; raises `ValueError` if there is no such format."""
        _known(form, ReportFormat, "format")
        return rendering.report(self.summary, form, timings=False)

    def __str__(self) -> str:
        return self.render()


@dataclass(frozen=True, slots=True)
class Tables:
    """The tables of a spec; `data` are the bytes that `exover emit --target bin` writes (docs/runtime.md)."""

    spec: Spec
    data: bytes = field(repr=False)

    @property
    def unchecked(self) -> bool:
        """Whether they were made without findings that show that the checks of the spec hold."""
        return bool(decode(self.data).flags & UNCHECKED)

    def files(self, target: EmitTarget = "c") -> dict[str, bytes]:
        """Return the files that `exover emit --target TARGET` writes: their contents by name.

        Raises `ValueError` if there is no such target, or if these are not the tables that this version of exover makes
        of the spec.
        """
        _known(target, EmitTarget, "target")
        built = pipeline.build(self.spec.model, self.unchecked)
        if built.data != self.data:
            raise ValueError(f"another version of exover has made the tables of {self.spec.name}: compile it anew")
        return {artefact.name: artefact.content for artefact in pipeline.emit(built, target)}


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer to one event: its actions in order. `event` is `Invalid` if the line held no event of the spec."""

    event: Event | Invalid
    actions: tuple[Action, ...]
    line: str = field(repr=False)
    """The answer as the JSON line that `exover simulate` prints."""


def load(file: File) -> Spec:
    """Return the spec in a file, with the parts that it includes."""
    return _spec(_read(file), os.fspath(file), read_part)


def loads(text: str, name: str = "<text>") -> Spec:
    """Return the spec of a text, which cannot include files because it is in no folder; messages use this name."""
    if not isinstance(text, str):
        raise TypeError("a spec is a text: decode its bytes, or give the file to load")
    return _spec(_decoded(name, text.encode("utf-8", "surrogatepass")))


def load_properties(file: File, spec: Spec) -> Properties:
    """Return the properties in a properties file for a spec."""
    source = _read(file)
    loaded = pipeline.load_properties(source, spec.model)
    if loaded.properties is None:
        raise SpecError(source, loaded.diagnostics)
    return loaded.properties


def check(spec: Spec, properties: Properties | None = None, *, timeout: float | None = None, jobs: int = 1) -> Findings:
    """Return the findings of all checks on a spec, in runs that satisfy the assumptions of `properties`.

    Without `properties`, the file that `exover check` finds is read, if the spec was loaded from a file and has one.
    Raises `ValueError` if there are several, or if `properties` use names that the spec lacks. `NO_PROPERTIES` means
    none.

    `timeout`, in seconds: what has no answer by then is unknown; raises `TimeoutError` if not even the tables are made
    by then. Only the main thread may give one. With a timeout or several `jobs`, checks run in other processes.
    """
    limits = NO_LIMITS if jobs == 1 and timeout is None else limits_from(monotonic(), jobs, timeout)
    asked = _found(spec) if properties is None else _of_spec(properties, spec)
    try:
        with interrupted(limits):
            built = pipeline.build(spec.model)
    except TimeUp:
        raise TimeoutError(f"{limits.reason}: it was over before the tables of {spec.name} were made") from None
    outcome = pipeline.check(built, _quiet, CheckPlan(properties=asked), limits=limits)
    if outcome.interrupted:
        raise KeyboardInterrupt
    found = rendering.summarise(spec.source.name, spec.model, built, outcome, ERRORS, properties=asked)
    return Findings(spec, found)


def compile(spec: Spec, checked: Findings | None = None) -> Tables:
    """Return the tables of a spec; they are marked as unchecked unless findings of this spec are given.

    Raises `ValueError` if these are findings of another spec, or their verdict is not `holds`.
    """
    if checked is not None:
        if digest(checked.spec.model) != digest(spec.model):
            raise ValueError(f"these are not the findings of {spec.name}")
        if checked.verdict != "holds":
            raise ValueError(f"the checks of {spec.name} are {checked.verdict}: without them, the tables say so")
    return Tables(spec, pipeline.build(spec.model, unchecked=checked is None).data)


def load_tables(data: File | bytes, spec: Spec) -> Tables:
    """Return the tables of a spec from their bytes, or from a file with these (`exover emit --target bin`)."""
    content = data if isinstance(data, bytes) else Path(data).read_bytes()
    try:
        found = decode(content)
        if found.digest != digest(spec.model):
            raise TablesError(f"these are not the tables of {spec.name}, as {spec.source.name} has it")
        verify(found, spec.model)
    except DamagedTable as reason:
        raise TablesError(str(reason)) from reason
    return Tables(spec, content)


def simulate(
    checker: Spec | Tables, events: Iterable[str | bytes | Mapping[str, object]], engine: CheckerName | None = None
) -> tuple[Answer, ...]:
    """Return the answers to events from the initial state on: JSON lines or objects (docs/language.md section 7).

    The `engine` is by default `reference` for a spec and `tables` for tables. `c` and `rust` compile the emitted code
    and raise `NativeUnavailable` without a compiler.
    Raises `TypeError` if one text or event is given instead of several, `ValueError` if there is no such engine,
    `TablesError` if tables that were loaded contradict themselves.
    """
    if isinstance(events, str | bytes):
        raise TypeError("events are given one by one: write events.splitlines() for the lines of a text")
    if isinstance(events, Mapping):
        raise TypeError("events are given one by one: write [event] for a single one")
    if engine is not None:
        _known(engine, CheckerName, "engine")
    spec, tables = (checker, None) if isinstance(checker, Spec) else (checker.spec, decode(checker.data))
    lines = [event if isinstance(event, str | bytes) else json.dumps(event) for event in events]
    try:
        with pipeline.engine(engine or ("tables" if tables else "reference"), spec.model, tables) as chosen:
            answered = enumerate(answers(spec.model, chosen, lines), 1)
            return tuple(Answer(event, said, answer_line(spec.model, step, said)) for step, (event, said) in answered)
    except DamagedTable as reason:
        raise TablesError(str(reason)) from reason


def _found(spec: Spec) -> Properties:
    """Return the properties in the properties file of a spec, `NO_PROPERTIES` if it has none."""
    files = find_properties(spec.file, spec.name) if spec.file else []
    if len(files) > 1:
        raise ValueError(f"{spec.file} has {len(files)} properties files: {', '.join(files)}; say which one is meant")
    return load_properties(files[0], spec) if files else NO_PROPERTIES


def _known(word: str, among: object, what: str) -> None:
    """Raise `ValueError` unless a word is one of the literal type `among`."""
    words = get_args(among)
    if word not in words:
        raise ValueError(f"there is no {what} {word!r}: it is one of {', '.join(words)}")


def _of_spec(properties: Properties, spec: Spec) -> Properties:
    """Return the properties; raises `ValueError` if they use a name that the spec lacks."""
    model = spec.model
    stocks = {name for name, each in model.resource.items() if each.consumable}
    readings = {each.name for each in model.variables} | {each.name for each in model.latches}
    known = {"used": model.resource, "level": stocks, "reading": readings}
    read = {each for cond in property_conditions(properties) for each in reads(cond)}
    foreign = sorted(each.name for each in read if each.name not in known.get(each.kind, model.request))
    if foreign:
        raise ValueError(f"these are not properties of {spec.name}, which has no {foreign[0]}")
    return properties


def _quiet(what: str) -> None:
    """Ignore messages of progress."""


def _read(file: File) -> Source:
    with open(file, "rb") as stream:
        return _decoded(os.fspath(file), stream.read(utf8.MAX_BYTES + 1))


def _decoded(name: str, data: bytes) -> Source:
    source = utf8.decode(name, data)
    if isinstance(source, Diagnostic):
        raise SpecError(Source(name, ""), (source,))
    return source


def _spec(source: Source, file: str | None = None, read: ReadPart | None = None) -> Spec:
    loaded = pipeline.load(source, read)
    if loaded.model is None:
        raise SpecError(loaded.source, advised(loaded.diagnostics, file) if file else loaded.diagnostics)
    return Spec(loaded.source, loaded.model, loaded.diagnostics, file)
