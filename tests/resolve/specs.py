"""A small world that the tests of this folder add one thing to, and the way from a text to its model or mistakes."""

from exover.diagnostics import Diagnostic
from exover.model.model import Model
from exover.resolve import resolve
from exover.source import Source
from exover.syntax.parse import parse

WORLD = """spec world;
enum zone { base, dock, field }
const three = 3;
const half = 0.5;
const home = base;
poster battery: int in 0 .. 100 = 100;
poster speed: real in 0 .. 2 = 0;
poster top: real in 0 .. 2 = 1;
poster hot: bool = false;
latch tripped: when hot until m.a;
resource power: 10;
resource film: 3 consumable;
define calm = speed <= half;
group both = m.a, m.b;
module m {
    poster reach: int in 0 .. 9 = 0;
    state tool: {none, gripper} = none;
    request a();
    request b();
    request c(x: int in 0 .. 9, v: real in 0 .. 2, w: real in 0 .. 2, at: zone, on: bool, big: int in 0 .. 256)
        returns (dist: real in 0 .. 9, n: int in 0 .. 3);
}
module o { request d(); }
"""
MARK = "«"
"""Stands in a text where a mistake is expected."""


def resolved(text: str) -> tuple[Model | None, tuple[Diagnostic, ...], Source]:
    """Return what resolve makes of a text without syntax mistakes."""
    source = Source("t.exo", text)
    spec, found = parse(source)
    assert spec is not None, found
    return (*resolve(spec, source), source)


def model(text: str) -> Model:
    """Return the model of a text without mistakes."""
    found, mistakes, _ = resolved(text)
    assert found is not None, mistakes
    assert mistakes == ()
    return found


def world(text: str) -> Model:
    """Return the model of the world with something added."""
    return model(WORLD + text)


def mistakes(text: str) -> tuple[list[tuple[str, int]], list[int], tuple[Diagnostic, ...]]:
    """Return code and offset of every mistake of a marked text, the offsets of its marks, and the mistakes."""
    pieces = text.split(MARK)
    marks = [sum(len(piece) for piece in pieces[: index + 1]) for index in range(len(pieces) - 1)]
    found, diagnostics, _ = resolved("".join(pieces))
    assert (found is None) == bool(diagnostics)
    spans = [(found.code, found.span.start) for found in diagnostics if found.span]
    assert len(spans) == len(diagnostics)
    return spans, marks, diagnostics
