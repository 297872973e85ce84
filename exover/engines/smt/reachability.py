"""Can a moment be reached? Shown by bounded model checking (Biere, Cimatti, Clarke, Zhu 1999), or refuted.

It is refuted by induction, k-induction or Spacer, whichever comes first.
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
"""So many steps a run is looked for before anything costly is tried."""
WIDEST = 3
"""So many steps k-induction looks back."""
LONGEST = 40
"""So many steps a run is looked for at last."""


@dataclass(frozen=True, slots=True)
class ReachingRun:
    """A run into such a moment."""

    steps: list[Taken]


@dataclass(frozen=True, slots=True)
class UnreachableMoment:
    """No run comes to such a moment, and how that was shown."""

    method: str


@dataclass
class Reachability:
    """Questions about the moments that a system can come to."""

    system: System
    clock: Clock
    known: tuple[Term, ...] = ()
    """What was found to be true of every moment, beside the lemmas."""

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
        """Return a run of `least` steps or more into a moment in which `bad` is true, or how it is known that none is.

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
