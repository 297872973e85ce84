"""No fair run stays for ever where a formula is true: a ranking by the slots that are active.

While a run stays, some slots can only become idle: no step activates them, and a report of one leaves it idle. If one
of these is always active as long as the run stays, fair reports end that: each makes their number less (a ranking; the
rule of Manna and Pnueli 1984 for justice).
"""

from exover.dataclass import dataclass
from exover.engines.smt.relation import Move
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
        """Return whether it is known that they cannot."""
        terms = self.system.terms
        active = terms.either(self.system.layout.vars[self.system.layout.slots[key].active] for key in self.only_idle())
        return not self._possible((self.stays, terms.negation(active)))

    def only_idle(self) -> list[tuple[str, int]]:
        """Return the slots that can only become idle as long as the run stays."""
        return [key for key, slot in self.system.layout.slots.items() if self._only_ends(key, slot.active)]

    def _only_ends(self, key: tuple[str, int], active: str) -> bool:
        """Return whether, as long as the run stays, nothing activates the slot, and a report leaves it idle."""
        terms, var = self.system.terms, self.system.layout.vars[active]
        for move in self.system.moves:
            if active not in move.after:
                continue
            becomes = (move.allowed, self.system.before(self.stays, move), move.after[active])
            since = terms.true if self.reports(move, key) else terms.negation(var)
            if self._possible((self.stays, since, *becomes)):
                return False
        return True

    def reports(self, move: Move, key: tuple[str, int]) -> bool:
        """Return whether a move is a report of this slot."""
        return move.kind.verb == "report" and (move.kind.name, move.kind.slot) == key

    def _possible(self, terms: tuple[Term, ...]) -> bool:
        return self.prover.satisfiable((*terms, self.system.assumed), self.system.lemmas)
