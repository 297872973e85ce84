"""Steps that a black box recorded, beside what the reference interpreter answers."""

from exover.dataclass import dataclass
from exover.model.event import Event, Invalid
from exover.model.wire import Json


@dataclass(frozen=True, slots=True)
class BareAction:
    """An answer without arguments, by which that of a box and that of the reference are compared."""

    verb: str
    request: str | None = None
    slot: int | None = None
    rule: str | None = None
    launch_rule: str | None = None


@dataclass(frozen=True, slots=True)
class Replayed:
    """A step: its number, its event as JSON and as it was read, what the box says, and what the reference answers.

    `recorded` is None if the step was not answered, `expected` if the reference cannot be asked; `fault` is what the
    checker had found by then.
    """

    number: int
    event: Json
    read: Event | Invalid
    recorded: tuple[BareAction, ...] | None
    expected: tuple[BareAction, ...] | None
    fault: str | None

    @property
    def agrees(self) -> bool:
        """Whether the step was answered, without a fault, and not otherwise than the reference does."""
        return self.recorded is not None and self.fault is None and self.expected in (None, self.recorded)
