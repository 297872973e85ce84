"""The texts of edges, and the participants grouped by module."""

from exover.graph.interactions import Interaction, InteractionGraph, Participant


def told(edge: Interaction) -> str:
    """Return the text of an edge: its kind, and the rules that are the reason."""
    doubted = {"excludes": "may exclude", "interrupts": "may interrupt"} if edge.sometimes else {}
    return f"{doubted.get(edge.kind, edge.kind)}: {', '.join(edge.rules)}"


def by_module(graph: InteractionGraph) -> dict[str, list[Participant]]:
    """Return the participants by module, in the order of the text; under "" those outside modules."""
    found: dict[str, list[Participant]] = {}
    for each in graph.participants:
        found.setdefault(each.module, []).append(each)
    return found
