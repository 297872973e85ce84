"""Home states: from every state, observations and reports alone lead to one in which nothing is active.

docs/architecture.md has the proof. Checked here are its premises: some readings of the posters disable all launch
rules, and there are no assumptions that forbid steps.
"""

from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.bdd.manager import Set
from exover.engines.bdd.steps import Stepper
from exover.loop.finite.variables import MEMORY, PLACES
from exover.model.index import ModelIndex

OWNED = ("phase", "class", "order")
"""Kinds of variables of a slot; they are 0 while it is idle."""


@dataclass
class HomeStates:
    """The states between steps in which nothing is active and no launch rule does anything.

    `lone`: and nothing waits; sound only if every wait can come to an end.
    """

    stepper: Stepper
    lone: bool = False

    @cached_property
    def disabling(self) -> Set:
        """Readings of posters with which no launch rule ever does anything."""
        space = self.stepper.space
        kept = {name for var in self._posters() for name in space.bits[var]}
        launching = self.stepper.launching()
        return space.conjunction(~space.bdd.exist(space.bdd.support(each) - kept, each) for each in launching)

    def _posters(self) -> list[int]:
        loop = self.stepper.loop
        return [loop.index["reading", k] for k, _ in ModelIndex(loop.model).posters if k in loop.samples]

    @cached_property
    def applies(self) -> bool:
        """True iff home states can always be reached: readings disable all launch rules, and no step is forbidden."""
        return bool(self.disabling != self.stepper.space.none and self.stepper.allowed == self.stepper.space.all)

    @cached_property
    def _values(self) -> dict[int, dict[str, bool]]:
        variables, none = enumerate(self.stepper.loop.variables), OWNED + MEMORY + PLACES * self.lone
        return {n: self.stepper.space.literals(n, 0) for n, v in variables if v.key[0] in none}

    def among(self, states: Set) -> Set:
        """Return `states` with the variables that are 0 in every home state replaced by 0."""
        space = self.stepper.space
        literals: dict[str, bool] = {}
        for var in space.support(states):
            literals |= self._values.get(var, {})
        return space.bdd.let(literals, states) if literals else states

    @cached_property
    def _parts(self) -> dict[int, list[Set]]:
        """Maps a variable to the invariants of home states that depend on it."""
        space = self.stepper.space
        found: dict[int, list[Set]] = {}
        for part in (self.disabling, *map(self.among, self.stepper.stable)):
            for var in space.support(part):
                found.setdefault(var, []).append(part)
        return found

    def lacks(self, states: Set) -> bool:
        """Return True only if home states can always be reached and none of them is among `states`."""
        if not self.applies:
            return False
        space, rest = self.stepper.space, self.among(states)
        looked_at: set[int] = set()
        while rest != space.none:
            fresh = space.support(rest) - looked_at
            if not fresh:
                return False
            looked_at |= fresh
            for var in sorted(fresh):
                rest &= space.constraints[var]
                for part in self._parts.get(var, ()):
                    rest &= part
        return True
