"""Engines side by side on one stream of events: they give the same answers, or a disagreement says where not."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass

from exover.model.model import Model
from exover.ocrd.compile import compile_model
from exover.ocrd.machine import Machine
from exover.ocrd.packing import decode, pack
from exover.ocrd.tables import Tables
from exover.pipeline import load
from exover.run import rust as rust_engine
from exover.run.native import NativeEngine
from exover.run.simulate import Engine, ReferenceEngine, simulate
from exover.source import Source
from tests.support.events import Stream

DIGEST = bytes(32)
"""The hash of no spec: what random specs bear in their tables."""


def model_of(text: str) -> Model:
    """Return the model of a spec that is right."""
    loaded = load(Source("random.exo", text))
    assert loaded.model is not None, [(each.code, each.message) for each in loaded.diagnostics]
    return loaded.model


def tables_of(model: Model) -> Tables:
    """Return the tables of a model, as they are after packing and decoding."""
    return decode(pack(compile_model(model, DIGEST).tables))


@dataclass(frozen=True)
class Disagreement:
    """Engines that answer one line of a stream differently; `lines`: the stream up to it."""

    spec: str
    lines: tuple[str, ...]
    answers: dict[str, str]

    def __str__(self) -> str:
        """Return all that is needed to see it again."""
        stream = "\n".join(self.lines)
        answers = "\n".join(f"{engine:>9}: {answer}" for engine, answer in self.answers.items())
        return f"{self.spec}\n{stream}\nat event {len(self.lines)} the engines answer\n{answers}"


def disagreement(
    spec: str,
    lines: Sequence[str],
    native: bool = False,
    reference: Iterable[str] | None = None,
    rust: bool = False,
) -> Disagreement | None:
    """Return the first line at which the engines disagree about a spec.

    `native`: the compiled C is asked too, `rust`: the compiled Rust; `reference`: what the reference interpreter
    answers, if that is known.
    """
    model = model_of(spec)
    tables = tables_of(model)
    with ExitStack() as stack:
        engines: dict[str, Engine] = {"tables": Machine(model, tables)}
        if native:
            engines["c"] = stack.enter_context(NativeEngine(model, tables))
        if rust:
            engines["rust"] = stack.enter_context(rust_engine.engine_of(model, tables))
        answers = {"reference": iter(reference or simulate(model, ReferenceEngine(model), lines))}
        answers |= {name: simulate(model, engine, lines) for name, engine in engines.items()}
        return _first(spec, lines, answers)


def _first(spec: str, lines: Sequence[str], answers: dict[str, Iterator[str]]) -> Disagreement | None:
    for step, *given in zip(range(1, len(lines) + 1), *answers.values(), strict=True):
        if len(set(given)) > 1:
            return Disagreement(spec, tuple(lines[:step]), dict(zip(answers, given, strict=True)))
    return None


def compared(spec: str, seed: int, events: int, native: bool = False, rust: bool = False) -> Disagreement | None:
    """Return what the engines disagree about on a spec and the events of this seed."""
    lines, answers = zip(*Stream(model_of(spec), seed).answered(events), strict=True)
    return disagreement(spec, lines, native, answers, rust)


def agree(spec: str, lines: Iterable[str]) -> None:
    """Raise `AssertionError`, which tells the whole story, unless all engines answer every line alike."""
    found = disagreement(spec, tuple(lines), native=True)
    assert found is None, f"\n{found}"


def agree_at_random(spec: str, seed: int, events: int, native: bool = False, rust: bool = False) -> None:
    """Raise `AssertionError` unless the engines answer the events of this seed alike."""
    found = compared(spec, seed, events, native, rust)
    assert found is None, f"\n{found}"
