"""Concretization: runs of the reference interpreter that follow runs of the loop, such as those along rings."""

from collections.abc import Callable, Sequence

from exover.engines.bdd.backward_reachability import Ring, Way
from exover.engines.bdd.manager import Set
from exover.engines.bdd.steps import Stepper
from exover.loop.finite.abstraction import abstract, concretes
from exover.model.event import Event
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import Answers, Trace, run

Ends = Callable[[Answers], bool]
"""Whether the actions of a step are as required."""


class SpuriousRun(Exception):
    """The loop has a run that no concrete run was found to follow."""


class RunConcretizer:
    """A concrete run so far: its events, its last state, and that state as a set of states of the loop (`held`)."""

    def __init__(self, stepper: Stepper, reference: Reference) -> None:
        self.stepper = stepper
        self.reference = reference
        self.events: list[Event] = []
        self.state: State = reference.start()
        self.held: Set = stepper.space.initial

    def step(self, number: int, goal: Set, ends: Ends | None = None) -> bool:
        """Take a concrete step of event `number` into `goal`, actions as `ends` says; return whether there is one."""
        for concrete in concretes(self.stepper.loop, self.stepper.loop.events[number], self.state):
            after, actions = self.reference.step(self.state, concrete)
            held = self._held(number, after)
            if held & goal != self.stepper.space.none and (ends is None or ends(actions)):
                self.events.append(concrete)
                self.state, self.held = after, held
                return True
        return False

    def follow(self, number: int, goal: Set, ends: Ends | None = None) -> None:
        """Take a step as `step` does; raises `SpuriousRun` if there is none."""
        if not self.step(number, goal, ends):
            raise SpuriousRun("no concrete run was found that follows the loop")

    def trace(self, loop_start: int | None = None) -> Trace:
        """Return the run."""
        return run(self.reference, tuple(self.events), loop_start)

    def _held(self, number: int, after: State) -> Set:
        """Return the loop's states that stand for `after`, with what the step by event `number` did."""
        stepper = self.stepper
        stands = stepper.space.cube_of(abstract(stepper.loop, after))
        return stands & (stepper.post(self.held, number) if stepper.loop.observed else stepper.allowed)


def follow(walker: RunConcretizer, rings: Sequence[Ring], last: Set, ends: Ends | None = None) -> Trace:
    """Return the run that goes inwards through the rings, of which the goal is the first.

    If the goal has ways, the run ends with one more step along one of them, into `last` and with actions that satisfy
    `ends`. Raises `SpuriousRun` if no concrete run is found.
    """
    for inner, ring in zip(reversed(rings[:-1]), reversed(rings[1:]), strict=True):
        _along(walker, ring.ways, inner.states, None)
    if rings[0].ways:
        _along(walker, rings[0].ways, last, ends)
    return walker.trace()


def _along(walker: RunConcretizer, ways: Sequence[Way], goal: Set, ends: Ends | None) -> None:
    """Take a step into `goal` along one of the ways whose states hold; raises `SpuriousRun` if there is none."""
    none = walker.stepper.space.none
    if not any(walker.held & states != none and walker.step(number, goal, ends) for number, states in ways):
        raise SpuriousRun("no concrete run was found that follows the loop")
