"""Z3 as an engine for all claims: those about runs, and that the tables do what the rules say."""

from functools import cached_property
from time import monotonic

from exover.dataclass import dataclass
from exover.engines.smt.concretize import SpuriousModel
from exover.engines.smt.engine import Smt
from exover.engines.smt.solver import Inconclusive, Prover
from exover.equivalence.term_equivalence import METHOD, TermComparison
from exover.loop.claim import Claim, Opinion


@dataclass
class Z3(Smt):
    """Answers claims about one closed loop and its tables; `seconds` for each."""

    def judge(self, claim: Claim) -> Opinion:
        """Return whether the claim is true of every run that the assumptions leave, or of the tables."""
        return self._about_tables(claim) if claim.check == "tables" else super().judge(claim)

    @cached_property
    def _rules(self) -> TermComparison:
        return TermComparison(self.compiled, Prover(self.clock, self.seconds))

    def _about_tables(self, claim: Claim) -> Opinion:
        """Return whether the tables do what the rules say for the kind of event that the claim names."""
        kind, name = claim.subject.split(" ", 1)
        self.clock.deadline = monotonic() + self.seconds
        try:
            what = next(self._rules.different(kind, name), None)
        except (Inconclusive, SpuriousModel) as reason:
            return Opinion("unknown", "", str(reason))
        return Opinion("holds", METHOD) if what is None else Opinion("violated", METHOD, what)
