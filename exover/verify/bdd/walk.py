"""A concrete run that follows the loop, step by step."""

from collections.abc import Callable

from exover.model.event import Ask, Event, Observe
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import Answers, Trace, run
from exover.model.types import contains
from exover.verify.abstraction import abstract
from exover.verify.bdd.space import Set
from exover.verify.bdd.steps import Stepper
from exover.verify.loop import LoopEvent
from exover.verify.orders import candidates

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
        for concrete in self._candidates(self.stepper.loop.events[number]):
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

    def _candidates(self, event: LoopEvent) -> list[Event]:
        """Return concrete events for which `event` stands."""
        loop = self.stepper.loop
        arguments = None
        if isinstance(event.event, Ask):
            arguments = loop.arguments[loop.request_number[event.event.request]]
        found = candidates(event.event, event.cell, arguments, self.state)
        return [concrete for concrete in found if self._like(concrete, event)]

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
