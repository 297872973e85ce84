"""The toolkit on one page: text -> Model -> Tables -> Findings -> Artefacts, and engines that run them.

Nothing here prints or writes where the user looks. Steps import what they need when they are taken, so that a
simulation on the reference interpreter pays for no diagram.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, Any, Literal, assert_never

from exover.dataclass import dataclass
from exover.diagnostics import Diagnostic
from exover.model.model import Model
from exover.model.property import NO_PROPERTIES, Properties
from exover.source import Source

if TYPE_CHECKING:
    from exover.bounds.events import EventBounds
    from exover.checks.finding import Finding
    from exover.checks.run import Audience, CheckOutcome
    from exover.checks.schedule.answers import AnswerStore
    from exover.checks.schedule.engines import Engines
    from exover.checks.schedule.plan import CheckPlan
    from exover.emit.artefact import Artefact
    from exover.emit.config import Needs
    from exover.limits import Limits
    from exover.model.difference import Compared
    from exover.model.explanation import Explanation
    from exover.ocrd.compile import Compiled
    from exover.ocrd.tables import Tables
    from exover.run.simulate import Engine
    from exover.swap.prove import AskProperties, SwapAnswer
    from exover.syntax.includes import JoinPath, ReadPart

CheckerName = Literal["reference", "tables", "c", "rust"]
EmitTarget = Literal["c", "rust", "bin", "json", "dot", "smt2", "smv", "aiger"]
NOT_REPLAYED = "traces were not replayed on the C runtime"


@dataclass(frozen=True, slots=True)
class Loaded:
    """The result of loading a spec: its model, None if there are errors, and its diagnostics in the order of the text.

    `source` is the text with those of its parts; the spans of the diagnostics refer to it.
    """

    source: Source
    model: Model | None
    diagnostics: tuple[Diagnostic, ...]


@dataclass(frozen=True, slots=True)
class LoadedProperties:
    """The result of loading a properties file: its properties, None if there are errors, and its diagnostics."""

    properties: Properties | None
    diagnostics: tuple[Diagnostic, ...]


@dataclass(frozen=True)
class Build:
    """The tables of a model: their bytes, and the compiled tables, which are decoded from these bytes."""

    model: Model
    data: bytes
    compiled: "Compiled"

    @property
    def tables(self) -> "Tables":
        """The tables decoded from the bytes."""
        return self.compiled.tables

    @cached_property
    def event_bounds(self) -> "EventBounds":
        """Bounds on the costs of each event, with the method by which they were found; several targets write them."""
        from exover.engines.aig.costs import tightened

        return tightened(self.compiled)


@dataclass(frozen=True, slots=True)
class DiffSide:
    """One of two versions that are compared: its tables, its properties, and what messages call its file."""

    build: Build
    file: str
    properties: Properties


def load(source: Source, read: "ReadPart | None" = None, join: "JoinPath | None" = None) -> Loaded:
    """Return the model of a spec, or its mistakes; `read` reads included files, without it an include is a mistake.

    `join` names them (default: as files of this system).
    """
    from exover.resolve import resolve
    from exover.syntax.includes import gather

    whole, spec, mistakes, _ = gather(source, read, join=join)
    if spec is None:
        return Loaded(whole, None, mistakes)
    model, more = resolve(spec, whole)
    return Loaded(whole, model, mistakes + more)


def load_properties(source: Source, model: Model) -> LoadedProperties:
    """Return the properties of a properties file for a model, or its mistakes."""
    from exover.resolve.properties import resolve_properties
    from exover.syntax.parse import parse_properties

    tree, mistakes = parse_properties(source)
    if tree is None:
        return LoadedProperties(None, mistakes)
    properties, more = resolve_properties(tree, source, model)
    return LoadedProperties(properties, mistakes + more)


def build(model: Model, unchecked: bool = False) -> Build:
    """Return the tables of a model, packed and decoded again; `unchecked` sets that flag in their header.

    Raises `TablesTooLarge` of `exover.raised` if they are more than can be made.
    """
    from exover.model.canonical import digest
    from exover.ocrd.compile import compile_model
    from exover.ocrd.packing import decode, pack
    from exover.ocrd.tables import UNCHECKED

    compiled = compile_model(model, digest(model), UNCHECKED if unchecked else 0)
    data = pack(compiled.tables)
    return Build(model, data, replace(compiled, tables=decode(data)))


def check(
    built: Build,
    progress: Callable[[str], None],
    plan: "CheckPlan | None" = None,
    *,
    limits: "Limits | None" = None,
    audience: "Audience | None" = None,
    store: "AnswerStore | None" = None,
) -> "CheckOutcome":
    """Return the findings of the checks on the decoded tables, in the order of docs/checks.md.

    `progress` is called with what is done now; `audience` gets each finding as soon as it is known. `plan`: what is
    asked, and who answers (default: all checks, by the portfolio). Traces of violated findings are replayed on the
    emitted C before they are returned. Answers that `store` has are taken from there.
    """
    from exover.checks.run import NOBODY, check_all
    from exover.checks.schedule.answers import NO_STORE
    from exover.checks.schedule.plan import CheckPlan
    from exover.limits import INTERRUPTED, NO_LIMITS, TimeUp, interrupted

    limits = limits or NO_LIMITS
    outcome = check_all(
        built.compiled,
        progress,
        plan or CheckPlan(),
        limits=limits,
        audience=audience or NOBODY,
        store=store or NO_STORE,
    )
    shown = [finding for finding in outcome.findings if finding.verdict == "violated" and finding.trace]
    new = [finding for finding in shown if finding.key not in outcome.recalled]
    if not new:
        pass
    elif outcome.interrupted:
        outcome = replace(outcome, note=f"{NOT_REPLAYED}: {INTERRUPTED}")
    else:
        try:
            with interrupted(limits):
                outcome = replace(outcome, note=_confirm(built, new, progress))
        except TimeUp:
            outcome = replace(outcome, note=f"{NOT_REPLAYED}: {limits.reason}")
        except KeyboardInterrupt:
            outcome = replace(outcome, note=f"{NOT_REPLAYED}: {INTERRUPTED}", interrupted=True)
    if outcome.settled:
        outcome.settled.keep(replayed=not outcome.note)
    return outcome


def property_findings(
    built: Build,
    properties: Properties,
    progress: Callable[[str], None],
    limits: "Limits",
    engines: "Engines | None" = None,
) -> "tuple[Finding, ...]":
    """Return the findings of the check `property`, none if there are no properties.

    `engines`: who answers (default: the portfolio). Raises `KeyboardInterrupt` if the user interrupts.
    """
    from exover.checks.schedule.engines import PORTFOLIO
    from exover.checks.schedule.plan import CheckPlan

    if not properties.properties:
        return ()
    outcome = check(built, progress, CheckPlan(("property",), properties, engines or PORTFOLIO), limits=limits)
    if outcome.interrupted:
        raise KeyboardInterrupt
    return outcome.findings


def _confirm(built: Build, shown: "list[Finding]", progress: Callable[[str], None]) -> str:
    """Replay traces on the emitted C; return why that was not possible, "" if it was. Raises `Disagreement`."""
    from exover.engines.compiler import NativeUnavailable
    from exover.model.trace import confirm
    from exover.run.native import NativeEngine

    progress("replay on the C runtime")
    try:
        with NativeEngine(built.model, built.tables) as native:
            for finding in shown:
                if finding.trace:
                    confirm(finding.trace, "the C runtime", native.replay)
    except NativeUnavailable as reason:
        return f"{NOT_REPLAYED}: {reason}"
    return ""


def certify(built: Build, outcome: "CheckOutcome", properties: Properties, progress: Callable[[str], None]) -> bytes:
    """Return the certificate of the findings of the checks on the tables (docs/certificates.md)."""
    from exover import __version__
    from exover.proofs import certify as proofs

    found = proofs.certificate(built.compiled, built.data, outcome.findings, properties, __version__, progress)
    return proofs.render(found)


def claimed(model: Model, properties: Properties) -> "dict[str, Any]":
    """Return the claims that every certificate of a spec and its properties must contain, whatever the findings."""
    from exover.proofs.certify import expected

    return expected(model, properties)


def different(model: Model, data: bytes) -> list[str]:
    """Return the differences between tables, given by their bytes, and the rules of a model; empty iff there is none.

    Raises `UndecidedBytes` of `exover.proofs.bytes` if the rules distinguish too many cases to compare.
    """
    from exover.proofs.bytes import differences

    return list(differences(model, data))


def embedded(path: str) -> bytes:
    """Return the bytes of the tables in an emitted C or Rust source file.

    Raises `NativeUnavailable` of `exover.engines.compiler`.
    """
    from pathlib import Path

    from exover.run.embedded import embedded

    return embedded(Path(path))


def explain(source: Source, model: Model, lines: Iterable[bytes]) -> "Explanation | None":
    """Return why the last event of a stream was answered as it was, by the model of `source`; None without events."""
    from exover.explain.explain import explain
    from exover.explain.source_text import written

    return explain(model, written(source), lines)


def emit(
    built: Build,
    target: EmitTarget,
    properties: Properties = NO_PROPERTIES,
    beside: "tuple[Needs, ...]" = (),
    deadline: float = inf,
) -> "tuple[Artefact, ...]":
    """Return the files of a target, named after the spec; for Rust a crate of that name.

    Formats of model checkers (`smt2`, `smv`, `aiger`) also state the claims of `properties`. In C, the configuration of
    the runtime also serves the tables of the specs `beside`.

    Raises `TooLarge` if the closed loop has too many states for the target, `Inconclusive` if Z3 has not answered by
    the `deadline`, a time of `monotonic`.
    """
    model, tables = built.model, built.tables
    match target:
        case "c":
            from exover.emit import c

            return c.emit(model, tables, model.name, beside, built.event_bounds)
        case "rust":
            from exover.emit import rust

            return rust.emit(model, tables, model.name, built.event_bounds)
        case "bin":
            from exover.emit import binary

            return binary.emit(model, tables)
        case "json":
            from exover.emit import json

            return json.emit(model, tables, built.event_bounds)
        case "dot":
            from exover.emit import dot

            return dot.emit(model, tables)
        case "smt2":
            from exover.checks.questions import claims
            from exover.emit import smtlib

            return smtlib.emit(built.compiled, properties, tuple(claims(model, properties)), deadline)
        case "smv":
            from exover.checks.questions import claims
            from exover.emit import smv

            return smv.emit(built.compiled, properties, tuple(claims(model, properties)))
        case "aiger":
            from exover.checks.questions import claims
            from exover.emit import aiger

            return aiger.emit(built.compiled, properties, tuple(claims(model, properties)))
        case _:
            assert_never(target)


def swap(old: Build, new: Build, ask: "AskProperties") -> "tuple[bytes, SwapAnswer]":
    """Return the map by which `exover_swap` goes from the tables of one spec to those of another, and what was proved.

    `ask` checks properties of OLD. Use the map only if the verdict of the answer is `holds`.
    """
    from exover.swap.bytes import packed
    from exover.swap.carry import Carry
    from exover.swap.prove import prove

    carry = Carry(old.compiled, new.compiled)
    answer = prove(carry, ask)
    return packed(carry, answer.ended), answer


def diff(
    old: DiffSide,
    new: DiffSide,
    renamed: Mapping[str, str],
    ask: "Callable[[], tuple[Collection[Finding], Collection[Finding]]]",
    abc: str,
    progress: Callable[[str], None],
    limits: "Limits | None" = None,
) -> "Compared":
    """Return the differences between the answers of OLD and NEW, in runs that satisfy the assumptions of both.

    `renamed`: the requests of OLD that have another name in NEW. `ask` returns the findings of the check `property` for
    each; `abc`: the program of Berkeley ABC, "" to do without it. At the end of the time limit, the result is what is
    known by then.
    """
    from exover import __version__
    from exover.diff.compare import differences, judged
    from exover.engines.aig.encoding.versions import ComparedLoops
    from exover.limits import NO_LIMITS
    from exover.model.difference import Compared
    from exover.model.versions import Versions

    versions = Versions(old.build.model, new.build.model, renamed)
    properties = old.properties, new.properties
    loops = ComparedLoops(versions, (old.build.compiled, new.build.compiled), properties)
    shown, undecided = differences(loops, abc, progress, limits or NO_LIMITS)
    return Compared(__version__, versions, (old.file, new.file), properties, shown, undecided, judged(*ask()))


def engine(name: CheckerName, model: Model, tables: "Tables | None" = None) -> "AbstractContextManager[Engine]":
    """Return a context manager for an engine in its initial state.

    `reference` is the reference interpreter, `tables` walks the tables, `c` and `rust` compile the emitted code with
    the compilers of the system and run it. Without `tables`, those of the model are made.
    """
    if name == "reference":
        from exover.run.simulate import ReferenceEngine

        return nullcontext(ReferenceEngine(model))
    made = tables or build(model).tables
    match name:
        case "tables":
            from exover.ocrd.machine import Machine

            return nullcontext(Machine(model, made))
        case "c":
            from exover.run.native import NativeEngine

            return NativeEngine(model, made)
        case "rust":
            from exover.run.rust import engine_of

            return engine_of(model, made)
        case _:
            assert_never(name)
