"""Feasibility of paths of the diagrams, asked of Z3 over exact states where bound propagation does not tell."""

from functools import cached_property
from typing import TYPE_CHECKING

from exover.dataclass import dataclass
from exover.equivalence.path_equivalence import TestedPath, UndecidedPaths
from exover.ocrd.compile import DecodedTables

if TYPE_CHECKING:
    from exover.equivalence.term_equivalence import TermComparison

SECONDS = 5.0
"""The time limit for one path, in seconds."""


@dataclass
class PathFeasibility:
    """Decides whether some state and arguments satisfy a path; Z3 is imported at the first call."""

    compiled: DecodedTables

    @cached_property
    def _rules(self) -> "TermComparison":
        from exover.engines.smt.solver import Clock, Prover
        from exover.equivalence.term_equivalence import TermComparison

        return TermComparison(self.compiled, Prover(Clock(), SECONDS))

    def __call__(self, path: TestedPath) -> bool:
        """Return whether in some state all elements of a path lie in their ranges; may raise `UndecidedPaths`."""
        from exover.engines.smt.concretize import SpuriousModel
        from exover.engines.smt.solver import Inconclusive

        try:
            return self._rules.passes(path)
        except (Inconclusive, SpuriousModel) as reason:
            raise UndecidedPaths(str(reason)) from reason
