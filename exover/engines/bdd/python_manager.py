"""The BDD manager of dd in Python, used where dd has no CUDD."""

from dd import autoref, bdd

from exover.engines.bdd.effort import current

STEPS = 16
"""The steps of CUDD that take about as long as to find or add one node in Python."""


class _Nodes(bdd.BDD):
    """The nodes, with a finalizer that does not complain of sets that still exist; its steps count as an `Effort`.

    Sets refer to their manager, and cycles are collected in any order. dd takes that for an error and raises it in the
    finalizer, where it cannot be caught and would be printed.
    """

    def find_or_add(self, level: int, low: int, high: int) -> int:
        """Return the node with this level and these successors."""
        effort = current()
        if effort is not None:
            effort.take(STEPS)
        found: int = super().find_or_add(level, low, high)
        return found

    def __del__(self) -> None:
        pass


class PythonManager(autoref.BDD):
    """`dd.autoref.BDD` with such nodes; it counts references automatically."""

    def __init__(self) -> None:
        self._bdd = _Nodes()  # type: ignore[abstract]
        self.vars = self._bdd.vars
