"""What the gate knows of slots, waiting places and modules; frozen values."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

from exover.dataclass import dataclass
from exover.gate.outer import CallId
from exover.model.event import Args, Observe
from exover.model.state import SlotId

STARTING = "the modules have not said yet what runs"
ASTRAY = "something runs that nobody has asked for here"
AWAY = "its module is not there"


@dataclass(frozen=True, slots=True)
class Times:
    """Seconds that a call may wait, and in which a module has to report, at all and once it was told to stop."""

    wait: float | None = None
    answer: float | None = None
    stop: float = 5.0


USUAL = Times()


class Held(NamedTuple):
    """An active slot; `lost` iff its module is gone; `due`: when an alarm is told unless it has reported."""

    call: CallId | None
    args: Args
    phase: Literal["running", "stopping"] = "running"
    lost: bool = False
    due: float | None = None


@dataclass(frozen=True, slots=True)
class Queued:
    """What stands in a waiting place: a call, or what the launch rule `origin` requires."""

    call: CallId | None
    origin: str | None
    rule: str
    because: str | None
    until: float | None


_NOTHING: Mapping[Any, Any] = MappingProxyType({})


class GateState(NamedTuple):
    """What the gate knows; `unsaid` are the slots of which no module has said yet whether they run."""

    unsaid: frozenset[SlotId]
    slots: Mapping[SlotId, Held] = _NOTHING
    places: Mapping[str, Queued] = _NOTHING
    strays: frozenset[SlotId] = frozenset()
    away: frozenset[str] = frozenset()
    violated: frozenset[str] = frozenset()
    readings: Mapping[str, Observe] = _NOTHING
    """What was read last before the gate has started."""
    started: bool = False

    def denial(self, request: str) -> tuple[str, str] | None:
        """Return the rule, and its reason, for which a call is refused before anybody is asked; None if it is not."""
        if not self.started:
            return "starting", STARTING
        if self.strays:
            return "stray", ASTRAY
        return ("unavailable", AWAY) if request in self.away else None

    def where(self, call: CallId) -> SlotId | str | None:
        """Return the slot that a call runs in, or the request at which it waits, if there is one."""
        for slot, held in self.slots.items():
            if held.call == call:
                return slot
        return next((name for name, queued in self.places.items() if queued.call == call), None)

    @property
    def due(self) -> float | None:
        """When the next deadline is, if there is one."""
        times = [held.due for held in self.slots.values()] + [queued.until for queued in self.places.values()]
        return min((each for each in times if each is not None), default=None)
