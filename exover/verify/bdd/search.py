"""Who answers what is asked backwards: stable states as long as sets are small, else the reachable states."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

from exover.verify.bdd.backwards import Backwards, Ring, TooWide
from exover.verify.bdd.space import Set
from exover.verify.bdd.steps import WIDE, Stepper, explore

Progress = Callable[[str], None]
Answer = TypeVar("Answer")


@dataclass
class Search:
    """Questions asked backwards."""

    stepper: Stepper
    progress: Progress
    _last: tuple[Set, list[Ring] | None] | None = None

    @cached_property
    def reached(self) -> Set:
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
        return Backwards(self.stepper, self.reached, None)

    def asked(self, question: Callable[[Backwards], Answer]) -> Answer:
        """Return the answer of whoever can give it."""
        try:
            return question(self._local)
        except TooWide:
            return question(self._exact)

    def way(self, states: Set) -> list[Ring] | None:
        """Return the rings of the shortest runs to these states; None if they cannot be reached.

        Who is told that there is a way may ask for it again: it is kept until another is asked for.
        """
        if self._last is None or self._last[0] != states:
            self._last = (states, self.asked(lambda backwards: backwards.rings(Ring(states, ()))))
        return self._last[1]
