"""Whole steps on sets of states: an event's update, then passes of steps 3 to 5 until no state changes any more."""

from dataclasses import dataclass, field

from exover.verify.bdd.image import Image, Label
from exover.verify.bdd.space import Set, Space
from exover.verify.loop import ClosedLoop, Component, LoopEvent
from exover.verify.program import writes


@dataclass
class _Plan:
    """What steps of one event have needed so far: the components that ran, and in how many passes."""

    passes: int = 1
    components: set[int] = field(default_factory=set)


class Stepper:
    """Images and preimages of steps."""

    def __init__(self, loop: ClosedLoop) -> None:
        self.loop = loop
        self.space = Space(loop)
        self.image = Image(self.space)
        self._plans: dict[int, _Plan] = {}
        self._writes = [frozenset(writes(event.program)) for event in loop.events]
        self._memory = [n for n, v in enumerate(loop.variables) if v.key[0] in ("tried", "fallen")]

    def post(self, states: Set, number: int) -> Set:
        """Return the states after a step that event `number` begins, from `states`."""
        event = self.loop.events[number]
        states = self.image.post(states, event.program)
        if states == self.space.none:
            return states
        plan = self._plans.setdefault(number, _Plan())
        states = self._passes(states, self._writes[number], plan)
        for var in self._memory:
            states = self.space.assigned(states, var, 0)
        return states

    def _passes(self, states: Set, changed: frozenset[int], plan: _Plan) -> Set:
        """Run passes until the set is stable: a step ends, so a set that a pass leaves alone is one of ended steps.

        A component is left out while nothing that it reads was written since it last ran: it would do nothing.
        """
        clock = 1
        written = dict.fromkeys(changed, clock)
        ran: dict[int, int] = {}
        passes = 0
        while True:
            passes += 1
            before = states
            for number, component in enumerate(self.loop.body):
                if not self._due(component, number, written, ran):
                    continue
                plan.components.add(number)
                clock += 1
                ran[number] = clock
                after = self.image.post(states, component.program)
                if after != states:
                    clock += 1
                    written |= dict.fromkeys(component.writes, clock)
                    states = after
            plan.passes = max(plan.passes, passes)
            if states == before:
                return states

    def _due(self, component: Component, number: int, written: dict[int, int], ran: dict[int, int]) -> bool:
        last = ran.get(number)
        if last is None and component.always:
            return True
        return any(written.get(var, 0) > (last or 0) for var in component.reads)

    def pre(self, states: Set, number: int, goal: Label | None = None) -> Set:
        """Return the reachable states from which a step that event `number` begins leads into `states`.

        Exact on states from which `post` has been taken: it knows how many passes they need. With `goal`, also those
        whose step passes that mark.
        """
        space = self.space
        plan = self._plans.get(number)
        if plan is None:
            return space.none
        for var in self._memory:
            states = space.before_assigned(states, var, 0)
        for _ in range(plan.passes):
            for component in sorted(plan.components, reverse=True):
                states = self.image.pre(states, self.loop.body[component].program, goal)
        return self.image.pre(states, self.loop.events[number].program, goal)

    def event(self, number: int) -> LoopEvent:
        """Return event `number`."""
        return self.loop.events[number]


@dataclass
class Reached:
    """The reachable states, those of them that some step ends in, and the marks that some step passes."""

    states: Set
    after: Set
    marks: frozenset[Label]


def explore(stepper: Stepper) -> Reached:
    """Return the reachable states: the least set with the initial state that no event leaves.

    Events take turns, each from all states it has not been tried in yet (chaining: Roig, Cortadella, Pastor 1995).
    """
    space = stepper.space
    total, after = space.initial, space.none
    tried = [space.none] * len(stepper.loop.events)
    grown = True
    while grown:
        grown = False
        for number in range(len(tried)):
            fresh = total & ~tried[number]
            if fresh != space.none:
                grown = True
                tried[number] = total
                image = stepper.post(fresh, number)
                after |= image
                total |= image
    return Reached(total, after, frozenset(stepper.image.met))
