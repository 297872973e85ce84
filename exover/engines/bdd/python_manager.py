"""dd's own manager of BDDs, in Python, which is used where dd has no CUDD."""

from dd import autoref, bdd


class _Nodes(bdd.BDD):
    """The nodes; when they go, nothing is said of sets that are still there.

    Sets hold their manager, and are held by what holds it: in which order they go is not for us to say. dd takes it for
    an error, which nothing can catch, and which would be printed.
    """

    def __del__(self) -> None:
        pass


class PythonManager(autoref.BDD):
    """`dd.autoref.BDD`, which counts by itself which nodes are in use."""

    def __init__(self) -> None:
        self._bdd = _Nodes()  # type: ignore[abstract]
        self.vars = self._bdd.vars
