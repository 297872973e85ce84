"""Unreachability of moments, by induction and by k-induction (Sheeran, Singh, Stålmarck 2000)."""

from collections.abc import Iterator
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.smt.solver import Clock, Inconclusive, Prover
from exover.engines.smt.system import System
from exover.engines.smt.unrolling import Unrolled
from exover.loop.exact.term import Term


def ways(system: System, bad: Term) -> Iterator[Term]:
    """Yield for each move the condition that it is allowed and leads into `bad`."""
    for move in system.moves:
        yield system.terms.both((move.allowed, system.before(bad, move)))


@dataclass
class KInduction:
    """Inductive proofs, from any moment that satisfies the lemmas of the system and what else is `known`."""

    system: System
    clock: Clock
    known: tuple[Term, ...] = ()

    def __post_init__(self) -> None:
        self.terms = self.system.terms
        self.lemmas = (*self.system.lemmas, *self.known)

    @cached_property
    def prover(self) -> Prover:
        """Answers questions about one step."""
        return Prover(self.clock)

    @cached_property
    def _unrolled(self) -> Unrolled:
        return Unrolled(self.system, self.clock, from_start=False)

    def excludes(self, bad: Term) -> bool:
        """Return whether no move leads into `bad` from a moment that satisfies the lemmas and, if `bad` is false at the
        start, is not `bad` itself.
        """
        good = self.terms.negation(bad)
        outside = self.terms.replaced(bad, self.system.initial) is self.terms.false
        since = good if outside else self.terms.true
        return not any(self.prover.satisfiable((since, way), self.lemmas) for way in ways(self.system, bad))

    def k_excludes(self, bad: Term, width: int) -> bool:
        """Return whether no `width` moments without `bad` are followed by one with it (the step of k-induction).

        The base case, that no shorter run from the start leads to `bad`, is up to the caller.
        """
        unrolled = self._unrolled
        unrolled.grow_to(width)
        before = [unrolled.at(moment, self.terms.negation(bad)) for moment in range(width)]
        known = [unrolled.at(moment, term) for moment in range(width + 1) for term in self.known]
        try:
            return unrolled.check([*before, *known, unrolled.at(width, bad)], most=10.0) is None
        except Inconclusive:
            self.clock.left()
            return False
