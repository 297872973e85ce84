"""A concrete run that follows the loop, step by step."""

from collections.abc import Callable

from exover.loop.finite.abstraction import abstract, concretes
from exover.model.event import Event
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import Answers, Trace, run
from exover.verify.bdd.space import Set
from exover.verify.bdd.steps import Stepper

Ends = Callable[[Answers], bool]
"""Whether a step ends as it must, by its actions."""


class Spurious(Exception):
    """The loop has a run that no concrete run follows."""


class Walker:
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
        """Take that step; raises `Spurious` if there is none."""
        if not self.step(number, goal, ends):
            raise Spurious("no concrete run was found that follows the loop")

    def trace(self, loop_start: int | None = None) -> Trace:
        """Return the run."""
        return run(self.reference, tuple(self.events), loop_start)

    def _held(self, number: int, after: State) -> Set:
        """Return the loop's state: it stands for `after`, and tells what the step by event `number` did."""
        stepper = self.stepper
        stands = stepper.space.cube_of(abstract(stepper.loop, after))
        return stands & (stepper.post(self.held, number) if stepper.loop.observed else stepper.allowed)
