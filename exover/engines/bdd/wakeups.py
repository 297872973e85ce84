"""Wakeups: the components of a pass that an event, or another component, can make unstable.

Between steps every component is stable: it would do nothing. A component has to run in a step only if a write can make
it unstable or let it pass a mark, which depends only on the few variables that it reads. So a step is a short sequence
of programs, the same from every state, and preimages are taken on sets that stay small.
"""

from collections.abc import Iterator

from exover.engines.bdd.functions import Function, Functions
from exover.engines.bdd.manager import Set
from exover.loop.finite.program import Program


class Wakeups:
    """Computes which components of a pass an event or another component can wake.

    Between the programs of a step every variable has one of its values, so only such states count.
    """

    def __init__(self, functions: Functions) -> None:
        space = functions.space
        self._space, self._functions, self._body = space, functions, space.loop.body
        self.unstable = [functions.changing(self.component(number)) for number in range(len(self._body))]
        """For each component the states in which it would do something."""
        self.always = frozenset(
            number
            for number, component in enumerate(self._body)
            if component.always or self.unstable[number] & space.initial != space.none
        )
        """Spontaneous components: they may be unstable before anything is written in a step."""
        self._reading: dict[int, list[tuple[int, Set]]] = {}
        for number in range(len(self._body)):
            for states in self._calls(number):
                for var in space.support(states):
                    self._reading.setdefault(var, []).append((number, states))
        self._next: dict[int, frozenset[int]] = {}

    def component(self, number: int) -> Function:
        """Return the function of a component."""
        return self._functions.of(self._body[number].program, f"component{number}")

    def _calls(self, number: int) -> Iterator[Set]:
        """Yield the sets of states in which a component has to run: it is unstable, or only passes a mark."""
        unstable = self.unstable[number]
        yield unstable
        for marked in self.component(number).marks.values():
            yield marked & ~unstable

    def due(self, event: Program) -> set[int]:
        """Return the components that may have to run after an event's program."""
        return set(self.always | self._woken(self._functions.of(event, "event"), self._space.all))

    def wakes(self, number: int) -> frozenset[int]:
        """Return the components that a component may wake; itself only if it may be unstable again after it has run."""
        if number not in self._next:
            function, unstable = self.component(number), self.unstable[number]
            again = unstable & self._functions.pre(unstable, function)
            itself = {number} if again & self._space.local_domain(again) != self._space.none else set()
            woken = self._woken(function, unstable)
            self._next[number] = (woken - {number}) | itself
        return self._next[number]

    @property
    def pairs(self) -> int:
        """The number of pairs of components such that the first may wake the second."""
        return sum(len(self.wakes(number)) for number in range(len(self._body)))

    def _woken(self, function: Function, first: Set) -> frozenset[int]:
        """Return the components that have to run after the function but did not in some state of `first` before it."""
        space, found = self._space, set[int]()
        changed = {space.owner(name) for name in function.bits}
        for number, calling in dict.fromkeys(each for var in sorted(changed) for each in self._reading.get(var, ())):
            if number not in found:
                states = first & ~calling & self._functions.pre(calling, function)
                if states != space.none and states & space.local_domain(states) != space.none:
                    found.add(number)
        return frozenset(found)
