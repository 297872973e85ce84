"""Backwards through the steps: which states have a step, a run, a fair run that does what is asked.

Least and greatest fixpoints as in Emerson, Clarke 1980; those of fair runs as in Emerson, Lei 1986.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from exover.verify.bdd.space import Set
from exover.verify.temporal.steps import Constraint, Steps


@dataclass
class Fixpoints:
    """Questions about the fair runs of `steps`: those that meet every one of the constraints again and again."""

    steps: Steps
    constraints: Sequence[Constraint] = ()
    _last: tuple[Set, Set] | None = None

    @property
    def none(self) -> Set:
        """No state."""
        return self.steps.space.none

    @cached_property
    def fair(self) -> Set:
        """The states with a fair run."""
        return self.always(self.steps.universe)

    def before(self, states: Set) -> Set:
        """Return the states with a step into `states`."""
        if self._last is None or self._last[0] != states:
            self._last = (states, self._before(states))
        return self._last[1]

    def _before(self, states: Set) -> Set:
        found = self.none
        for number in self.steps.events:
            found |= self.steps.pre(states, number)
            if found == self.steps.universe:
                break
        return found

    def until(self, left: Set, right: Set) -> Set:
        """Return the states with a run that stays in `left` until it comes into `right`: the least fixpoint.

        Events take turns, each with all states that it has not been tried on yet (chaining).
        """
        steps = self.steps
        found = right & steps.universe
        tried: dict[int, Set] = dict.fromkeys(steps.events, self.none)
        grown = True
        while grown:
            grown = False
            for number in steps.events:
                fresh = found & ~tried[number]
                if fresh == self.none or not steps.touches(found, number):
                    continue
                tried[number] = found
                more = left & steps.pre(fresh, number) & ~found
                if more != self.none:
                    found |= more
                    grown = True
        return found

    def always(self, part: Set) -> Set:
        """Return the states with a fair run that stays in `part`.

        They are the greatest Z within `part` such that from each of its states a run within Z comes to meet each
        constraint by a step that stays in Z.
        """
        found = part & self.steps.universe
        while True:
            before = found
            for constraint in self.binding(found):
                found = self.until(found, found & self.meeting(constraint, found))
            if found == before:
                found &= self.before(found)
            if found == before:
                return found

    def binding(self, part: Set) -> list[Constraint]:
        """Return the constraints that a run within `part` does not meet anyway."""
        return [constraint for constraint in self.constraints if part & ~constraint.states != self.none]

    def meeting(self, constraint: Constraint, goal: Set) -> Set:
        """Return the states with a step into `goal` that meets the constraint."""
        found = constraint.states & self.before(goal)
        for number in constraint.events:
            found |= self.steps.pre(goal, number)
        return found

    def rings(self, left: Set, right: Set, held: Set) -> list[Set]:
        """Return the states by how many steps they need, within `left`, to come into `right`; none first.

        There are as many rings as it takes to find `held`; the last is empty if it cannot come there.
        """
        found = [right & self.steps.universe]
        seen = found[0]
        while found[-1] != self.none and found[-1] & held == self.none:
            found.append(left & self.before(found[-1]) & ~seen)
            seen |= found[-1]
        return found
