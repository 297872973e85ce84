"""The checkers of an audit in Python: engines that also tell whether a waiting place is taken."""

from exover.ocrd.machine import Machine
from exover.ocrd.memory import EMPTY
from exover.run.simulate import ReferenceEngine


class ReferenceChecker(ReferenceEngine):
    """The reference interpreter as a checker."""

    def waits(self, request: str) -> bool:
        """Return whether the waiting place of a request is taken."""
        return self._state.places[request] is not None


class TableChecker(Machine):
    """The packed tables, walked in Python."""

    def waits(self, request: str) -> bool:
        """Return whether the waiting place of a request is taken."""
        return self.place[self.index[request]] != EMPTY
