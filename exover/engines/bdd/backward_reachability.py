"""Backward reachability: the states from which a set can be reached, and a shortest run from the initial state.

Only events that change a variable on which the set depends lead other states into it, so sets depend on few variables
(a cone of influence). The result is exact on the universe of `Stepper`, which all runs stay in.
"""

from collections.abc import Callable, Collection, Iterable
from functools import cached_property
from math import inf

from exover.dataclass import dataclass
from exover.engines.bdd.manager import Set
from exover.engines.bdd.quiescent import QuiescentSteps
from exover.engines.bdd.steps import Stepper
from exover.loop.finite.builder import LoopEvent
from exover.model.property import Label

Allowed = Callable[[LoopEvent], bool]
Way = tuple[int, Set]
"""The number of an event, and states from which it leads into the goal."""
FAR = 8
"""The bound of `straight` search: variables that differ from the initial state, and rings."""


class TooWide(Exception):
    """A set has more nodes than the limit."""


@dataclass(frozen=True, slots=True)
class Ring:
    """The states at one distance from the goal, and the events that lead from them one ring inwards."""

    states: Set
    ways: tuple[Way, ...]


@dataclass
class BackwardReachability:
    """Preimages within a set of states that no step leaves; raises `TooWide` when a set has more than `limit` nodes.

    `straight`: a heuristic that keeps only those states of a ring which are most like the initial one. Sets stay small,
    but a run may be missed, or not be a shortest one.
    """

    stepper: Stepper | QuiescentSteps
    within: Set
    limit: int | None
    straight: bool = False

    @cached_property
    def _by_variable(self) -> dict[int, list[int]]:
        found: dict[int, list[int]] = {}
        for number in range(len(self.stepper.loop.events)):
            for var in self.stepper.step(number).changed:
                found.setdefault(var, []).append(number)
        return found

    def passing(self, mark: Label) -> list[int]:
        """Return the events whose steps may pass a mark."""
        return self._by_mark.get(mark, [])

    @cached_property
    def _by_mark(self) -> dict[Label, list[int]]:
        found: dict[Label, list[int]] = {}
        for number in range(len(self.stepper.loop.events)):
            for mark in self.stepper.step(number).marked:
                found.setdefault(mark, []).append(number)
        return found

    def touching(self, states: Set) -> list[int]:
        """Return the events that may change something on which the states depend."""
        return self.changing(self.stepper.space.support(states))

    def changing(self, variables: Collection[int]) -> list[int]:
        """Return the events that may change one of these variables."""
        return sorted({number for var in variables for number in self._by_variable.get(var, ())})

    def before(self, states: Set, events: Iterable[int], mark: Label | None = None) -> tuple[Way, ...]:
        """Return, for each event, the states from which it leads into `states` or past `mark`; empty ones left out."""
        found = []
        for number in events:
            ways = self._cut(self.stepper.pre(states, number, mark))
            if ways != self.stepper.space.none:
                found.append((number, ways))
        return tuple(found)

    def _cut(self, states: Set) -> Set:
        states = states & self.within
        if self.stepper.space.sifted(states) > (self.limit or inf):
            raise TooWide
        return states

    def rings(self, first: Ring) -> list[Ring] | None:
        """Return the rings from `first` outwards to that of the initial state; None if no run to `first` is found."""
        space, rings = self.stepper.space, [Ring(self._nearest(first.states), first.ways)]
        seen = rings[0].states
        while space.initial & rings[-1].states == space.none:
            last = space.simplified(rings[-1].states, self.within & (rings[-1].states | ~seen))
            ways = self.before(last, self.touching(last))
            states = self._cut(self._nearest(self.union(ways) & ~seen))
            if states == space.none or (self.straight and len(rings) == FAR):
                return None
            rings.append(Ring(states, ways))
            seen = self._cut(seen | states)
        return rings

    def _nearest(self, states: Set) -> Set:
        """Return `states`; if `straight`, those in which the fewest variables, or one more, differ from the start."""
        if not self.straight:
            return states
        distances = self._distances(self.stepper.space.support(states))
        near = (k for k, within in enumerate(distances) if states & within != self.stepper.space.none)
        return states & distances[min(next(near, FAR) + 1, FAR)]

    def _distances(self, variables: Iterable[int]) -> list[Set]:
        """Return for each k in 0 .. `FAR` the states in which at most k of the variables differ from the start."""
        space = self.stepper.space
        found = [space.all] * (FAR + 1)
        for var in sorted(variables, key=space.depth, reverse=True):
            alike = space.is_value(var, space.loop.variables[var].initial)
            found = [(alike & same) | (~alike & less) for same, less in zip(found, [space.none, *found], strict=False)]
        return found

    def union(self, ways: Iterable[Way]) -> Set:
        """Return the union of the sets."""
        return self.stepper.space.disjunction(states for _, states in ways)

    def possible(self, goal: Set, allowed: Allowed, enough: Callable[[Set], bool]) -> Set:
        """Return the states from which allowed events can lead into `goal`: the least Z with Z = goal or EX Z.

        Events take turns (chaining); the iteration stops as soon as `enough` is true of the set so far.
        """
        events, found = self.stepper.loop.events, goal
        while not enough(found):
            before = found
            for number in self.touching(found):
                if allowed(events[number]):
                    found |= self._cut(self.stepper.pre(found, number))
            if found == before:
                break
            self._cut(found)
        return found
