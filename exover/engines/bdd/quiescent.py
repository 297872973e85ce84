"""Quiescent steps: those whose event wakes no component, an under-approximation that needs no settling pass.

A step is quiescent iff every component is stable after its event. What quiescent steps can reach is reachable; that
answers most questions without the long cascades that an event may start.
"""

from exover.engines.bdd.functions import Function
from exover.engines.bdd.manager import Set
from exover.engines.bdd.space import Space
from exover.engines.bdd.steps import NARROW, StepFunction, Stepper
from exover.loop.finite.builder import ClosedLoop
from exover.model.property import Label
from exover.ocrd.memory import EMPTY


class QuiescentSteps:
    """Preimages of quiescent steps; the last step of a run need not be quiescent if it passes the mark first.

    `lone`: only steps between states in which nothing waits; sets then do not mention the waiting places.
    """

    def __init__(self, stepper: Stepper, lone: bool) -> None:
        self._stepper = stepper
        self._places = stepper.places if lone else frozenset()
        self._empty = {
            name: value for var in self._places for name, value in stepper.space.literals(var, EMPTY).items()
        }
        self._steps: dict[int, StepFunction] = {}
        self._found: dict[int, Set] = {}
        self._quiet: dict[int, list[Set]] = {}
        self._woken: dict[int, list[int]] = {}

    @property
    def loop(self) -> ClosedLoop:
        """The loop."""
        return self._stepper.loop

    @property
    def space(self) -> Space:
        """The space of its states."""
        return self._stepper.space

    def step(self, number: int) -> StepFunction:
        """Return the function of event `number`, the variables it may change, and the marks that it may pass."""
        if number not in self._steps:
            function = self._stepper.functions.of(self.loop.events[number].program, "event")
            marked = set(function.marks)
            for component in self._due(number):
                marked |= self._component(component).marks.keys()
            changed = frozenset(map(self.space.owner, function.bits))
            self._steps[number] = StepFunction(function, changed, frozenset(marked), ())
        return self._steps[number]

    def pre(self, states: Set, number: int, goal: Label | None = None, avoid: Label | None = None) -> Set:
        """Return states from which a quiescent step by event `number` leads into `states`, or one past the mark `goal`.

        Past the mark: in the event, or in the first component that does anything. `avoid` must be None.
        """
        assert avoid is None, "a quiescent step is not told by what it avoids"
        function, functions = self.step(number).function, self._stepper.functions
        after = self._stepper.forgotten(states) & self._empty_after(number)
        found = functions.after(after, function)
        for stable in self._stable(number):
            if found == self.space.none or len(found) > NARROW:
                found = self.space.none  # what is too wide to be looked at is left out
                break
            found &= stable
        if goal is not None:
            found |= function.marks.get(goal, self.space.none)
            found |= functions.after(self._first(number, goal) & self._empty_after(number), function)
        return self._lone(functions.chosen(found & function.enabled, function))

    def _stable(self, number: int) -> list[Set]:
        """Return sets whose intersection are the states from which event `number` leaves every component stable."""
        if number not in self._quiet:
            found, function = list[Set](), self.step(number).function
            for component in self._due(number):
                stable = ~self._stepper.functions.after(self._unstable(component), function)
                joined = found[-1] & stable if found else stable
                found[-1:] = [joined] if len(joined) <= NARROW else [*found[-1:], stable]
            self._quiet[number] = found
        return self._quiet[number]

    def _first(self, number: int, goal: Label) -> Set:
        """Return states after event `number` in which the first component that does anything passes a mark."""
        found, still = self.space.none, self.space.all
        for component in self._due(number):
            passed = self._component(component).marks.get(goal, self.space.none)
            found |= self._lone(passed) & still
            still &= ~self._unstable(component)
            if len(still) > NARROW:
                break
        return found

    def _empty_after(self, number: int) -> Set:
        """Return the states in which the waiting places that event `number` changes are empty; all unless `lone`."""
        changed = self.step(number).changed & self._places
        return self.space.conjunction(self.space.is_value(var, EMPTY) for var in changed)

    def _lone(self, states: Set) -> Set:
        """Return the states with the variables of waiting places replaced by 0, if `lone`; else the states."""
        return self.space.bdd.let(self._empty, states) if self._empty else states

    def _unstable(self, component: int) -> Set:
        """Return the states in which a component would do something."""
        if component not in self._found:
            self._found[component] = self._lone(self._stepper.waking.unstable[component])
        return self._found[component]

    def _due(self, number: int) -> list[int]:
        """Return the components that may do something after event `number`, in their order."""
        if number not in self._woken:
            due = self._stepper.waking.due(self.loop.events[number].program)
            self._woken[number] = sorted(each for each in due if self._unstable(each) != self.space.none)
        return self._woken[number]

    def _component(self, number: int) -> Function:
        return self._stepper.waking.component(number)
