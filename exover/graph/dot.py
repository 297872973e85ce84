"""An interaction graph for Graphviz: `dot -Tsvg rover.dot`."""

from collections.abc import Iterator

from exover.emit.dot import quote
from exover.graph.interactions import Interaction, InteractionGraph, InteractionKind, Participant
from exover.graph.words import by_module, told

SHAPES = {
    "request": "box",
    "poster": "ellipse",
    "state": "ellipse",
    "latch": "hexagon",
    "resource": "cylinder",
    "limit": "octagon",
    "always": "plaintext",
}
LINES: dict[InteractionKind, str] = {
    "excludes": 'dir=none, color="#b3261e"',
    "interrupts": 'color="#b3261e"',
    "shares": 'dir=none, color="#7a5900"',
    "constrains": 'color="#5f6368"',
    "launches": 'color="#1b6e3c", penwidth=2',
    "wakes": 'color="#1a56b0"',
    "sets": 'color="#5f6368", arrowhead=empty',
}


def render(graph: InteractionGraph) -> str:
    """Return the graph in the DOT language: modules are clusters, dashed lines depend on arguments or readings."""
    return "".join(f"{line}\n" for line in _lines(graph))


def _lines(graph: InteractionGraph) -> Iterator[str]:
    yield f"digraph {quote(graph.name)} {{"
    yield "    rankdir=LR;"
    yield '    node [fontname="Helvetica", fontsize=11];'
    yield '    edge [fontname="Helvetica", fontsize=9];'
    for number, (module, inside) in enumerate(by_module(graph).items()):
        if module:
            yield f"    subgraph cluster_{number} {{ label={quote(module)}; color=gray;"
        yield from (f"    {'    ' if module else ''}{_node(each)};" for each in inside)
        if module:
            yield "    }"
    for edge in graph.interactions:
        yield f"    {quote(edge.source)} -> {quote(edge.target)} [{_line(edge)}];"
    yield "}"


def _node(each: Participant) -> str:
    return f"{quote(each.id)} [label={quote(each.text)}, shape={SHAPES[each.kind]}]"


def _line(edge: Interaction) -> str:
    dashed = ", style=dashed" if edge.sometimes else ""
    return f"label={quote(told(edge))}, {LINES[edge.kind]}{dashed}"
