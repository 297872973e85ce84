"""Who answers what is asked backwards: stable states as long as sets are small, else the reachable states."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

from exover.verify.bdd.backwards import Backwards, Ring, TooWide
from exover.verify.bdd.space import Set
from exover.verify.bdd.steps import WIDE, Reached, Stepper, explore

Progress = Callable[[str], None]
Answer = TypeVar("Answer")


@dataclass
class Search:
    """Questions asked backwards."""

    stepper: Stepper
    progress: Progress

    @cached_property
    def reached(self) -> Reached:
        """The reachable states, from the initial one forwards."""
        self.progress("reachable states")
        return explore(self.stepper)

    @cached_property
    def _local(self) -> Backwards:
        """Questions asked among all states in which every component is stable, as long as their sets are small."""
        return Backwards(self.stepper, self.stepper.universe, WIDE)

    @cached_property
    def _exact(self) -> Backwards:
        """Questions asked among the reachable states."""
        return Backwards(self.stepper, self.reached.states, None)

    def asked(self, question: Callable[[Backwards], Answer]) -> Answer:
        """Return the answer of whoever can give it."""
        try:
            return question(self._local)
        except TooWide:
            return question(self._exact)

    def reaches(self, states: Set) -> bool:
        """Return whether some of these states can be reached."""
        return self.asked(lambda backwards: backwards.rings(Ring(states, ()))) is not None
