"""Transition systems of the temporal engine, preimages within a universe of states, and justice constraints."""

from collections.abc import Sequence
from typing import Protocol

from exover.dataclass import dataclass
from exover.engines.bdd.backward_reachability import BackwardReachability
from exover.engines.bdd.manager import Set
from exover.engines.bdd.space import Space
from exover.engines.bdd.steps import Stepper
from exover.model.event import Report
from exover.model.property import Label
from exover.ocrd.memory import IDLE


@dataclass(frozen=True)
class Constraint:
    """A justice condition: a fair run is infinitely often in `states`, or takes a step by one of `events`."""

    states: Set
    events: frozenset[int] = frozenset()


class TransitionSystem(Protocol):
    """Steps on sets of states; events are numbers."""

    @property
    def space(self) -> Space:
        """The sets."""

    @property
    def universe(self) -> Set:
        """States that no step leaves; the initial state is one of them."""

    @property
    def events(self) -> Sequence[int]:
        """The events."""

    def pre(self, states: Set, number: int) -> Set:
        """Return the states of the universe from which a step by this event leads into `states`."""

    def touching(self, states: Set) -> Sequence[int]:
        """Return the events by which a step may lead into `states` from outside, or out of them."""


@dataclass(frozen=True)
class LoopSteps:
    """The steps of the loop within the states of `backwards`, without those that pass the mark `avoid`."""

    backwards: BackwardReachability
    avoid: Label | None = None

    @property
    def space(self) -> Space:
        """The space of the loop."""
        return self.backwards.stepper.space

    @property
    def universe(self) -> Set:
        """The set of states."""
        return self.backwards.within

    @property
    def events(self) -> Sequence[int]:
        """The events of the loop."""
        return range(len(self.backwards.stepper.loop.events))

    def pre(self, states: Set, number: int) -> Set:
        """Return the states from which a step by this event leads into `states`."""
        return self.universe & self.backwards.stepper.pre(states, number, avoid=self.avoid)

    def touching(self, states: Set) -> Sequence[int]:
        """Return the events that change something on which `states` depend."""
        return self.backwards.touching(states)


def fair_reports(stepper: Stepper) -> list[Constraint]:
    """Return the constraint of each slot: infinitely often it is idle or reported."""
    loop = stepper.loop
    reports: dict[tuple[str, int], set[int]] = {}
    for number, each in enumerate(loop.events):
        if isinstance(each.event, Report):
            reports.setdefault((each.event.request, each.event.slot), set()).add(number)
    return [
        Constraint(
            stepper.space.is_value(loop.index["phase", row.slots + slot], IDLE),
            frozenset(reports[request.name, slot]),
        )
        for request, row in zip(loop.model.requests, loop.tables.requests, strict=True)
        for slot in range(row.instances)
    ]
