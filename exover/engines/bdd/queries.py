"""Backward reachability within the stable states while sets are small, else within the reachable states."""

from collections.abc import Callable
from contextlib import suppress
from functools import cached_property
from typing import TypeVar

from exover.dataclass import dataclass
from exover.engines.bdd.backward_reachability import BackwardReachability, Ring, TooWide
from exover.engines.bdd.decomposition import reachable
from exover.engines.bdd.manager import Set
from exover.engines.bdd.quiescent import QuiescentSteps
from exover.engines.bdd.steps import NARROW, WIDE, Stepper, explore
from exover.loop.claim import Progress

Answer = TypeVar("Answer")


@dataclass
class Queries:
    """Backward reachability in several state spaces, the cheapest first."""

    stepper: Stepper
    progress: Progress
    _last: tuple[Set, list[Ring] | None] | None = None

    @cached_property
    def reached(self) -> Set:
        """The reachable states, by forward search; independent parts of the loop are explored separately."""
        self.progress("reachable states")
        if self.stepper.loop.observed:  # what the last step did is of one part alone
            return explore(self.stepper)
        found = self.stepper.space.all
        for _, states in reachable(self.stepper):
            found &= states
        return found

    @cached_property
    def _local(self) -> BackwardReachability:
        """Backward reachability among all states in which every component is stable, while sets are small."""
        return BackwardReachability(self.stepper, self.stepper.universe, WIDE)

    @cached_property
    def _exact(self) -> BackwardReachability:
        """Backward reachability among the reachable states."""
        return BackwardReachability(self.stepper, self.reached, None)

    @cached_property
    def lone(self) -> BackwardReachability:
        """Backward reachability by quiescent steps between states in which nothing waits, `straight`."""
        return BackwardReachability(
            QuiescentSteps(self.stepper, lone=True), self.stepper.space.all, WIDE, straight=True
        )

    @cached_property
    def quiescent(self) -> BackwardReachability:
        """Backward reachability by quiescent steps."""
        return BackwardReachability(QuiescentSteps(self.stepper, lone=False), self.stepper.space.all, NARROW)

    def shown(self, question: Callable[[BackwardReachability], Answer | None]) -> Answer | None:
        """Return an answer that quiescent steps give; None if they give none, or if there are assumptions."""
        if self.stepper.allowed == self.stepper.space.all:
            for backwards in (self.lone, self.quiescent):
                with suppress(TooWide):
                    answer = question(backwards)
                    if answer is not None:
                        return answer
        return None

    def asked(self, question: Callable[[BackwardReachability], Answer]) -> Answer:
        """Return the answer within the stable states or, if sets grow too wide there, within the reachable ones."""
        try:
            return question(self._local)
        except TooWide:
            return question(self._exact)

    def way(self, states: Set) -> list[Ring] | None:
        """Return the rings of the shortest runs to these states; None if they cannot be reached.

        The last answer is kept.
        """
        if self._last is None or self._last[0] != states:
            self._last = (states, self.asked(lambda backwards: backwards.rings(Ring(states, ()))))
        return self._last[1]
