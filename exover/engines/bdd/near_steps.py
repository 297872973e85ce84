"""Steps of the loop near some variables, while every slot and waiting place that these are not about is idle and empty.

They are steps of the loop. Their sets do not say that all else is idle: they stay on few variables, however many there
are.
"""

from collections.abc import Sequence
from dataclasses import field, replace
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.bdd.backward_reachability import BackwardReachability
from exover.engines.bdd.functions import Function
from exover.engines.bdd.space import Set, Space
from exover.engines.bdd.steps import Stepper
from exover.model.property import Label

BUSY = "phase", "place"
"""Kinds of variables that are 0 while a slot is idle or a place empty."""


@dataclass(frozen=True)
class NearSteps:
    """Those steps that change one of the variables, and stay where all else is idle; none passes the mark `avoid`."""

    stepper: Stepper
    backwards: BackwardReachability
    variables: frozenset[int]
    avoid: Label | None = None
    _steps: dict[int, Function] = field(default_factory=dict)

    def avoiding(self, mark: Label) -> "NearSteps":
        """Return the steps that do not pass a mark."""
        return replace(self, avoid=mark)

    @property
    def space(self) -> Space:
        """The space of the loop."""
        return self.stepper.space

    @cached_property
    def _resting(self) -> dict[str, bool]:
        """The bits that are 0, by name."""
        kinds = enumerate(self.space.loop.variables)
        others = [n for n, variable in kinds if variable.key[0] in BUSY and n not in self.variables]
        return {name: False for n in others for name in self.space.bits[n]}

    def among(self, states: Set) -> Set:
        """Return the states in which all else is idle, of those; the set does not say so."""
        return self.space.bdd.let(self._resting, states)

    @cached_property
    def universe(self) -> Set:
        """The set of states."""
        return self.among(self.backwards.within)

    @cached_property
    def events(self) -> Sequence[int]:
        """The events that change one of the variables, and can leave all else idle."""
        numbers = self.backwards.changing(self.variables)
        return [number for number in numbers if self._step(number).enabled != self.space.none]

    def touching(self, states: Set) -> Sequence[int]:
        """Return the events that change something on which `states` depend."""
        return sorted(set(self.events).intersection(self.backwards.touching(states)))

    def pre(self, states: Set, number: int) -> Set:
        """Return the states from which a step by this event leads into `states`."""
        function, functions = self._step(number), self.stepper.functions
        found = functions.after(states & self._allowed, function)
        if self.avoid is not None:
            marks = self.stepper.step(number).function.marks
            found &= ~self.among(marks.get(self.avoid, self.space.none))
        return self.universe & functions.chosen(found & function.enabled, function)

    @cached_property
    def _allowed(self) -> Set:
        return self.among(self.stepper.allowed)

    def _step(self, number: int) -> Function:
        """Return what an event does while all else is idle; enabled where it stays so."""
        if number not in self._steps:
            whole = self.stepper.step(number).function
            enabled = self.among(whole.enabled)
            for name in whole.bits.keys() & self._resting.keys():
                enabled &= ~self.among(whole.bits[name])
            bits = {name: self.among(value) for name, value in whole.bits.items() if name not in self._resting}
            self._steps[number] = Function(enabled, bits, {}, whole.inputs)
        return self._steps[number]
