"""Wait-for analysis: every wait can come to an end if waiting requests can leave while nothing is active.

Reports alone lead from every state to a home state (`home_states.py`); they never add waiting requests. While nothing
is active, an observation does its own update, and then waiting requests are decided. A request then leaves its place by
a launch or a rejection, or it falls from clearing to waiting. Suppose that from every home state in which r waits,
observations lead to a state in which r, or another request, leaves or falls. Each time, either fewer requests wait, or
as many wait and fewer are clearing (r may rise from waiting to clearing again, but then it must leave from waiting);
after a launch, reports lead to a home state again. So r finally leaves, without an abort and without a further ask.

So it suffices to follow r alone through observations: if another request leaves or falls for good, the measure shrinks
as well; and what r depends on must not be a place that can fall and rise again.
"""

from collections.abc import Iterator
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.bdd.functions import Function
from exover.engines.bdd.home_states import HomeStates
from exover.engines.bdd.manager import Set
from exover.engines.bdd.steps import NARROW, Stepper
from exover.model.event import Observe
from exover.ocrd.memory import CLEARING, EMPTY


@dataclass
class WaitForAnalysis:
    """Proves, request by request, that waits can end."""

    stepper: Stepper
    home: HomeStates

    def end(self, request: int) -> bool:
        """Return True only if every wait of the request (one that may wait) can come to an end."""
        space, functions = self.stepper.space, self.stepper.functions
        if not self._restored:
            return False
        place, settling = self._place(request), self.stepper.loop.settling(request)
        acts = self.home.among(self.stepper.waking.unstable[settling])
        ends = acts & ~self._rises[request]
        found, before = space.none, None
        while found != before and len(found) <= NARROW:
            before, goal = found, ((found & ~acts) | ends) & self.home.disabling
            if (self._rising - {place}) & space.support(goal):
                return False
            for function in self._observing(space.support(goal)):
                found |= self.home.among(functions.pre(goal, function))
        return self.home.lacks(~space.is_value(place, EMPTY) & ~found)

    @cached_property
    def all_end(self) -> bool:
        """Whether `end` is true of all requests: then a home state in which nothing waits is always reachable."""
        return all(self.end(request) for request, waits in enumerate(self.stepper.loop.may_wait) if waits)

    def _place(self, request: int) -> int:
        return self.stepper.loop.index["place", request]

    @cached_property
    def _observations(self) -> list[tuple[frozenset[int], Function]]:
        """The function of each observation, with the variables that it may change."""
        programs = [each.program for each in self.stepper.loop.events if isinstance(each.event, Observe)]
        found = [self.stepper.functions.of(program, "event") for program in programs]
        return [(frozenset(map(self.stepper.space.owner, function.bits)), function) for function in found]

    def _observing(self, variables: set[int]) -> Iterator[Function]:
        return (function for changed, function in self._observations if changed & variables)

    @cached_property
    def _restored(self) -> bool:
        """Whether no rule can have anything to restore while nothing is active."""
        rules = range(len(self.stepper.loop.tables.rules))
        return not any(self._possible(self.stepper.waking.unstable[rule]) for rule in rules)

    def _becomes(self, request: int, phase: int) -> Set:
        """Return the states in which settling the request changes its place to this phase."""
        space, place = self.stepper.space, self._place(request)
        settling = self.stepper.waking.component(self.stepper.loop.settling(request))
        return self.stepper.functions.pre(space.is_value(place, phase), settling) & ~space.is_value(place, phase)

    @cached_property
    def _rises(self) -> dict[int, Set]:
        """Maps a request to the states in which it would rise from waiting to clearing while nothing is active."""
        waiting = [request for request, waits in enumerate(self.stepper.loop.may_wait) if waits]
        return {request: self.home.among(self._becomes(request, CLEARING)) for request in waiting}

    @cached_property
    def _rising(self) -> set[int]:
        """The place variables of the requests that may rise."""
        return {self._place(request) for request, states in self._rises.items() if self._possible(states)}

    def _possible(self, states: Set) -> bool:
        """Return False only if none of these states occurs within a step while nothing is active."""
        states = self.home.among(states)
        return bool(states & self.stepper.space.local_domain(states) != self.stepper.space.none)
