"""Coherence of the assumptions: every moment has an allowed step, and every run can go on fairly."""

from collections.abc import Iterator
from functools import cached_property
from itertools import islice, product

from exover.dataclass import dataclass
from exover.engines.smt.concretize import ModelConcretizer
from exover.engines.smt.home_states import HomeStateProof
from exover.engines.smt.reachability import Reachability, ReachingRun
from exover.engines.smt.relation import Move
from exover.engines.smt.solver import Clock, Inconclusive, Prover
from exover.engines.smt.steps import Input
from exover.engines.smt.system import System
from exover.loop.exact.term import Term
from exover.model.event import Event
from exover.model.property import TRUE

MOST = 24
"""The greatest number of input values that are tried for a move."""


@dataclass
class AssumptionCheck:
    """Checks that the assumptions leave every moment of a system a step, and every run a fair continuation."""

    system: System
    clock: Clock
    runs: ModelConcretizer

    @cached_property
    def _prover(self) -> Prover:
        return Prover(self.clock)

    @cached_property
    def fair(self) -> bool:
        """Whether it is known that every run can go on so that reports are fair."""
        return HomeStateProof(self.system, self._prover, self.system.truth(TRUE)).fair and self.stranded() is None

    def stranded(self) -> tuple[Event, ...] | None:
        """Return a run to a moment that the assumptions leave no step; None if there is none; raises `Inconclusive`."""
        if not self.system.properties.assumptions:
            return None
        terms = self.system.terms
        some = terms.either(allowed for move in self.system.moves for allowed in self._instances(move))
        found = Reachability(self.system, self.clock).reach(terms.negation(some))
        if not isinstance(found, ReachingRun):
            return None
        events = self.runs.events(self.system, found.steps)
        values = self.runs.followed(self.system, found.steps, events)
        allowed = terms.either(terms.replaced(move.allowed, values) for move in self.system.moves)
        if not self._prover.satisfiable((allowed,)):
            return events
        raise Inconclusive("bound reached: it is not known whether the assumptions leave every moment a step")

    def _instances(self, move: Move) -> Iterator[Term]:
        """Yield where a move is allowed with some values."""
        choices = [self._values(each, move) for each in move.inputs]
        for values in islice(product(*choices), MOST):
            replaced = dict(zip((each.var for each in move.inputs), values, strict=True))
            yield self.system.terms.replaced(move.allowed, replaced)

    def _values(self, each: Input, move: Move) -> list[Term]:
        layout = self.system.layout
        found = [layout.resting(each.parameter.type)]
        if move.kind.verb == "observe":
            found += [layout.vars[move.kind.name], layout.initial[move.kind.name]]
        return list(dict.fromkeys(found))
