"""What is written on an edge, and which participants stand together."""

from exover.graph.interactions import Interaction, InteractionGraph, Participant


def told(edge: Interaction) -> str:
    """Return what an edge says, with the rules that make it so."""
    doubted = {"excludes": "may exclude", "interrupts": "may interrupt"} if edge.sometimes else {}
    return f"{doubted.get(edge.kind, edge.kind)}: {', '.join(edge.rules)}"


def by_module(graph: InteractionGraph) -> dict[str, list[Participant]]:
    """Return the participants by their modules, in the order of the text; those of none under the empty name."""
    found: dict[str, list[Participant]] = {}
    for each in graph.participants:
        found.setdefault(each.module, []).append(each)
    return found
