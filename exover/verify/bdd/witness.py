"""Concrete runs along rings of states that were found backwards."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from exover.model.event import Ask, Event, Observe
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import Answers, Trace, run
from exover.model.types import contains
from exover.verify.abstraction import abstract
from exover.verify.bdd.backwards import Ring, Way
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
    """Follows rings with a concrete run."""

    stepper: Stepper
    reference: Reference

    def follow(self, rings: Sequence[Ring], ends: Ends) -> Trace:
        """Return a run from the initial state inwards through the rings, of which the goal is the first.

        If that has ways, a step along one of them is the last, and ends as it must.
        """
        state = self.reference.start()
        concrete: list[Event] = []
        for inner, ring in zip(reversed(rings[:-1]), reversed(rings[1:]), strict=True):

            def arrives(_: Answers, after: State, goal: Set = inner.states) -> bool:
                return self.within(after, goal)

            event, state = self._along(state, ring.ways, arrives)
            concrete.append(event)
        if rings[0].ways:
            concrete.append(self._along(state, rings[0].ways, ends)[0])
        return run(self.reference, tuple(concrete))

    def _along(self, state: State, ways: tuple[Way, ...], ends: Ends) -> tuple[Event, State]:
        """Return a concrete event along one of the ways that are open in this state, and where it leads."""
        here = self._only(state)
        for number, states in ways:
            if here & states != self.stepper.space.none:
                found = self._step(state, self.stepper.loop.events[number], ends)
                if found is not None:
                    return found
        raise Spurious("no concrete run was found that follows the loop")

    def _only(self, state: State) -> Set:
        return self.stepper.space.cube(abstract(self.stepper.loop, state))

    def within(self, state: State, states: Set) -> bool:
        """Return whether a concrete state is one of those of a set."""
        return bool((self._only(state) & states) != self.stepper.space.none)

    def _step(self, state: State, event: LoopEvent, ends: Ends) -> tuple[Event, State] | None:
        """Return a concrete event that ends as it must, and where it leads; None if none was found."""
        loop = self.stepper.loop
        arguments = None
        if isinstance(event.event, Ask):
            arguments = loop.arguments[loop.request_number[event.event.request]]
        for concrete in candidates(event.event, event.cell, arguments, state):
            if self._like(concrete, event):
                after, actions = self.reference.step(state, concrete)
                if ends(actions, after):
                    return concrete, after
        return None

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
