"""Reachability of a moment: shown by bounded model checking (Biere, Cimatti, Clarke, Zhu 1999), or refuted.

It is refuted by induction, k-induction or Spacer, whichever succeeds first.
"""

from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.smt.k_induction import KInduction
from exover.engines.smt.solver import Clock, Inconclusive, Prover
from exover.engines.smt.spacer import Spacer
from exover.engines.smt.system import System
from exover.engines.smt.unrolling import Taken, Unrolled
from exover.loop.exact.term import Term

INDUCTION = "induction"
FIRST = 6
"""The length of runs up to which they are searched before anything costly is tried."""
WIDEST = 3
"""The greatest k of k-induction."""
LONGEST = 40
"""The greatest length of runs that are searched."""


@dataclass(frozen=True, slots=True)
class ReachingRun:
    """A run into such a moment."""

    steps: list[Taken]


@dataclass(frozen=True, slots=True)
class UnreachableMoment:
    """The proof method by which no run comes to such a moment."""

    method: str


@dataclass
class Reachability:
    """Questions about the moments that a system can come to."""

    system: System
    clock: Clock
    known: tuple[Term, ...] = ()
    """Invariants of all moments that were found besides the lemmas."""

    def __post_init__(self) -> None:
        self.terms = self.system.terms
        self._induction = KInduction(self.system, self.clock, self.known)

    @property
    def prover(self) -> Prover:
        """Answers questions about one step."""
        return self._induction.prover

    @cached_property
    def _forward(self) -> Unrolled:
        return Unrolled(self.system, self.clock)

    def reach(self, bad: Term, least: int = 0) -> ReachingRun | UnreachableMoment:
        """Return a run of `least` steps or more to a moment in which `bad` is true, or the proof that there is none.

        Raises `Inconclusive`.
        """
        if least == 0 and self.terms.replaced(bad, self.system.initial) is self.terms.true:
            return ReachingRun([])
        if self._induction.excludes(bad):
            return UnreachableMoment(INDUCTION)
        return self._long(bad, least)

    def nowhere(self, bad: Term) -> bool:
        """Return whether it is seen at once that `bad` is true of no moment."""
        return self.terms.replaced(bad, self.system.initial) is self.terms.false and self._induction.excludes(bad)

    def _long(self, bad: Term, least: int) -> ReachingRun | UnreachableMoment:
        for depth in range(1, FIRST + 1):
            found = self._run(bad, depth)
            if found:
                return found
        for width in range(2, WIDEST + 1):
            if self._induction.k_excludes(bad, width):
                return UnreachableMoment(f"k-induction k={width}")
        if not self.system.steps.looked:
            raise Inconclusive("no facts of the loop were looked for")
        if Spacer(self.system, self.clock, self._induction.lemmas).excludes(bad, least):
            return UnreachableMoment("pdr")
        for depth in range(FIRST + 1, LONGEST + 1):
            found = self._run(bad, depth)
            if found:
                return found
        raise Inconclusive(
            f"bound reached: no run of {LONGEST} steps shows it, and no invariant was found that excludes one"
        )

    # ---- runs ----

    def _run(self, bad: Term, depth: int) -> ReachingRun | None:
        self._forward.grow_to(depth)
        model = self._forward.check([self._forward.at(depth, bad)])
        return None if model is None else ReachingRun(self._forward.taken(model, depth))
