"""Steps that a black box recorded, each with the answer of the reference interpreter."""

from exover.dataclass import dataclass
from exover.model.event import Event, Invalid
from exover.model.wire import Json


@dataclass(frozen=True, slots=True)
class BareAction:
    """An action without arguments and texts; answers of a box and of the reference are compared in this form."""

    verb: str
    request: str | None = None
    slot: int | None = None
    rule: str | None = None
    launch_rule: str | None = None


@dataclass(frozen=True, slots=True)
class Replayed:
    """A step: its number, its event as JSON and as it was read, the recorded answer and that of the reference.

    `recorded` is None if the step was not answered, `expected` if the reference has no answer; `fault` is the fault
    that the checker had detected by then, None if none.
    """

    number: int
    event: Json
    read: Event | Invalid
    recorded: tuple[BareAction, ...] | None
    expected: tuple[BareAction, ...] | None
    fault: str | None

    @property
    def agrees(self) -> bool:
        """Whether the step was answered, without a fault, and as the reference answers, if that is known."""
        return self.recorded is not None and self.fault is None and self.expected in (None, self.recorded)
