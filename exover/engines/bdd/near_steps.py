"""Steps of the loop that change given variables, while all other slots are idle and all other waiting places empty.

They are an under-approximation of the steps. Their sets do not mention the other slots and places, so they depend on
few variables, whatever the size of the loop.
"""

from collections.abc import Sequence
from dataclasses import field, replace
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.bdd.backward_reachability import BackwardReachability
from exover.engines.bdd.functions import Function
from exover.engines.bdd.manager import Set
from exover.engines.bdd.space import Space
from exover.engines.bdd.steps import Stepper
from exover.model.property import Label

BUSY = "phase", "place"
"""Kinds of variables that are 0 while a slot is idle or a place empty."""


@dataclass(frozen=True)
class NearSteps:
    """The steps that change one of the variables and leave all else idle; none passes the mark `avoid`."""

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
    def _idle_bits(self) -> dict[str, bool]:
        """The bits of the other slots and places, by name, all 0."""
        kinds = enumerate(self.space.loop.variables)
        others = [n for n, variable in kinds if variable.key[0] in BUSY and n not in self.variables]
        return {name: False for n in others for name in self.space.bits[n]}

    def among(self, states: Set) -> Set:
        """Return the states restricted to those in which all else is idle, without the bits that say so."""
        return self.space.bdd.let(self._idle_bits, states)

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
        """Return the function of an event while all else is idle; enabled where it stays idle."""
        if number not in self._steps:
            whole = self.stepper.step(number).function
            enabled = self.among(whole.enabled)
            for name in whole.bits.keys() & self._idle_bits.keys():
                enabled &= ~self.among(whole.bits[name])
            bits = {name: self.among(value) for name, value in whole.bits.items() if name not in self._idle_bits}
            self._steps[number] = Function(enabled, bits, {}, whole.inputs)
        return self._steps[number]
