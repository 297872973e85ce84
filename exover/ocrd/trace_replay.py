"""Replay of traces on the walker of the tables, beside the reference interpreter."""

from functools import cached_property

from exover.dataclass import dataclass
from exover.model.model import Model
from exover.model.semantics import Reference
from exover.model.trace import Trace, confirm, same
from exover.ocrd.machine import Machine
from exover.ocrd.tables import Tables


@dataclass(frozen=True)
class TraceReplay:
    """The reference interpreter of a model and the walker of its tables, each made at its first use."""

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
        """Return whether the tables answer the events of a trace with exactly its actions."""
        return same(trace, self._machine.replay)

    def confirm(self, trace: Trace) -> None:
        """Raise `Disagreement` unless the tables answer the events of a trace with exactly its actions."""
        confirm(trace, "the walker of the tables", self._machine.replay)
