"""Concrete witnesses of formulas: runs to a set of states, and lassos that meet every constraint."""

from collections.abc import Iterable
from typing import Protocol

from exover.engines.bdd.concretize import RunConcretizer, SpuriousRun
from exover.engines.bdd.fixpoints import Fixpoints
from exover.engines.bdd.ltl import Product
from exover.engines.bdd.manager import Set

LONGEST = 10_000
"""The number of steps after which the search for a loop is given up."""


class Run(Protocol):
    """A concrete run, with its current state as a set of the transition system of `Fixpoints`."""

    walker: RunConcretizer

    @property
    def held(self) -> Set:
        """The set of the one state that the run has reached."""

    def step(self, number: int, goal: Set) -> bool:
        """Take a step by this event into `goal`; return whether there is one."""


class LoopRun:
    """A run of the loop."""

    def __init__(self, walker: RunConcretizer) -> None:
        self.walker = walker

    @property
    def held(self) -> Set:
        """The state of the loop."""
        return self.walker.held

    def step(self, number: int, goal: Set) -> bool:
        """Take a step by this event into `goal`; return whether there is one."""
        return self.walker.step(number, goal)


class ProductRun:
    """A run of the product of the loop with a tableau, from one of the states `among`."""

    def __init__(self, walker: RunConcretizer, product: Product, among: Set) -> None:
        self.walker = walker
        self.product = product
        self.promises = self._choose(walker.held & among)

    @property
    def held(self) -> Set:
        """The state of the loop with what is promised."""
        return self.walker.held & self.product.space.bdd.cube(self.promises)

    def step(self, number: int, goal: Set) -> bool:
        """Take a step by this event into `goal` that keeps what is promised; return whether there is one."""
        product, bdd = self.product, self.product.space.bdd
        promised = product.promised(goal)
        if not self.walker.step(number, bdd.let(self.promises, promised) if self.promises else promised):
            return False
        among = self.walker.held & goal
        for bit, promise in zip(product.bits, product.promises, strict=True):
            among &= product.kept(promise) if self.promises[bit] else ~product.kept(promise)
        self.promises = self._choose(among)
        return True

    def _choose(self, among: Set) -> dict[str, bool]:
        """Return an assignment of promises with which the run can go on, greedily as few true ones as possible."""
        bdd = self.product.space.bdd
        found = {}
        for bit in self.product.bits:
            without = among & ~bdd.var(bit)
            found[bit] = without == self.product.space.none
            among = among & bdd.var(bit) if found[bit] else without
        return found


class Distances:
    """Distances of states to `right` by steps within `left`; rings are computed as far as they are needed."""

    def __init__(self, fixpoints: Fixpoints, left: Set, right: Set) -> None:
        self.none = fixpoints.none
        self.rings: list[Set] = []
        self._rest = fixpoints.rings(left, right)

    def distance(self, held: Set) -> int:
        """Return the distance of a state; raises `SpuriousRun` if `right` cannot be reached from it."""
        for number, ring in enumerate(self.rings):
            if ring & held != self.none:
                return number
        for ring in self._rest:
            self.rings.append(ring)
            if ring & held != self.none:
                return len(self.rings) - 1
        raise SpuriousRun("a run of the loop has no way to where it must go")


def come(run: Run, fixpoints: Fixpoints, left: Set, right: Set) -> None:
    """Continue the run by a shortest path within `left` into `right`; raises `SpuriousRun` if there is none."""
    way = Distances(fixpoints, left, right)
    for distance in reversed(range(way.distance(run.held))):
        advance(run, fixpoints, way.rings[distance], fixpoints.steps.events)


def advance(run: Run, fixpoints: Fixpoints, goal: Set, events: Iterable[int]) -> int:
    """Take a step into `goal` by the first of these events that has one; return it, or raise `SpuriousRun`."""
    for number in events:
        if run.held & fixpoints.steps.pre(goal, number) != fixpoints.none and run.step(number, goal):
            return number
    raise SpuriousRun("no concrete run was found that follows the loop")


def close_lasso(run: Run, fixpoints: Fixpoints, lasting: Set) -> int:
    """Continue the run within `lasting`, whose states all have fair runs within it, until it closes a fair loop.

    Return the number of steps before the loop. The run meets the constraints in turn, each by a shortest path, so its
    behaviour depends on finitely many states and must repeat. Raises `SpuriousRun` after `LONGEST` steps.
    """
    constraints = fixpoints.binding(lasting)
    everyone = frozenset(range(len(constraints)))
    ways: dict[int, Distances] = {}
    first = len(run.walker.events)
    places = [(run.walker.state.key(), run.held)]
    met: list[frozenset[int]] = []
    due = everyone
    while len(places) < LONGEST:
        resting = frozenset(k for k in everyone if run.held & constraints[k].states != fixpoints.none)
        goal, events = lasting, fixpoints.steps.events
        if due - resting:
            wanted = min(due - resting)
            if wanted not in ways:
                ways[wanted] = Distances(fixpoints, lasting, fixpoints.meeting(constraints[wanted], lasting))
            distance = ways[wanted].distance(run.held)
            if distance:
                goal = ways[wanted].rings[distance - 1]
            else:
                events = sorted(constraints[wanted].events)
        elif resting == everyone and fixpoints.before(run.held, run.held) != fixpoints.none:
            goal = run.held  # a step that stays where it is closes the shortest loop
        number = advance(run, fixpoints, goal, events)
        met.append(resting | {k for k in everyone if number in constraints[k].events})
        due = due - met[-1] or everyone
        place = (run.walker.state.key(), run.held)
        for index, earlier in enumerate(places):
            if earlier == place and everyone <= frozenset().union(*met[index:]):
                return first + index
        places.append(place)
    raise SpuriousRun("no concrete run was found that repeats itself")
