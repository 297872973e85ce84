"""An interaction graph as a Mermaid flowchart, which merge requests and wikis draw."""

from collections.abc import Iterator

from exover.graph.interactions import Interaction, InteractionGraph
from exover.graph.words import by_module, told

MAX_EDGES = 500
"""The most edges of a graph that Mermaid draws by default."""
SHAPES = {
    "request": ("[", "]"),
    "poster": ("([", "])"),
    "state": ("([", "])"),
    "latch": ("{{", "}}"),
    "resource": ("[(", ")]"),
    "limit": ("{", "}"),
    "always": ("((", "))"),
}
LINES = {
    "excludes": ("---", "-.-"),
    "interrupts": ("--x", "-.-x"),
    "shares": ("---", "-.-"),
    "constrains": ("-->", "-.->"),
    "launches": ("==>", "==>"),
    "wakes": ("-->", "-.->"),
    "sets": ("--o", "-.-o"),
}
"""By kind, the arrow of an edge that always holds, and of one that depends on arguments or readings."""


def render(graph: InteractionGraph) -> str:
    """Return the flowchart: modules are subgraphs, dotted lines depend on arguments or readings."""
    return "".join(f"{line}\n" for line in _lines(graph))


def _lines(graph: InteractionGraph) -> Iterator[str]:
    ids = {each.id: f"n{number}" for number, each in enumerate(graph.participants)}
    yield "flowchart LR"
    for number, (module, inside) in enumerate(by_module(graph).items()):
        if module:
            yield f"    subgraph m{number}[{_quote(module)}]"
        for each in inside:
            opening, closing = SHAPES[each.kind]
            yield f"    {'    ' if module else ''}{ids[each.id]}{opening}{_quote(each.text)}{closing}"
        if module:
            yield "    end"
    for edge in graph.interactions:
        yield f"    {ids[edge.source]} {_line(edge)}|{_quote(told(edge))}| {ids[edge.target]}"


def _line(edge: Interaction) -> str:
    certain, dotted = LINES[edge.kind]
    return dotted if edge.sometimes else certain


def _quote(text: str) -> str:
    escaped = text.replace("#", "#35;").replace('"', "#quot;")
    return f'"{escaped}"'
