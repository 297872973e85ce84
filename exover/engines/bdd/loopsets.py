"""The space of one loop with its steps and conditions, each made when it is first needed."""

from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.bdd.manager import Set
from exover.engines.bdd.space import Space
from exover.engines.bdd.steps import Stepper
from exover.loop.finite.builder import ClosedLoop
from exover.loop.finite.predicates import StatePredicates
from exover.loop.finite.step_predicates import moments
from exover.model.property import Properties


@dataclass(frozen=True)
class LoopSets:
    """Sets of states of one loop: space, steps, conditions."""

    loop: ClosedLoop
    properties: Properties

    @cached_property
    def stepper(self) -> Stepper:
        """Images and preimages of the steps that the assumptions allow."""
        stepper = Stepper(self.loop)
        for assumption in self.properties.assumptions:
            stepper.allowed &= moments(StatePredicates(stepper.space), assumption.formula)
        return stepper

    @property
    def space(self) -> Space:
        """Sets of states."""
        return self.stepper.space

    @cached_property
    def meaning(self) -> StatePredicates[Set]:
        """Conditions of the model as sets."""
        return StatePredicates(self.space)
