"""Is some state on a path of the diagrams? Asked of Z3, over exact states, where bounds alone do not tell."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from exover.equivalence.path_equivalence import Path, Undecided
from exover.ocrd.compile import Read

if TYPE_CHECKING:
    from exover.equivalence.term_equivalence import Rules

SECONDS = 5.0
"""The time for one path."""


@dataclass
class Passes:
    """Knows of a path whether some state and arguments are on it; Z3 is imported when the first is asked for."""

    compiled: Read

    @cached_property
    def _rules(self) -> "Rules":
        from exover.engines.smt.solver import Clock, Prover
        from exover.equivalence.term_equivalence import Rules

        return Rules(self.compiled, Prover(Clock(), SECONDS))

    def __call__(self, path: Path) -> bool:
        """Return whether each element of a path lies in its range in some state; may be `Undecided`."""
        from exover.engines.smt.concretize import Spurious
        from exover.engines.smt.solver import GaveUp

        try:
            return self._rules.passes(path)
        except (GaveUp, Spurious) as reason:
            raise Undecided(str(reason)) from reason
