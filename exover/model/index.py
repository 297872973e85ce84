"""Numbers of the requests, readings, consumables and slots of a model, as tables, runtimes and engines use them."""

from functools import cached_property

from exover.dataclass import dataclass
from exover.model.model import Model, Resource, Variable
from exover.model.types import Bool, Type


@dataclass(frozen=True)
class ModelIndex:
    """The numberings of one model, each in the order of the text."""

    model: Model

    @cached_property
    def requests(self) -> tuple[str, ...]:
        """The names of the requests by number."""
        return tuple(request.name for request in self.model.requests)

    @cached_property
    def typed_readings(self) -> tuple[tuple[str, Type], ...]:
        """The names and types of the readings by number: posters and states, then the latches."""
        variables = ((variable.name, variable.type) for variable in self.model.variables)
        return (*variables, *((latch.name, Bool()) for latch in self.model.latches))

    @cached_property
    def readings(self) -> tuple[str, ...]:
        """The names of the readings by number."""
        return tuple(name for name, _ in self.typed_readings)

    @cached_property
    def posters(self) -> tuple[tuple[int, Variable], ...]:
        """The posters with their numbers among the readings."""
        return tuple((number, each) for number, each in enumerate(self.model.variables) if each.kind == "poster")

    @cached_property
    def consumables(self) -> tuple[Resource, ...]:
        """The consumable resources by number."""
        return tuple(resource for resource in self.model.resources if resource.consumable)

    @cached_property
    def stocks(self) -> tuple[str, ...]:
        """The names of the consumable resources by number."""
        return tuple(resource.name for resource in self.consumables)

    @cached_property
    def slots(self) -> tuple[tuple[str, int], ...]:
        """The slots by number, each as the name of its request and its index there."""
        return tuple((request.name, slot) for request in self.model.requests for slot in range(request.instances))

    @cached_property
    def request(self) -> dict[str, int]:
        """The numbers of the requests by name."""
        return _numbers(self.requests)

    @cached_property
    def reading(self) -> dict[str, int]:
        """The numbers of the readings (posters, states and latches) by name."""
        return _numbers(self.readings)

    @cached_property
    def stock(self) -> dict[str, int]:
        """The numbers of the consumable resources by name."""
        return _numbers(self.stocks)


def _numbers(names: tuple[str, ...]) -> dict[str, int]:
    return {name: number for number, name in enumerate(names)}
