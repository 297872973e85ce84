"""Whole steps on sets of states: an event's update, then passes of steps 3 to 5 until no state changes any more."""

from dataclasses import dataclass

from exover.verify.bdd.image import PASS, Image, Label, Marking
from exover.verify.bdd.space import Set, Space
from exover.verify.loop import ClosedLoop, Component
from exover.verify.program import Program, marks, writes
from exover.verify.states import MEMORY


@dataclass(frozen=True)
class Trail:
    """What steps of one event do from all reachable states: the update, and the components that changed something.

    `changed` and `marked`: the variables that they may change, the marks that they may pass; `visited` as in `Image`.
    """

    programs: tuple[Program, ...]
    changed: frozenset[int]
    marked: frozenset[Label]
    visited: dict[int, set[int]]


class Stepper:
    """Images and preimages of steps."""

    def __init__(self, loop: ClosedLoop) -> None:
        self.loop = loop
        self.space = Space(loop)
        self.image = Image(self.space)
        self.trails: list[Trail] = []
        self._writes = [frozenset(writes(event.program)) for event in loop.events]
        self.allowed: Set = self.space.all
        """Only steps that end in these states are taken."""
        self._memory = [n for n, v in enumerate(loop.variables) if v.key[0] in MEMORY]

    def post(self, states: Set, number: int) -> Set:
        """Return the states after a step that event `number` begins, from `states`."""
        return self._run(states, number, []) & self.allowed

    def _run(self, states: Set, number: int, trail: list[Program]) -> Set:
        program = self.loop.events[number].program
        trail.append(program)
        states = self.image.post(states, program)
        if states != self.space.none:
            states = self._passes(states, self._writes[number], trail)
            for var in self._memory:
                states = self.space.assigned(states, var, 0)
        return states

    def _passes(self, states: Set, changed: frozenset[int], trail: list[Program]) -> Set:
        """Run passes until none changes a state, and note the components that did.

        A component is left out while nothing that it reads was written since it last ran: it would do nothing.
        """
        clock = 1
        written = dict.fromkeys(changed, clock)
        ran: dict[int, int] = {}
        while True:
            self.image.note(PASS, states)
            moved = False
            for number, component in enumerate(self.loop.body):
                if not _due(component, number, written, ran):
                    continue
                clock += 1
                ran[number] = clock
                self.image.moved = False
                states = self.image.post(states, component.program)
                if self.image.moved:
                    clock += 1
                    written |= dict.fromkeys(component.writes, clock)
                    trail.append(component.program)
                    moved = True
            if not moved:
                return states

    def learn(self, states: Set) -> None:
        """Note what every event does from `states`, which no event leaves; `pre` is exact on them from then on."""
        self.trails = []
        for number in range(len(self.loop.events)):
            trail: list[Program] = []
            self.image.visited = {}
            self._run(states, number, trail)
            changed = frozenset(var for program in trail for var in writes(program))
            passed = frozenset(label for program in trail for label in marks(program))
            self.trails.append(Trail(tuple(trail), changed, passed, self.image.visited))

    def pre(self, states: Set, number: int, goal: Label | None = None, avoid: Label | None = None) -> Set:
        """Return the states from which a step that event `number` begins leads into `states`, or past the mark `goal`.

        A step that passes the mark `avoid` does not count. Exact on the states that were learnt; what it says of
        others means nothing.
        """
        space = self.space
        if goal is None or self.allowed == space.all:
            forced = {goal: space.all, avoid: space.none}
            return self._pre(states & self.allowed, number, forced.get)
        # beside the states that lead where they must go, those that lead where they may: they are right past the mark
        passed = space.passenger("passed")
        both = space.bdd.ite(space.bdd.var(passed), self.allowed, states & self.allowed)
        found = self._pre(
            both, number, lambda label, after: space.bdd.let({passed: True}, after) if label == goal else after
        )
        return space.bdd.let({passed: False}, found)

    def _pre(self, states: Set, number: int, marking: Marking) -> Set:
        for var in self._memory:
            states = self.space.before_assigned(states, var, 0)
        self.image.visited = self.trails[number].visited
        for program in reversed(self.trails[number].programs):
            states = self.image.pre(states, program, marking)
        return states


def _due(component: Component, number: int, written: dict[int, int], ran: dict[int, int]) -> bool:
    last = ran.get(number)
    if last is None and component.always:
        return True
    return any(written.get(var, 0) > (last or 0) for var in component.reads)


@dataclass
class Reached:
    """The reachable states, those of them that some step ends in, and the marks that some step passes."""

    states: Set
    after: Set
    marks: frozenset[Label]


SIFT = 1000
"""The size, in nodes, at which the order of the variables is first sifted; then whenever it has doubled."""


def explore(stepper: Stepper) -> Reached:
    """Return the reachable states: the least set with the initial state that no event leaves.

    Events take turns, each from all states it has not been tried in yet (chaining: Roig, Cortadella, Pastor 1995).
    """
    space = stepper.space
    total, after = space.initial, space.none
    tried = [space.none] * len(stepper.loop.events)
    grown, large = True, SIFT
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
                if len(total) > large:
                    space.bdd.reorder()
                    large = 2 * max(large, len(total))
    met = frozenset(stepper.image.met)
    stepper.learn(total)
    if stepper.allowed != space.all:
        met = frozenset(label for label in met if _passed(stepper, total, label))
    return Reached(total, after, met)


def _passed(stepper: Stepper, states: Set, label: Label) -> bool:
    """Return whether an allowed step from `states` passes a mark."""
    none = stepper.space.none
    trails = enumerate(stepper.trails)
    return any(label in t.marked and states & stepper.pre(none, number, label) != none for number, t in trails)
