"""The toolkit on one page: text -> Model -> Tables -> Findings -> Artefacts, and engines that run them.

Nothing here prints or writes where the user looks. Steps import what they need when they are taken, so that a
simulation on the reference interpreter pays for no diagram.
"""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from hashlib import sha256
from typing import TYPE_CHECKING, Literal, assert_never

from exover.diagnostics import Diagnostic
from exover.model.model import Model
from exover.source import Source

if TYPE_CHECKING:
    from exover.checks.finding import Finding, Severity
    from exover.emit.artefact import Artefact
    from exover.gateway.simulate import Engine
    from exover.ocrd.compile import Figures
    from exover.ocrd.tables import Tables
    from exover.report.summary import Summary

EngineName = Literal["reference", "tables", "c"]
Target = Literal["c", "bin", "json", "dot"]


@dataclass(frozen=True, slots=True)
class Loaded:
    """What became of a text: its model iff nothing is wrong with it, and its diagnostics in the order of the text."""

    model: Model | None
    diagnostics: tuple[Diagnostic, ...]


@dataclass(frozen=True, slots=True)
class Build:
    """The tables of a model: their bytes, what these say when they are decoded, and figures of the diagram."""

    model: Model
    data: bytes
    tables: "Tables"
    figures: "Figures"


def load(source: Source) -> Loaded:
    """Return the model of a spec, or what is wrong with it."""
    from exover.resolve import resolve
    from exover.syntax.parse import parse

    spec, mistakes = parse(source)
    if spec is None:
        return Loaded(None, mistakes)
    model, more = resolve(spec, source)
    return Loaded(model, mistakes + more)


def build(model: Model, unchecked: bool = False) -> Build:
    """Return the tables of a model, as whoever gets the bytes will read them; `unchecked` is noted in their header."""
    from exover.model.canonical import digest
    from exover.ocrd.compile import compile_model
    from exover.ocrd.tables import UNCHECKED, decode, pack

    compiled = compile_model(model, digest(model), UNCHECKED if unchecked else 0)
    data = pack(compiled.tables)
    return Build(model, data, decode(data), compiled.figures)


def check(built: Build, progress: Callable[[str], None]) -> "tuple[Finding, ...]":
    """Return what every check says of the decoded tables, in the order of docs/checks.md; `progress` is told of it."""
    from exover.checks.run import check_all

    return check_all(built.model, built.tables, progress)


def summarise(file: str, built: Build, findings: "tuple[Finding, ...]", counted: "frozenset[Severity]") -> "Summary":
    """Return what a report tells: the findings, and how large the spec and its tables are."""
    from exover import __version__
    from exover.emit.sizes import ram_bytes
    from exover.report.summary import ModelFigures, Summary, TableFigures

    model, figures, tables = built.model, built.figures, built.tables
    rules = len({rule.name for rule in model.rules})
    return Summary(
        __version__,
        file,
        model,
        findings,
        ModelFigures(len(model.requests), rules, 0),
        TableFigures(
            figures.nodes,
            figures.depth,
            figures.tests,
            len(built.data),
            ram_bytes(tables),
            sha256(built.data).hexdigest(),
        ),
        counted,
    )


def emit(built: Build, target: Target) -> "tuple[Artefact, ...]":
    """Return the files of a target."""
    raise NotImplementedError


def engine(name: EngineName, model: Model) -> "AbstractContextManager[Engine]":
    """Return an engine in its initial state, to be left when it is no longer needed.

    `reference` is the reference interpreter, `tables` walks the packed tables, `c` runs the emitted C, which it
    compiles with the system's compiler.
    """
    match name:
        case "reference":
            from exover.gateway.simulate import ReferenceEngine

            return nullcontext(ReferenceEngine(model))
        case "tables":
            from exover.ocrd.machine import Machine

            return nullcontext(Machine(model, build(model).tables))
        case "c":
            from exover.gateway.native import NativeEngine

            return NativeEngine(model, build(model).tables)
        case _:
            assert_never(name)
