"""Concrete runs to sets of states: as few steps as possible, found backwards through the rings, run forwards."""

from collections.abc import Callable
from dataclasses import dataclass

from exover.model.event import Ask, Event, Launched, Observe
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import Answers, Trace, run
from exover.model.types import contains
from exover.verify.abstraction import abstract
from exover.verify.bdd.image import Label
from exover.verify.bdd.space import Set
from exover.verify.bdd.steps import Stepper
from exover.verify.loop import LoopEvent
from exover.verify.orders import candidates

Ends = Callable[[Answers, State], bool]
"""Whether a step ends as it must, by its actions and the state after it."""


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
        depth = self._depth(target)
        return self._forwards(*self._backwards(self._ring(depth) & target, depth), None)

    def into(self, target: Set) -> Trace:
        """Return a shortest run of at least one step into `target`, which some reachable step ends in."""

        def ends(actions: Answers, state: State) -> bool:
            return self._within(state, target)

        return self._run(target, None, ends)

    def to_launch(self, request: str) -> Trace:
        """Return a shortest run whose last step launches the request, which some reachable step does."""

        def ends(actions: Answers, state: State) -> bool:
            return any(isinstance(action, Launched) and action.request == request for action in actions)

        return self._run(self.stepper.space.none, ("launch", request), ends)

    def _run(self, target: Set, mark: Label | None, ends: Ends) -> Trace:
        """Return a shortest run whose last step leads into `target` or past `mark`, and so that `ends` agrees."""
        space, depth = self.stepper.space, 0
        while True:
            for number, trail in enumerate(self.stepper.trails):
                if mark is not None and mark not in trail.marked:
                    continue
                before = self._ring(depth) & self.stepper.pre(target, number, mark)
                if before != space.none:
                    events, goals = self._backwards(before, depth)
                    return self._forwards(events, goals, (number, ends))
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

    def _forwards(self, events: list[int], goals: list[Set], last: tuple[int, Ends] | None) -> Trace:
        """Return the concrete run of these events, each into its goal, and of a last one as it must end."""
        loop, state = self.stepper.loop, self.reference.start()
        concrete: list[Event] = []
        for number, goal in zip(events, goals, strict=True):

            def arrives(actions: Answers, after: State, goal: Set = goal) -> bool:
                return self._within(after, goal)

            event, state = self._step(state, loop.events[number], arrives)
            concrete.append(event)
        if last is not None:
            concrete.append(self._step(state, loop.events[last[0]], last[1])[0])
        return run(self.reference, tuple(concrete))

    def _within(self, state: State, states: Set) -> bool:
        return self.stepper.space.contains(states, abstract(self.stepper.loop, state))

    def _step(self, state: State, event: LoopEvent, ends: Ends) -> tuple[Event, State]:
        """Return a concrete event that ends as it must, and where it leads."""
        loop = self.stepper.loop
        arguments = None
        if isinstance(event.event, Ask):
            arguments = loop.arguments[loop.request_number[event.event.request]]
        for concrete in candidates(event.event, event.cell, arguments, state):
            if self._like(concrete, event):
                after, actions = self.reference.step(state, concrete)
                if ends(actions, after):
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
