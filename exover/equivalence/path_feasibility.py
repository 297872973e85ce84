"""Feasibility of paths of the diagrams, asked of Z3 over exact states where bound propagation does not tell."""

from functools import cached_property
from typing import TYPE_CHECKING

from exover.dataclass import dataclass
from exover.equivalence.path_equivalence import TestedPath, UndecidedPaths
from exover.ocrd.compile import DecodedTables

if TYPE_CHECKING:
    from exover.equivalence.term_equivalence import TermComparison

SECONDS = 5.0
"""The time for one path."""


@dataclass
class PathFeasibility:
    """Knows of a path whether some state and arguments are on it; Z3 is imported when the first is asked for."""

    compiled: DecodedTables

    @cached_property
    def _rules(self) -> "TermComparison":
        from exover.engines.smt.solver import Clock, Prover
        from exover.equivalence.term_equivalence import TermComparison

        return TermComparison(self.compiled, Prover(Clock(), SECONDS))

    def __call__(self, path: TestedPath) -> bool:
        """Return whether each element of a path lies in its range in some state; may be `UndecidedPaths`."""
        from exover.engines.smt.concretize import SpuriousModel
        from exover.engines.smt.solver import Inconclusive

        try:
            return self._rules.passes(path)
        except (Inconclusive, SpuriousModel) as reason:
            raise UndecidedPaths(str(reason)) from reason
