"""A ranking that proves that no fair run stays for ever in states in which a formula is true.

While a run stays, some slots can only become idle: no step activates them, and a report leaves them idle. The rank is
the number of active ones among them. If it is positive as long as the run stays, each fair report decreases it (the
rule of Manna and Pnueli 1984 for justice), so the run cannot stay.
"""

from exover.dataclass import dataclass
from exover.engines.smt.solver import Prover
from exover.engines.smt.system import System
from exover.loop.exact.term import Term

METHOD = "ranking"


@dataclass
class JusticeRanking:
    """Whether fair runs can stay for ever where `stays` is true."""

    system: System
    prover: Prover
    stays: Term

    def excluded(self) -> bool:
        """Return True only if they cannot."""
        terms = self.system.terms
        active = terms.either(self.system.layout.vars[self.system.layout.slots[key].active] for key in self.only_idle())
        return not self._possible((self.stays, terms.negation(active)))

    def only_idle(self) -> list[tuple[str, int]]:
        """Return the slots that can only become idle while the run stays."""
        return [key for key, slot in self.system.layout.slots.items() if self._only_ends(key, slot.active)]

    def _only_ends(self, key: tuple[str, int], active: str) -> bool:
        """Return whether, as long as the run stays, nothing activates the slot, and a report leaves it idle."""
        terms, var = self.system.terms, self.system.layout.vars[active]
        for move in self.system.moves:
            if active not in move.after:
                continue
            becomes = (move.allowed, self.system.before(self.stays, move), move.after[active])
            since = terms.true if move.kind.reported == key else terms.negation(var)
            if self._possible((self.stays, since, *becomes)):
                return False
        return True

    def _possible(self, terms: tuple[Term, ...]) -> bool:
        return self.prover.satisfiable((*terms, self.system.assumed), self.system.lemmas)
