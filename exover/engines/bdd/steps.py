"""Whole steps on sets of states: an event's update, then passes of steps 3 to 5 until no state changes any more."""

from collections.abc import Sequence
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.bdd.functions import Function, Functions
from exover.engines.bdd.image import PASS, Image
from exover.engines.bdd.manager import Set
from exover.engines.bdd.space import Space
from exover.engines.bdd.wakeups import Wakeups
from exover.loop.finite.builder import ClosedLoop
from exover.loop.finite.variables import MEMORY, PLACES
from exover.model.property import Label


@dataclass(frozen=True)
class StepFunction:
    """A step that an event begins, as a function; the variables that it may change, the marks that it may pass."""

    function: Function
    changed: frozenset[int]
    marked: frozenset[Label]
    ran: tuple[int, ...]
    """The components that it runs, in order."""


WIDE = 20_000
"""Node limit of sets that are given up if they grow larger."""
MOST_BITS = 200
"""The number of bits of a state up to which the invariant of the states between steps is built as one set."""
NARROW = 1000
"""Node limit of sets that are intersected with invariants to see whether they are empty."""
NEAR = 2
"""The rounds of `narrowed`, each of which may add the variables of further invariants."""


class Stepper:
    """Images and preimages of the steps that the assumptions allow."""

    def __init__(self, loop: ClosedLoop) -> None:
        self.loop = loop
        self.space = Space(loop)
        self.image = Image(self.space)
        self.allowed: Set = self.space.all
        """The states in which steps may end: those that satisfy the assumptions."""
        self.functions = Functions(self.space)
        self.waking = Wakeups(self.functions)
        self.places = frozenset(n for n, v in enumerate(loop.variables) if v.key[0] in PLACES)
        """The variables of waiting places, which are 0 if nothing waits."""
        self._memory = [n for n, v in enumerate(loop.variables) if v.key[0] in MEMORY]
        self._steps: dict[int, StepFunction] = {}

    # ---- states between steps ----

    @cached_property
    def stable(self) -> list[Set]:
        """Invariants of the states between steps: for each component that is not `always` due, where it is stable."""
        waking = self.waking
        return [~states for number, states in enumerate(waking.unstable) if number not in waking.always]

    @cached_property
    def universe(self) -> Set:
        """An inductive invariant: each variable has one of its values, and each component is stable.

        All states, if that set has more than `WIDE` nodes, or if a state has more than `MOST_BITS` bits.
        """
        if self.space.loop.bit_count > MOST_BITS:
            return self.space.all
        states = self.space.domain
        for stable in self.stable:
            states &= stable
            if len(states) > WIDE:
                return self.space.all
        return states

    @cached_property
    def _parts(self) -> dict[int, list[tuple[Set, frozenset[int]]]]:
        """Maps a variable to the invariants that depend on it, each with all its variables."""
        found: dict[int, list[tuple[Set, frozenset[int]]]] = {}
        for part in self.stable:
            support = frozenset(self.space.support(part))
            for var in support:
                found.setdefault(var, []).append((part, support))
        return found

    def excluded(self, states: Set) -> bool:
        """Return True only if no state between steps is in the set."""
        return bool(self.narrowed(states) == self.space.none)

    def narrowed(self, states: Set) -> Set:
        """Return a subset of the states that contains all those between steps: intersected with invariants nearby."""
        space = self.space
        if self.universe != space.all:
            return states & self.universe
        looked_at: set[int] = set()
        for _ in range(NEAR):
            known = space.support(states)
            fresh, looked_at = known - looked_at, known | looked_at
            for var in sorted(fresh):
                states &= space.constraints[var]
            near = {id(part): (part, support) for var in sorted(fresh) for part, support in self._parts.get(var, ())}
            for part, _ in sorted(near.values(), key=lambda item: len(item[1] - known)):
                states &= part
                if states == space.none or len(states) > NARROW:
                    return states
        return states

    def launching(self) -> list[Set]:
        """Return for each launch rule the states in which it would do something."""
        space, first = self.space, len(self.loop.tables.rules)
        unstable = self.waking.unstable[first : first + len(self.loop.tables.launches)]
        return [space.before_cleared(part, self.loop.index["tried", n]) for n, part in enumerate(unstable)]

    @cached_property
    def spontaneous(self) -> Set:
        """The states between steps in which some component is unstable before an event has written anything."""
        found = self.space.disjunction(self.waking.unstable[number] for number in sorted(self.waking.always))
        for var in self._memory:
            found = self.space.before_cleared(found, var)
        return found

    # ---- forwards ----

    def post(self, states: Set, number: int) -> Set:
        """Return the states after a step that event `number` begins, from `states`."""
        program = self.loop.events[number].program
        states = self.image.post(states, program)
        if states != self.space.none:
            states = self._passes(states, self.waking.due(program))
            for var in self._memory:
                states = self.space.assigned(states, var, 0)
        return states & self.allowed

    def _passes(self, states: Set, due: set[int]) -> Set:
        """Return the states after as many passes as it takes until none changes a state."""
        while due:
            self.image.note(PASS, states)
            for number, component in enumerate(self.loop.body):
                if number in due:
                    due.remove(number)
                    self.image.moved = False
                    states = self.image.post(states, component.program)
                    if self.image.moved:
                        due |= self.waking.wakes(number)
        return states

    # ---- backwards ----

    def step(self, number: int) -> StepFunction:
        """Return what a step that event `number` begins does, in every state between steps.

        A component is composed into the step if it may be unstable when its turn comes; else only its marks are added.
        """
        found = self._steps.get(number)
        if found is None:
            program = self.loop.events[number].program
            function = self.functions.of(program, "event")
            due, ran = self.waking.due(program), list[int]()
            while due:
                for component in range(len(self.loop.body)):
                    if component in due:
                        due.remove(component)
                        unstable = self.functions.pre(self.waking.unstable[component], function)
                        if self.excluded(unstable):
                            function = self.functions.past(function, self.waking.component(component))
                        else:
                            function = self.functions.then(function, self.waking.component(component))
                            due |= self.waking.wakes(component)
                            ran.append(component)
            found = self._steps[number] = self._ended(function, tuple(ran))
        return found

    def forgotten(self, states: Set) -> Set:
        """Return the states at the end of the last pass that are in `states` once the step's memory is cleared."""
        remembered = self.space.support(states).intersection(self._memory)
        literals = {name: False for var in remembered for name in self.space.bits[var]}
        return self.space.bdd.let(literals, states) if literals else states

    def _ended(self, function: Function, ran: tuple[int, ...]) -> StepFunction:
        """Return the step function after its last program: memory cleared, bits that never change left out."""
        space = self.space
        forgotten = {name: space.none for var in self._memory for name in space.bits[var]}
        care = self.universe & function.enabled
        bits = {}
        for name, value in function.bits.items():
            if care & space.bdd.apply("^", value, space.bdd.var(name)) != space.none:
                bits[name] = forgotten.get(name, space.simplified(value, care))
        function = Function(function.enabled, bits, function.marks, function.inputs)
        chosen = {label: self.functions.chosen(states, function) for label, states in function.marks.items()}
        marked = frozenset(label for label, states in chosen.items() if states & self.universe != space.none)
        return StepFunction(function, frozenset(space.owner(name) for name in bits), marked, ran)

    def pre(self, states: Set, number: int, goal: Label | None = None, avoid: Label | None = None) -> Set:
        """Return the states from which a step that event `number` begins leads into `states`, or past the mark `goal`.

        A step that passes the mark `avoid` does not count. Exact on states between steps, meaningless on others.
        """
        function, none = self.step(number).function, self.space.none
        found = self.functions.after(states & self.allowed, function)
        if goal is not None and goal in function.marks:
            found |= function.marks[goal] & self.functions.after(self.allowed, function)
        if avoid is not None:
            found &= ~function.marks.get(avoid, none)
        return self.functions.chosen(found & function.enabled, function)


def explore(stepper: Stepper, events: Sequence[int] | None = None) -> Set:
    """Return the reachable states: the least set with the initial state that no event leaves, or none of `events`.

    Events take turns, each from all states it has not been tried in yet (chaining: Roig, Cortadella, Pastor 1995).
    """
    space, total = stepper.space, stepper.space.initial
    tried: dict[int, Set] = dict.fromkeys(range(len(stepper.loop.events)) if events is None else events, space.none)
    grown = True
    while grown:
        grown = False
        for number in tried:
            fresh = total & ~tried[number]
            if fresh != space.none:
                grown = True
                tried[number] = total
                total |= stepper.post(fresh, number)
                space.sifted(total)
    return total
