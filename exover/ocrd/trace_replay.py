"""Runs of a model and its tables: on the reference interpreter, and held against the walker of the tables."""

from functools import cached_property

from exover.dataclass import dataclass
from exover.model.model import Model
from exover.model.semantics import Reference
from exover.model.trace import Trace, confirm, same
from exover.ocrd.machine import Machine
from exover.ocrd.tables import Tables


@dataclass(frozen=True)
class TraceReplay:
    """The two interpreters in Python of what a model and its tables say, each made when it is first asked."""

    model: Model
    tables: Tables

    @cached_property
    def reference(self) -> Reference:
        """The reference interpreter."""
        return Reference(self.model)

    @cached_property
    def _machine(self) -> Machine:
        return Machine(self.model, self.tables)

    def agrees(self, trace: Trace) -> bool:
        """Return whether the tables answer a run as it says."""
        return same(trace, self._machine.replay)

    def confirm(self, trace: Trace) -> None:
        """Raise `Disagreement` unless the tables answer a run as it says."""
        confirm(trace, "the walker of the tables", self._machine.replay)
