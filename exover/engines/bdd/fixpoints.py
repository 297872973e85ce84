"""EX, E[. U .] and EG over fair runs, as fixpoints of preimages.

Least and greatest fixpoints as in Emerson, Clarke 1980; those of fair runs as in Emerson, Lei 1986.
"""

from collections.abc import Iterator, Sequence
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.bdd.fair_steps import Constraint, TransitionSystem
from exover.engines.bdd.space import Set


@dataclass
class Fixpoints:
    """Questions about the fair runs of `steps`: those that meet every one of the constraints again and again."""

    steps: TransitionSystem
    constraints: Sequence[Constraint] = ()
    _last: tuple[Set, Set, Set] | None = None

    @property
    def none(self) -> Set:
        """No state."""
        return self.steps.space.none

    @cached_property
    def fair(self) -> Set:
        """The states with a fair run."""
        return self.always(self.steps.universe)

    def before(self, states: Set, within: Set | None = None) -> Set:
        """Return the states, of those `within`, with a step into `states`."""
        within = self.steps.universe if within is None else within
        if self._last is None or self._last[:2] != (states, within):
            self._last = (states, within, self._before(states, within))
        return self._last[2]

    def _before(self, states: Set, missing: Set) -> Set:
        found, numbers = self.none, self.steps.touching(states)
        if missing & states != self.none:  # by what changes nothing on which they depend a step stays within them
            numbers = [*sorted(set(self.steps.events) - set(numbers)), *numbers]
        for number in numbers:
            if missing == self.none:
                break
            more = missing & self.steps.pre(states, number)
            found |= more
            missing &= ~more
        return found

    def until(self, left: Set, right: Set) -> Set:
        """Return the states with a run that stays in `left` until it comes into `right`: the least fixpoint.

        Events take turns, each with all states that it has not been tried on yet (chaining).
        """
        steps = self.steps
        found = right & steps.universe
        tried: dict[int, Set] = {}
        missing, grown = left & steps.universe & ~found, True
        while grown and missing != self.none:
            grown = False
            for number in steps.touching(found):
                fresh = found & ~tried[number] if number in tried else found
                tried[number] = found
                more = missing & steps.pre(fresh, number)
                if more != self.none:
                    found |= more
                    missing &= ~more
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
            found = self.before(found, found)
            for constraint in self.constraints:
                found = self.meets(constraint, found)
            if found == before:
                return found

    def meets(self, constraint: Constraint, part: Set) -> Set:
        """Return the states of `part` from which a run within it comes to meet a constraint by a step that stays in it.

        All of them, if it is seen at once that every run within `part` can do so, provided that it goes on.
        """
        if part & ~constraint.states == self.none or self._is_met_aside(constraint, part):
            return part
        return self.until(part, self.meeting(constraint, part))

    def binding(self, part: Set) -> list[Constraint]:
        """Return the constraints whose states do not contain `part`."""
        return [constraint for constraint in self.constraints if part & ~constraint.states != self.none]

    def _is_met_aside(self, constraint: Constraint, part: Set) -> bool:
        """Return whether it is seen that a run within `part` can meet the constraint by the way: where it does not
        do so anyway, by an event that changes nothing on which `part` depends.
        """
        missing = part & ~constraint.states
        for number in sorted(constraint.events - set(self.steps.touching(part))):
            missing &= ~self.steps.pre(part, number)
        return bool(missing == self.none)

    def meeting(self, constraint: Constraint, part: Set) -> Set:
        """Return the states of `part` with a step that stays in it and meets the constraint."""
        found = constraint.states & self.before(part, part)
        for number in constraint.events:
            found |= part & self.steps.pre(part, number)
        return found

    def rings(self, left: Set, right: Set) -> Iterator[Set]:
        """Yield the states by how many steps they need, within `left`, to come into `right`; none first.

        The last ring is empty.
        """
        found = seen = right & self.steps.universe
        yield found
        while found != self.none:
            found = self.before(found, left & self.steps.universe & ~seen)
            seen |= found
            yield found
