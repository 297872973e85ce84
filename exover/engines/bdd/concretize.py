"""Concrete runs that follow the loop, step by step; along rings of states found backwards, as few steps as possible."""

from collections.abc import Callable, Sequence

from exover.engines.bdd.backward_reachability import Ring, Way
from exover.engines.bdd.space import Set
from exover.engines.bdd.steps import Stepper
from exover.loop.finite.abstraction import abstract, concretes
from exover.model.event import Event
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import Answers, Trace, run

Ends = Callable[[Answers], bool]
"""Whether a step ends as it must, by its actions."""


class SpuriousRun(Exception):
    """The loop has a run that no concrete run follows."""


class RunConcretizer:
    """A concrete run, so far: its events, the state it has come to, and that state as one of the loop's."""

    def __init__(self, stepper: Stepper, reference: Reference) -> None:
        self.stepper = stepper
        self.reference = reference
        self.events: list[Event] = []
        self.state: State = reference.start()
        self.held: Set = stepper.space.initial

    def step(self, number: int, goal: Set, ends: Ends | None = None) -> bool:
        """Take a step that event `number` stands for into `goal`, ending as it must; return whether there is one."""
        for concrete in concretes(self.stepper.loop, self.stepper.loop.events[number], self.state):
            after, actions = self.reference.step(self.state, concrete)
            held = self._held(number, after)
            if held & goal != self.stepper.space.none and (ends is None or ends(actions)):
                self.events.append(concrete)
                self.state, self.held = after, held
                return True
        return False

    def follow(self, number: int, goal: Set, ends: Ends | None = None) -> None:
        """Take that step; raises `SpuriousRun` if there is none."""
        if not self.step(number, goal, ends):
            raise SpuriousRun("no concrete run was found that follows the loop")

    def trace(self, loop_start: int | None = None) -> Trace:
        """Return the run."""
        return run(self.reference, tuple(self.events), loop_start)

    def _held(self, number: int, after: State) -> Set:
        """Return the loop's state: it stands for `after`, and tells what the step by event `number` did."""
        stepper = self.stepper
        stands = stepper.space.cube_of(abstract(stepper.loop, after))
        return stands & (stepper.post(self.held, number) if stepper.loop.observed else stepper.allowed)


def follow(walker: RunConcretizer, rings: Sequence[Ring], last: Set, ends: Ends | None = None) -> Trace:
    """Return the run that goes on inwards through the rings, of which the goal is the first.

    If that has ways, a step along one of them, into `last` and as `ends` says, is the last. Raises `SpuriousRun` if no
    concrete run does so.
    """
    for inner, ring in zip(reversed(rings[:-1]), reversed(rings[1:]), strict=True):
        _along(walker, ring.ways, inner.states, None)
    if rings[0].ways:
        _along(walker, rings[0].ways, last, ends)
    return walker.trace()


def _along(walker: RunConcretizer, ways: Sequence[Way], goal: Set, ends: Ends | None) -> None:
    """Take a step along one of the ways that are open."""
    none = walker.stepper.space.none
    if not any(walker.held & states != none and walker.step(number, goal, ends) for number, states in ways):
        raise SpuriousRun("no concrete run was found that follows the loop")
