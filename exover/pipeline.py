"""The toolkit on one page: text -> Model -> Tables -> Findings -> Artefacts, and engines that run them.

Nothing here prints or writes where the user looks. Steps import what they need when they are taken, so that a
simulation on the reference interpreter pays for no diagram.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
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
    from exover.checks.schedule.limits import Limits
    from exover.emit.artefact import Artefact
    from exover.emit.config import Needs
    from exover.model.difference import Compared
    from exover.model.explanation import Explanation
    from exover.ocrd.compile import Compiled
    from exover.ocrd.tables import Tables
    from exover.run.simulate import Engine
    from exover.swap.prove import AskProperties, SwapAnswer
    from exover.syntax.includes import ReadPart

CheckerName = Literal["reference", "tables", "c", "rust"]
EmitTarget = Literal["c", "rust", "bin", "json", "dot", "smt2", "smv", "aiger"]
NOT_REPLAYED = "traces were not replayed on the C runtime"


@dataclass(frozen=True, slots=True)
class Loaded:
    """What became of a spec: its model iff nothing is wrong with it, and its diagnostics in the order of the text.

    `source` is the text with those that it includes, which the diagnostics are about.
    """

    source: Source
    model: Model | None
    diagnostics: tuple[Diagnostic, ...]


@dataclass(frozen=True, slots=True)
class LoadedProperties:
    """What became of a properties file: what it says iff nothing is wrong with it, and its diagnostics in order."""

    properties: Properties | None
    diagnostics: tuple[Diagnostic, ...]


@dataclass(frozen=True, slots=True)
class Build:
    """The tables of a model: their bytes, and what is known of them, the tables themselves decoded from the bytes."""

    model: Model
    data: bytes
    compiled: "Compiled"

    @property
    def tables(self) -> "Tables":
        """The tables as they are read from the bytes."""
        return self.compiled.tables


def load(source: Source, read: "ReadPart | None" = None) -> Loaded:
    """Return the model of a spec, or what is wrong with it; without what can `read` files it includes nothing."""
    from exover.resolve import resolve
    from exover.syntax.includes import gather

    whole, spec, mistakes, _ = gather(source, read)
    if spec is None:
        return Loaded(whole, None, mistakes)
    model, more = resolve(spec, whole)
    return Loaded(whole, model, mistakes + more)


def load_properties(source: Source, model: Model) -> LoadedProperties:
    """Return what a properties file says of a model, or what is wrong with it."""
    from exover.resolve.properties import resolve_properties
    from exover.syntax.parse import parse_properties

    tree, mistakes = parse_properties(source)
    if tree is None:
        return LoadedProperties(None, mistakes)
    properties, more = resolve_properties(tree, source, model)
    return LoadedProperties(properties, mistakes + more)


def build(model: Model, unchecked: bool = False) -> Build:
    """Return the tables of a model, as whoever gets the bytes will read them; `unchecked` is noted in their header."""
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
    asked: Collection[str] | None = None,
    properties: Properties = NO_PROPERTIES,
    limits: "Limits | None" = None,
    engines: "Engines | None" = None,
    count: bool = False,
    audience: "Audience | None" = None,
    store: "AnswerStore | None" = None,
) -> "CheckOutcome":
    """Return what every check says of the decoded tables, in the order of docs/checks.md; `progress` is told of it.

    The audience is told of findings as they fall, before they are all known.

    Only the checks that are `asked` are, by their names (default: all). Only runs that `properties` assumes are looked
    at. Runs that break something are answered by the emitted C as well before they are returned. Without
    `engines`, what diagrams cannot answer is put to Z3. With `count`, reachable states are counted. What the store
    knows is not asked.
    """
    from exover.checks.run import NOBODY, check_all
    from exover.checks.schedule.answers import NO_STORE
    from exover.checks.schedule.engines import PORTFOLIO
    from exover.checks.schedule.limits import INTERRUPTED, NO_LIMITS, TimeUp, interrupted

    limits = limits or NO_LIMITS
    who = engines or PORTFOLIO
    told, kept = audience or NOBODY, store or NO_STORE
    outcome = check_all(built.compiled, progress, asked, properties, limits, who, count, told, kept)
    shown = [finding for finding in outcome.findings if finding.verdict == "violated" and finding.trace]
    new = [finding for finding in shown if (finding.check, finding.subject) not in outcome.recalled]
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


def unanswered(
    model: Model,
    properties: Properties,
    reason: str,
    asked: Collection[str] | None,
    engines: "Engines",
    count: bool,
) -> "CheckOutcome":
    """Return the outcome of `check` when there is no time to ask anything."""
    from exover.checks import run

    return run.unanswered(model, asked, properties, reason, engines, count)


def _confirm(built: Build, shown: "list[Finding]", progress: Callable[[str], None]) -> str:
    """Replay traces on the emitted C; return why that could not be done, or nothing."""
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


def event_bounds(built: Build) -> "EventBounds":
    """Return what no event exceeds, and how that was found."""
    from exover.engines.aig.costs import tightened

    return tightened(built.compiled)


def certify(built: Build, outcome: "CheckOutcome", properties: Properties, progress: Callable[[str], None]) -> bytes:
    """Return the certificate of what the checks said of the tables (docs/certificates.md)."""
    from exover import __version__
    from exover.proofs import certify as proofs

    found = proofs.certificate(built.compiled, built.data, outcome.findings, properties, __version__, progress)
    return proofs.render(found)


def claimed(model: Model, properties: Properties) -> "dict[str, Any]":
    """Return what every certificate of a spec and its properties must contain, whatever was found."""
    from exover.proofs.certify import expected

    return expected(model, properties)


def different(model: Model, data: bytes) -> list[str]:
    """Return in what tables, given by their bytes, are not the rules of a model; nothing iff they are.

    Raises `UndecidedBytes` of `exover.proofs.bytes` if the rules tell more apart than can be followed.
    """
    from exover.proofs.bytes import differences

    return list(differences(model, data))


def embedded(path: str) -> bytes:
    """Return the bytes of the tables in an emitted C or Rust source.

    Raises `NativeUnavailable` of `exover.engines.compiler`.
    """
    from pathlib import Path

    from exover.run.embedded import embedded

    return embedded(Path(path))


def explain(source: Source, model: Model, lines: Iterable[bytes]) -> "Explanation | None":
    """Return why the last event of a stream was answered so by the model of a source; None if there is no event."""
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
    """Return the files of a target, named after the spec, or a crate of that name. `properties` are asked about, too.

    In C, the configuration of the runtime also serves the tables of other specs that stand `beside`.

    Raises `TooLarge` if the loop has more to tell apart than a target can say, `Inconclusive` if Z3 is at work at a
    time of `monotonic`, the `deadline`.
    """
    model, tables = built.model, built.tables
    match target:
        case "c":
            from exover.emit import c

            return c.emit(model, tables, model.name, beside, event_bounds(built))
        case "rust":
            from exover.emit import rust

            return rust.emit(model, tables, model.name, event_bounds(built))
        case "bin":
            from exover.emit import binary

            return binary.emit(tables, model.name)
        case "json":
            from exover.emit import json

            return json.emit(model, tables, model.name, event_bounds(built))
        case "dot":
            from exover.emit import dot

            return dot.emit(model, tables, model.name)
        case "smt2":
            from exover.checks.questions import claims
            from exover.emit import smtlib

            return smtlib.emit(built.compiled, properties, tuple(claims(model, properties)), model.name, deadline)
        case "smv":
            from exover.checks.questions import claims
            from exover.emit import smv

            return smv.emit(built.compiled, properties, tuple(claims(model, properties)), model.name)
        case "aiger":
            from exover.checks.questions import claims
            from exover.emit import aiger

            return aiger.emit(built.compiled, properties, tuple(claims(model, properties)), model.name)
        case _:
            assert_never(target)


def swap(old: Build, new: Build, ask: "AskProperties") -> "tuple[bytes, SwapAnswer]":
    """Return the map by which `exover_swap` goes from the tables of one spec to those of another, and what was proved.

    `ask` tells what is known of properties of OLD. The map is to be used only if the answer's verdict is `holds`.
    """
    from exover.swap.bytes import packed
    from exover.swap.carry import Carry
    from exover.swap.prove import prove

    carry = Carry(old.compiled, new.compiled)
    answer = prove(carry, ask)
    return packed(carry, answer.ended), answer


def diff(
    old: Build,
    new: Build,
    renamed: Mapping[str, str],
    files: tuple[str, str],
    properties: tuple[Properties, Properties],
    ask: "Callable[[], tuple[Collection[Finding], Collection[Finding]]]",
    abc: str,
    progress: Callable[[str], None],
    limits: "Limits | None" = None,
) -> "Compared":
    """Return which answers NEW gives otherwise than OLD, in runs that the properties of both assume.

    `ask` returns what the check `property` says of each; `files`: what the two are called; `abc`: the program of
    Berkeley ABC, empty if it is not to help. When the time is over, it is told what is known by then.
    """
    from exover import __version__
    from exover.checks.schedule.limits import NO_LIMITS, TimeUp, interrupted
    from exover.diff.compare import differences, judged
    from exover.engines.aig.comparison import Allowance
    from exover.model.difference import Compared
    from exover.model.versions import Versions

    versions = Versions(old.model, new.model, renamed)
    bounded = limits or NO_LIMITS
    time = Allowance(lambda: interrupted(bounded), TimeUp, bounded.reason)
    shown, undecided = differences(versions, (old.compiled, new.compiled), properties, abc, progress, time)
    return Compared(__version__, versions, files, properties, shown, undecided, judged(*ask()))


def engine(name: CheckerName, model: Model, tables: "Tables | None" = None) -> "AbstractContextManager[Engine]":
    """Return an engine in its initial state, to be left when it is no longer needed.

    `reference` is the reference interpreter, `tables` walks the packed tables, `c` and `rust` run what
    is emitted, which they compile with the system's compilers. Without `tables`, those of the model are made.
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
