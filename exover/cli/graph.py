"""`exover graph`: draw the graph of interactions between requests."""

import argparse

from exover.cli.files import print_or_write, read_spec
from exover.cli.status import CliError, ExitStatus
from exover.cli.streams import complain
from exover.engines.process import NotRunnable
from exover.graph.interactions import KINDS, InteractionGraph, InteractionKind, interactions
from exover.graph.mermaid import MAX_EDGES
from exover.rendering import draw


def run(arguments: argparse.Namespace) -> int:
    """Print or write the drawing of a spec."""
    graph = interactions(read_spec(arguments.spec), _kinds(arguments.only))
    try:
        drawn = draw(graph, arguments.format)
    except (NotRunnable, TimeoutError) as reason:
        advice = "install Graphviz, or take --format dot or mermaid"
        if isinstance(reason, TimeoutError):
            advice = "take --format dot or mermaid; --only leaves edges out"
        raise CliError(f"cannot draw SVG: {reason}; {advice}") from reason
    _note(graph, arguments.format)
    print_or_write(arguments.out, drawn)
    return ExitStatus.OK


def _kinds(listed: list[str]) -> tuple[InteractionKind, ...]:
    """Return the kinds of edges in comma-separated lists, in the order of KINDS; all if there is no list."""
    named = {kind for text in listed for kind in text.split(",")}
    return tuple(kind for kind in KINDS if kind in named or not named)


def _note(graph: InteractionGraph, form: str) -> None:
    edges = len(graph.interactions)
    if form == "mermaid" and edges > MAX_EDGES:
        complain(f"exover: note: {edges} edges: Mermaid draws {MAX_EDGES} unless it is set up otherwise (`maxEdges`)")
