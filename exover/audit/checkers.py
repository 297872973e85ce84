"""What can answer the events of an audit, besides the emitted C; each tells whether a waiting place is taken, too."""

from exover.ocrd.machine import Machine
from exover.ocrd.memory import EMPTY
from exover.run.simulate import ReferenceEngine


class ReferenceChecker(ReferenceEngine):
    """The reference interpreter."""

    def waits(self, request: str) -> bool:
        """Return whether the waiting place is taken."""
        return self._state.places[request] is not None


class TableChecker(Machine):
    """The packed tables, walked in Python."""

    def waits(self, request: str) -> bool:
        """Return whether the waiting place is taken."""
        return self.place[self.index[request]] != EMPTY
