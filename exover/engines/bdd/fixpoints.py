"""EX, E[. U .] and EG over fair runs, as fixpoints of preimages.

Least and greatest fixpoints as in Emerson, Clarke 1980; those of fair runs as in Emerson, Lei 1986.
"""

from collections.abc import Iterator, Sequence
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.bdd.fair_steps import Constraint, TransitionSystem
from exover.engines.bdd.manager import Set


@dataclass
class Fixpoints:
    """CTL operators over the fair runs of `steps`: those that meet each constraint infinitely often."""

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
        if missing & states != self.none:  # events that change nothing on which `states` depend stay within them
            numbers = [*sorted(set(self.steps.events) - set(numbers)), *numbers]
        for number in numbers:
            if missing == self.none:
                break
            more = missing & self.steps.pre(states, number)
            found |= more
            missing &= ~more
        return found

    def until(self, left: Set, right: Set) -> Set:
        """Return E [left U right]: the least fixpoint of preimages.

        Events take turns, each applied to the states that it has not been applied to yet (chaining).
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
        """Return the states with a fair run that stays in `part` (EG over fair runs).

        They are the greatest Z within `part` such that from each state of Z, for each constraint, a run within Z leads
        to a step within Z that meets it.
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
        """Return the states of `part` from which a run within it leads to a step within it that meets a constraint.

        Return all of `part` if it is easily seen that every infinite run within it can meet the constraint.
        """
        if part & ~constraint.states == self.none or self._is_met_aside(constraint, part):
            return part
        return self.until(part, self.meeting(constraint, part))

    def binding(self, part: Set) -> list[Constraint]:
        """Return the constraints whose states do not contain `part`."""
        return [constraint for constraint in self.constraints if part & ~constraint.states != self.none]

    def _is_met_aside(self, constraint: Constraint, part: Set) -> bool:
        """Return whether in each state of `part` the constraint is met by its `states`, or by one of its events that
        changes nothing on which `part` depends.
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
        """Yield the states at distance 0, 1, 2, … from `right` by steps within `left`, until a ring is empty.

        The last ring yielded is the empty one.
        """
        found = seen = right & self.steps.universe
        yield found
        while found != self.none:
            found = self.before(found, left & self.steps.universe & ~seen)
            seen |= found
            yield found
