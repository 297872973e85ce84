"""Concrete runs to sets of states: as few steps as possible, found backwards through the rings, run forwards."""

from dataclasses import dataclass

from exover.model.event import Ask, Event, Observe
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import Trace, run
from exover.model.types import contains
from exover.verify.abstraction import abstract
from exover.verify.bdd.image import Label
from exover.verify.bdd.space import Set
from exover.verify.bdd.steps import Stepper
from exover.verify.loop import LoopEvent
from exover.verify.orders import candidates


class Spurious(Exception):
    """The loop has a run that no concrete run follows."""


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
        space = self.stepper.space
        depth = self._depth(target)
        return self._forwards(*self._backwards(self.rings[depth] & target, depth), space.none, None)

    def past(self, label: Label) -> Trace:
        """Return a shortest run whose last step passes this mark, which some reachable step does."""
        space = self.stepper.space
        depth = 0
        while True:
            for number in range(len(self.stepper.loop.events)):
                if label in self.stepper.trails[number].marked:
                    before = self.rings[depth] & self.stepper.pre(space.none, number, label)
                    if before != space.none:
                        return self._forwards(*self._backwards(before, depth), before, number)
            depth += 1
            self._ring(depth)

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

    def _forwards(self, events: list[int], goals: list[Set], last: Set, mark: int | None) -> Trace:
        """Return the concrete run of these events, and of event `mark` at its end; check that it goes where it must."""
        loop, state = self.stepper.loop, self.reference.start()
        concrete: list[Event] = []
        for number, goal in zip(events, goals, strict=True):
            event, state = self._step(state, loop.events[number], goal)
            concrete.append(event)
        if mark is not None:
            if not self.stepper.space.contains(last, abstract(loop, state)):
                raise Spurious("a concrete run leaves the abstract one")
            concrete.append(loop.events[mark].event)
        return run(self.reference, tuple(concrete))

    def _step(self, state: State, event: LoopEvent, goal: Set) -> tuple[Event, State]:
        """Return a concrete event that leads into `goal`, and where it leads."""
        loop = self.stepper.loop
        arguments = None
        if isinstance(event.event, Ask):
            arguments = loop.arguments[loop.request_number[event.event.request]]
        for concrete in candidates(event.event, event.cell, arguments, state):
            if self._like(concrete, event):
                after, _ = self.reference.step(state, concrete)
                if self.stepper.space.contains(goal, abstract(loop, after)):
                    return concrete, after
        raise Spurious("no concrete run was found that follows the loop")

    def _like(self, concrete: Event, event: LoopEvent) -> bool:
        """Return whether a concrete event is one of those that `event` stands for."""
        loop = self.stepper.loop
        match concrete:
            case Ask(name, args):
                arguments = loop.arguments[loop.request_number[name]]
                fits = all(contains(p.type, v) for p, v in zip(arguments.params, args, strict=True))
                return fits and arguments.cell_of(args) == event.cell
            case Observe(name, float(value)) if isinstance(event.event, Observe):
                if not contains(loop.model.variable[name].type, value):
                    return False
                number = loop.names.index(name)
                return number not in loop.samples or loop.reading_cell(number, value) == loop.reading_cell(
                    number, float(event.event.value)
                )
            case _:
                return True
