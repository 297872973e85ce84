"""The BDD manager of dd in Python, used where dd has no CUDD."""

from dd import autoref, bdd


class _Nodes(bdd.BDD):
    """The nodes, with a finalizer that does not complain of sets that still exist.

    Sets refer to their manager, and cycles are collected in any order. dd takes that for an error and raises it in the
    finalizer, where it cannot be caught and would be printed.
    """

    def __del__(self) -> None:
        pass


class PythonManager(autoref.BDD):
    """`dd.autoref.BDD` with such nodes; it counts references automatically."""

    def __init__(self) -> None:
        self._bdd = _Nodes()  # type: ignore[abstract]
        self.vars = self._bdd.vars
