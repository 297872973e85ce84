"""Whole steps on sets of states: an event's update, then passes of steps 3 to 5 until no state changes any more."""

from dataclasses import dataclass
from functools import cached_property

from exover.verify.bdd.image import Image, Label
from exover.verify.bdd.space import Set, Space
from exover.verify.bdd.stable import Waking
from exover.verify.loop import ClosedLoop
from exover.verify.program import Program, marks, writes
from exover.verify.states import MEMORY


@dataclass(frozen=True)
class Trail:
    """What steps of one event do: the update, and the components that may change something, in turn.

    `changed` and `marked`: the variables that they may change, the marks that they may pass.
    """

    programs: tuple[Program, ...]
    changed: frozenset[int]
    marked: frozenset[Label]


class Stepper:
    """Images and preimages of steps, of those runs that are assumed."""

    def __init__(self, loop: ClosedLoop) -> None:
        self.loop = loop
        self.space = Space(loop)
        self.image = Image(self.space)
        self.assumed: Set = self.space.all
        """Steps end in these states only."""
        self._waking = Waking(self.image)
        self._memory = [n for n, v in enumerate(loop.variables) if v.key[0] in MEMORY]
        self._trails: dict[int, Trail] = {}
        self._writes: dict[int, frozenset[int]] = {}
        self._marks: dict[int, frozenset[Label]] = {}

    @cached_property
    def stable(self) -> list[Set]:
        """What holds in every state between steps: for each component that the states in which it does nothing."""
        waking = self._waking
        return [states for number, states in enumerate(waking.stable) if number not in waking.always]

    @property
    def launching(self) -> list[Set]:
        """By launch rule the states in which it would do something."""
        first = len(self.loop.tables.rules)
        stable = self._waking.stable[first : first + len(self.loop.tables.launches)]
        return [self.space.before_assigned(~states, self.loop.index["tried", n], 0) for n, states in enumerate(stable)]

    def universe(self, limit: int | None = None) -> Set | None:
        """Return states that no step leaves, the initial one among them; None if that has more than `limit` nodes.

        Each variable has one of its values, each component is stable.
        """
        states = self.space.domain
        for stable in self.stable:
            states &= stable
            if limit is not None and len(states) > limit:
                return None
        return states

    def post(self, states: Set, number: int) -> Set:
        """Return the states after a step that event `number` begins, from `states`."""
        return self._run(states, number, []) & self.assumed

    def _run(self, states: Set, number: int, trail: list[Program]) -> Set:
        program = self.loop.events[number].program
        trail.append(program)
        states = self.image.post(states, program)
        if states != self.space.none:
            states = self._passes(states, self._waking.due(program), trail)
            for var in self._memory:
                states = self.space.assigned(states, var, 0)
        return states

    def _passes(self, states: Set, due: set[int], trail: list[Program]) -> Set:
        """Run passes until none changes a state, and note the components that did."""
        while due:
            for number, component in enumerate(self.loop.body):
                if number in due:
                    due.remove(number)
                    self.image.moved = False
                    states = self.image.post(states, component.program)
                    if self.image.moved:
                        trail.append(component.program)
                        due |= self._waking.wakes(number)
        return states

    def trail(self, number: int) -> Trail:
        """Return what event `number` does, from all states of the universe."""
        found = self._trails.get(number)
        if found is None:
            programs = self._waking.trail(self.loop.events[number].program)
            if programs is None:
                taken: list[Program] = []
                self._run(self.universe(), number, taken)
                programs = tuple(taken)
            changed = frozenset().union(*(self._written(program) for program in programs))
            passed = frozenset().union(*(self._marked(program) for program in programs))
            found = self._trails[number] = Trail(programs, changed, passed)
        return found

    def pre(self, states: Set, number: int, goal: Label | None = None) -> Set:
        """Return the states from which a step that event `number` begins leads into `states`, or past the mark `goal`.

        Exact on the universe; what it says of other states means nothing.
        """
        trail = self.trail(number)
        before = self._before(states & self.assumed, trail, goal)
        if goal is not None and self.assumed != self.space.all:
            before &= self._before(self.assumed, trail, None)
        return before

    def _before(self, states: Set, trail: Trail, goal: Label | None) -> Set:
        """Follow the programs backwards, but for those that neither change what `states` depend on nor pass `goal`."""
        support = self.space.support(states)
        for var in self._memory:
            if var in support:
                states = self.space.before_assigned(states, var, 0)
        for number, program in reversed(list(enumerate(trail.programs))):
            if (
                number
                and goal not in self._marked(program)
                and not (self._written(program) & self.space.support(states))
            ):
                continue
            states = self.image.pre(states, program, goal)
        return states

    def _written(self, program: Program) -> frozenset[int]:
        found = self._writes.get(id(program))
        if found is None:
            found = self._writes[id(program)] = frozenset(writes(program))
        return found

    def _marked(self, program: Program) -> frozenset[Label]:
        found = self._marks.get(id(program))
        if found is None:
            found = self._marks[id(program)] = frozenset(marks(program))
        return found


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
    return Reached(total, after, frozenset(stepper.image.met))
