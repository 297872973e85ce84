"""The latches of a loop whose values tell which of its states are new."""

from exover.engines.aig.encoding.state import Latches
from exover.engines.aig.simulation.coverage import CoverageGoals

BITS = 4
"""How many bits of a number count, the least significant ones."""


def coverage_goals(*states: Latches) -> CoverageGoals:
    """Return the coverage goals of states: pairs of all variables that are not held, and the mode.

    The mode is what states of modules and latches of the spec are: what is done next depends on them, and to come to
    a valuation of them may take many steps (a mode of a hybrid automaton; Alur, Courcoubetis et al. 1995).
    """
    pairs, mode = dict[int, None](), dict[int, None]()
    for latches in states:
        model = latches.model
        modal = {each.name for each in model.variables if each.kind == "state"} | {each.name for each in model.latches}
        for name, bits in latches.literals.items():
            nodes = [bit >> 1 for bit in bits[:BITS]]
            if name not in latches.held:
                pairs |= dict.fromkeys(nodes)
            if name in modal:
                mode |= dict.fromkeys(nodes)
    return CoverageGoals(tuple(pairs), tuple(mode))
