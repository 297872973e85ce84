"""Wait-for analysis: every wait can come to an end, if what waits can leave while nothing is active.

Reports alone lead from every state to a home state (`home_states.py`), and take waiting requests away, never add any.
While nothing is active, an observation does only its own update, and then what waits is decided. There a request
leaves its place, by a launch or a rejection; or it falls from clearing to waiting, which ends as well unless it can
rise again. Suppose that from every home state in which r waits observations lead to where r does one of these, or
another does. As often as that happens fewer wait, or as many and fewer are clearing (r may rise again, but has to
leave from where it waits); after a launch reports lead to a home state again. So r leaves at last, without an abort and
without being asked for again.

So it is enough to follow r alone, through observations: others leave or fall for good, which is as good; and what can
fall and rise again must be nothing to r.
"""

from collections.abc import Iterator
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.bdd.functions import Function
from exover.engines.bdd.home_states import HomeStates
from exover.engines.bdd.space import Set
from exover.engines.bdd.steps import NARROW, Stepper
from exover.model.event import Observe
from exover.ocrd.memory import CLEARING, EMPTY


@dataclass
class WaitForAnalysis:
    """Which waits are seen to end, request by request."""

    stepper: Stepper
    home: HomeStates

    def end(self, request: int) -> bool:
        """Return whether it is seen that every wait of the request, one that can wait, can come to an end."""
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
        """Whether every wait is seen to be able to end: so from everywhere a home state in which nothing waits."""
        return all(self.end(request) for request, waits in enumerate(self.stepper.loop.may_wait) if waits)

    def _place(self, request: int) -> int:
        return self.stepper.loop.index["place", request]

    @cached_property
    def _observations(self) -> list[tuple[frozenset[int], Function]]:
        """What each observation does, with the variables that it may change."""
        programs = [each.program for each in self.stepper.loop.events if isinstance(each.event, Observe)]
        found = [self.stepper.functions.of(program, "event") for program in programs]
        return [(frozenset(map(self.stepper.space.owner, function.bits)), function) for function in found]

    def _observing(self, variables: set[int]) -> Iterator[Function]:
        return (function for changed, function in self._observations if changed & variables)

    @cached_property
    def _restored(self) -> bool:
        """Whether no rule has anything to restore while nothing is active."""
        rules = range(len(self.stepper.loop.tables.rules))
        return not any(self._possible(self.stepper.waking.unstable[rule]) for rule in rules)

    def _becomes(self, request: int, phase: int) -> Set:
        """Return the states in which what waits for the request is decided on, and its place comes to this phase."""
        space, place = self.stepper.space, self._place(request)
        settling = self.stepper.waking.component(self.stepper.loop.settling(request))
        return self.stepper.functions.pre(space.is_value(place, phase), settling) & ~space.is_value(place, phase)

    @cached_property
    def _rises(self) -> dict[int, Set]:
        """By request where it would come from waiting to clearing while nothing is active."""
        waiting = [request for request, waits in enumerate(self.stepper.loop.may_wait) if waits]
        return {request: self.home.among(self._becomes(request, CLEARING)) for request in waiting}

    @cached_property
    def _rising(self) -> set[int]:
        """The places in which something may do so."""
        return {self._place(request) for request, states in self._rises.items() if self._possible(states)}

    def _possible(self, states: Set) -> bool:
        """Return whether these states may come about in a step while nothing is active."""
        states = self.home.among(states)
        return bool(states & self.stepper.space.local_domain(states) != self.stepper.space.none)
