"""What the temporal engine asks of the loop: a set of states that no step leaves, and steps backwards in it."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

from exover.model.event import Report
from exover.ocrd.machine import IDLE
from exover.verify.bdd.functions import Label
from exover.verify.bdd.space import Set, Space
from exover.verify.bdd.steps import Stepper


@dataclass(frozen=True)
class Constraint:
    """What a fair run does again and again: it is in one of `states`, or takes a step by one of `events`."""

    states: Set
    events: frozenset[int] = frozenset()


class Steps(Protocol):
    """Steps on sets of states; events are numbers."""

    @property
    def space(self) -> Space:
        """The sets."""

    @property
    def universe(self) -> Set:
        """States that no step leaves; the initial state is one of them."""

    @property
    def events(self) -> Iterable[int]:
        """The events."""

    def pre(self, states: Set, number: int) -> Set:
        """Return the states of the universe from which a step by this event leads into `states`."""

    def touches(self, states: Set, number: int) -> bool:
        """Return whether a step by this event may lead into `states` from outside of them."""


@dataclass(frozen=True)
class LoopSteps:
    """The steps of the loop among `universe`; those that pass the mark `avoid` are left out."""

    stepper: Stepper
    universe: Set
    avoid: Label | None = None

    @property
    def space(self) -> Space:
        """The space of the loop."""
        return self.stepper.space

    @property
    def events(self) -> Iterable[int]:
        """The events of the loop."""
        return range(len(self.stepper.loop.events))

    def pre(self, states: Set, number: int) -> Set:
        """Return the states from which a step by this event leads into `states`."""
        return self.universe & self.stepper.pre(states, number, avoid=self.avoid)

    def touches(self, states: Set, number: int) -> bool:
        """Return whether the event changes anything on which `states` depend."""
        return not self.stepper.step(number).changed.isdisjoint(self.space.support(states))


def fair_reports(stepper: Stepper) -> list[Constraint]:
    """Return the constraints that every slot is, again and again, idle or being reported."""
    loop, space = stepper.loop, stepper.space
    found = []
    for request, row in zip(loop.model.requests, loop.tables.requests, strict=True):
        for slot in range(row.instances):
            numbers = [number for number, each in enumerate(loop.events) if _reports(each.event, request.name, slot)]
            idle = space.is_value(loop.index["phase", row.slots + slot], IDLE)
            found.append(Constraint(idle, frozenset(numbers)))
    return found


def _reports(event: object, request: str, slot: int) -> bool:
    return isinstance(event, Report) and (event.request, event.slot) == (request, slot)
