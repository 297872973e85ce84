"""Concrete runs to sets of states: as few steps as possible, found backwards through the rings, run forwards."""

from dataclasses import dataclass

from exover.model.event import Launched
from exover.model.semantics import Reference
from exover.model.trace import Answers, Trace
from exover.verify.bdd.image import Label
from exover.verify.bdd.space import Set
from exover.verify.bdd.steps import Stepper
from exover.verify.bdd.walk import Ends, Spurious, Walker


@dataclass
class Witnesses:
    """Finds shortest concrete runs; keeps the rings it has made."""

    stepper: Stepper
    reference: Reference

    def __post_init__(self) -> None:
        self.rings: list[Set] = [self.stepper.space.initial]
        self.seen: Set = self.stepper.space.initial

    def to(self, target: Set) -> Trace:
        """Return a shortest run to a state of `target`, which must be reachable."""
        depth = self._depth(target)
        return self._forwards(*self._backwards(self._ring(depth) & target, depth), None)

    def into(self, target: Set) -> Trace:
        """Return a shortest run of at least one step into `target`, which some reachable step ends in."""
        return self._run(target, None, None)

    def to_launch(self, request: str) -> Trace:
        """Return a shortest run whose last step launches the request, which some reachable step does."""

        def ends(actions: Answers) -> bool:
            return any(isinstance(action, Launched) and action.request == request for action in actions)

        return self._run(self.stepper.space.none, ("launch", request), ends)

    def _run(self, target: Set, mark: Label | None, ends: Ends | None) -> Trace:
        """Return a shortest run whose last step leads into `target` or past `mark`, and so that `ends` agrees."""
        space, depth = self.stepper.space, 0
        while True:
            for number, trail in enumerate(self.stepper.trails):
                if mark is not None and mark not in trail.marked:
                    continue
                before = self._ring(depth) & self.stepper.pre(target, number, mark)
                if before != space.none:
                    events, goals = self._backwards(before, depth)
                    return self._forwards(events, goals, (number, space.all if mark else target, ends))
            depth += 1

    def _depth(self, target: Set) -> int:
        depth = 0
        while (self._ring(depth) & target) == self.stepper.space.none:
            depth += 1
        return depth

    def _ring(self, depth: int) -> Set:
        """Return the states that `depth` steps reach and no fewer."""
        space = self.stepper.space
        while len(self.rings) <= depth:
            found = space.none
            for number in range(len(self.stepper.loop.events)):
                found |= self.stepper.post(self.rings[-1], number)
            self.rings.append(found & ~self.seen)
            self.seen |= found
        return self.rings[depth]

    def _backwards(self, target: Set, depth: int) -> tuple[list[int], list[Set]]:
        """Return events that lead from the initial state into `target`, and where each of them must lead."""
        events: list[int] = []
        goals: list[Set] = []
        for ring in reversed(self.rings[:depth]):
            number, before = self._step_into(ring, target)
            events.insert(0, number)
            goals.insert(0, target)
            target = before
        return events, goals

    def _step_into(self, ring: Set, target: Set) -> tuple[int, Set]:
        for number in range(len(self.stepper.loop.events)):
            before = ring & self.stepper.pre(target, number)
            if before != self.stepper.space.none:
                return number, before
        raise Spurious("a ring has a state that no step leads to")

    def _forwards(self, events: list[int], goals: list[Set], last: tuple[int, Set, Ends | None] | None) -> Trace:
        """Return the concrete run of these events, each into its goal, and of a last one as it must end."""
        walker = Walker(self.stepper, self.reference)
        for number, goal in zip(events, goals, strict=True):
            walker.follow(number, goal)
        if last is not None:
            walker.follow(*last)
        return walker.trace()
