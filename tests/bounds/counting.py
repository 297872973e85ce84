"""What events take of the tables, and the bounds that are emitted for them."""

from collections.abc import Iterable
from dataclasses import dataclass

from exover.bounds.events import Bound, EventBounds
from exover.model.event import Abort, AbortWaiting, Ask, Event, Observe, Report
from exover.model.model import Model
from exover.ocrd.machine import Machine
from exover.ocrd.tables import NONE, Node
from exover.pipeline import Build
from tests.support.events import Stream


def bound_of(model: Model, most: EventBounds, event: Event) -> Bound:
    """Return the bound of an event."""
    request = [request.name for request in model.requests]
    variable = [variable.name for variable in model.variables]
    stock = [resource.name for resource in model.resources if resource.consumable]
    match event:
        case Ask(name):
            return most.asks[request.index(name)]
        case Report(name):
            return most.reports[request.index(name)]
        case Abort(name):
            return most.aborts[request.index(name)]
        case AbortWaiting(name):
            return most.withdrawals[request.index(name)]
        case Observe(name):
            return most.levels[stock.index(name)] if name in stock else most.readings[variable.index(name)]


@dataclass
class Counting(Machine):
    """The machine that counts the tests and the passes of an event."""

    tests: int = 0
    passes: int = 0

    def walk(self, node: int) -> list[Node]:
        at = node
        while at != NONE:
            here = self.tables.nodes[at]
            self.tests += here.code >= 0
            at = here.low if here.code < 0 or self.vector[here.code] <= here.bound else here.high
        return super().walk(node)

    def _settle(self) -> None:
        self.passes += 1
        super()._settle()


def most_of(found: Build, known: EventBounds, events: Iterable[Event]) -> Bound:
    """Return what the events take at most; each keeps its bound."""
    machine, most = Counting(found.model, found.tables), Bound(0, 0, 0)
    for event in events:
        machine.tests = machine.passes = 0
        answers = len(machine.step(event))
        bound = bound_of(found.model, known, event)
        assert machine.tests <= bound.tests and answers <= bound.answers, event
        assert machine.passes <= max(bound.passes, 1), event
        most = Bound(max(most.tests, machine.tests), max(most.answers, answers), max(most.passes, machine.passes))
    return most


def copied(machine: Counting) -> dict[str, object]:
    """Return what a machine holds, to be given back to it."""
    return {name: value.copy() if isinstance(value, list | dict) else value for name, value in vars(machine).items()}


def random_events(model: Model, seed: int, length: int) -> list[Event]:
    return [event for event, _ in Stream(model, seed).events(length)]
