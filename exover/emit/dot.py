"""The forest of diagrams as a drawing for Graphviz: `dot -Tsvg rover.dot`."""

from collections.abc import Iterator

from exover.emit.artefact import Artefact
from exover.emit.describe import Description
from exover.model.model import Model
from exover.ocrd.tables import NONE, Tables


def emit(model: Model, tables: Tables) -> tuple[Artefact, ...]:
    """Return `NAME.dot`: roots are events, boxes are actions; the solid edge of a test is taken iff it is true."""
    return (Artefact(f"{model.name}.dot", "".join(f"{line}\n" for line in _lines(model, tables)).encode()),)


def _lines(model: Model, tables: Tables) -> Iterator[str]:
    words = Description(model, tables)
    yield f"digraph {quote(model.name)} {{"
    yield '    node [fontname="Helvetica", fontsize=10];'
    yield '    end [label="", shape=point];'
    for number, (label, node) in enumerate(words.roots()):
        yield f"    r{number} [label={quote(label)}, shape=plaintext];"
        yield f"    r{number} -> {_target(node)};"
    for number, row in enumerate(tables.nodes):
        if row.code < 0:
            yield f"    n{number} [label={quote(words.action(row))}, shape=box];"
            yield f"    n{number} -> {_target(row.low)};"
        else:
            yield f"    n{number} [label={quote(words.test(row))}, shape=ellipse];"
            yield f"    n{number} -> {_target(row.low)};"
            yield f"    n{number} -> {_target(row.high)} [style=dashed];"
    yield "}"


def _target(node: int) -> str:
    return "end" if node == NONE else f"n{node}"


def quote(text: str) -> str:
    """Return a text as a quoted identifier of the DOT language."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
