"""Everything that checks ask the decision-diagram engine for, computed once and when it is first asked."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property

from exover.model.event import Abort, AbortWaiting, Ask
from exover.model.model import Rule
from exover.model.property import NO_PROPERTIES, Properties
from exover.model.semantics import Reference
from exover.model.trace import Trace
from exover.ocrd.compile import Compiled
from exover.verify.bdd.equivalence import Equivalence
from exover.verify.bdd.image import Label
from exover.verify.bdd.meaning import Meaning
from exover.verify.bdd.space import Set, Space
from exover.verify.bdd.steps import Reached, Stepper, explore
from exover.verify.bdd.witness import Witnesses
from exover.verify.cells import TooLarge
from exover.verify.loop import ClosedLoop, LoopEvent
from exover.verify.temporal.engine import Temporal
from exover.verify.temporal.moments import moments

Progress = Callable[[str], None]


@dataclass
class Analysis:
    """One closed loop under examination."""

    compiled: Compiled
    reference: Reference
    progress: Progress
    properties: Properties = NO_PROPERTIES
    _loop: ClosedLoop | TooLarge | None = None

    @property
    def loop(self) -> ClosedLoop:
        """The closed loop of the decoded tables; raises `TooLarge` each time if it is more than can be followed."""
        if self._loop is None:
            try:
                self._loop = ClosedLoop(
                    self.compiled.model, self.compiled.tables, self.compiled.entries, self.properties
                )
            except TooLarge as reason:
                self._loop = reason
        if isinstance(self._loop, TooLarge):
            raise self._loop
        return self._loop

    @property
    def state_bits(self) -> int:
        """The number of bits of the loop's state; 0 if it is more than can be followed."""
        try:
            return self.space.bit_count
        except TooLarge:
            return 0

    @cached_property
    def stepper(self) -> Stepper:
        """Steps on sets, those alone that the assumptions allow."""
        stepper = Stepper(self.loop)
        for assumption in self.properties.assumptions:
            stepper.allowed &= moments(Meaning(stepper.space), assumption.formula)
        return stepper

    @property
    def space(self) -> Space:
        """Sets of states."""
        return self.stepper.space

    @cached_property
    def meaning(self) -> Meaning:
        """Conditions of the model as sets."""
        return Meaning(self.space)

    @cached_property
    def equivalence(self) -> Equivalence:
        """The comparison of tables with rules."""
        return Equivalence(self.space, self.meaning)

    @cached_property
    def different_steps(self) -> tuple[str, ...]:
        """What every step needs and the tables have otherwise than the rules: counters, rules, launches, latches."""
        found = [*self.equivalence.entries(), *self.equivalence.steps()]
        return tuple(what for what, states in found if states != self.space.none)

    @cached_property
    def reached(self) -> Reached:
        """The reachable states."""
        self.progress("reachable states")
        return explore(self.stepper)

    @cached_property
    def witnesses(self) -> Witnesses:
        """Concrete runs."""
        return Witnesses(self.stepper, self.reference)

    @cached_property
    def temporal(self) -> Temporal:
        """Questions about runs, among the reachable states."""
        reached, none = self.reached.states, self.space.none

        def meets(states: Set) -> bool:
            return bool(states & reached != none)

        return Temporal(self.stepper, self.meaning, self.reference, reached, meets, self.properties.fair)

    def run_to(self, states: Set) -> Trace:
        """Return a shortest run to one of these reachable states."""
        return self.witnesses.to(states)

    def run_into(self, states: Set) -> Trace:
        """Return a shortest run of one step or more into these states, which some reachable step ends in."""
        return self.witnesses.into(states)

    def run_to_launch(self, request: str) -> Trace:
        """Return a shortest run whose last step launches the request, which some reachable step does."""
        return self.witnesses.to_launch(request)

    def among(self, states: Set, known: Set) -> Set:
        """Return those of `known` that are in `states`."""
        return states & known

    def broken(self, rules: Iterable[Rule]) -> Set:
        """Return the states in which `violation` is raised for one of these rules: F with the stopping slots idle."""
        found = self.space.none
        for rule in rules:
            found |= self.meaning.rule(rule, calm=True)
        return found

    def possible(self, goal: Set, mark: Label | None, allowed: Callable[[LoopEvent], bool]) -> Set:
        """Return the reachable states from which allowed events can lead into `goal`, or past `mark`.

        The least fixpoint of EX over the allowed events, each in turn. An event that changes nothing on which the
        states found so far depend leads no other state among them.
        """
        reached, stepper = self.reached.states, self.stepper
        events = [number for number, event in enumerate(self.loop.events) if allowed(event)]
        found = goal
        for number in events:
            if mark in stepper.trails[number].marked:
                found |= reached & stepper.pre(self.space.none, number, mark)
        grown = True
        while grown and (reached & ~found) != self.space.none:
            grown = False
            for number in events:
                if stepper.trails[number].changed & self.space.support(found):
                    before = reached & stepper.pre(found, number) & ~found
                    if before != self.space.none:
                        found |= before
                        grown = True
        return found


def is_abort(event: LoopEvent) -> bool:
    """Return whether an event gives something up."""
    return isinstance(event.event, Abort | AbortWaiting)


def asks(event: LoopEvent, request: str) -> bool:
    """Return whether an event is an ask of this request."""
    return isinstance(event.event, Ask) and event.event.request == request
