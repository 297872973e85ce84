"""The state of the gate: slots, waiting places and modules, as frozen values."""

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

from exover.dataclass import dataclass
from exover.gate.binding import STOP
from exover.gate.outer import CallId
from exover.model.event import Args, Observe
from exover.model.state import SlotId

STARTING = "the modules have not said yet what runs"
ASTRAY = "something runs that nobody has asked for here"
AWAY = "its module is not there"


@dataclass(frozen=True, slots=True)
class Times:
    """Time-outs in seconds: `wait` to be launched, `answer` until the report, `stop` from a cancel until the report."""

    wait: float | None = None
    answer: float | None = None
    stop: float = STOP


USUAL = Times()


class Held(NamedTuple):
    """An active slot; `lost` iff its module is gone; `due`: the time of the alarm if it has not reported by then."""

    call: CallId | None
    args: Args
    phase: Literal["running", "stopping"] = "running"
    lost: bool = False
    due: float | None = None


@dataclass(frozen=True, slots=True)
class Queued:
    """What is in a waiting place: a call, or what the launch rule `origin` requires; it may wait `until` then."""

    call: CallId | None
    origin: str | None
    rule: str
    because: str | None
    until: float | None


_NOTHING: Mapping[Any, Any] = MappingProxyType({})


class GateState(NamedTuple):
    """The state of the gate; `unsaid`: slots whose module has not said whether they run; `places`: by request."""

    unsaid: frozenset[SlotId]
    slots: Mapping[SlotId, Held] = _NOTHING
    places: Mapping[str, Queued] = _NOTHING
    strays: frozenset[SlotId] = frozenset()
    away: frozenset[str] = frozenset()
    violated: frozenset[str] = frozenset()
    readings: Mapping[str, Observe] = _NOTHING
    """The last reading of each poster from before the start, until the checker has been told."""
    started: bool = False

    def denial(self, request: str) -> tuple[str, str] | None:
        """Return rule and reason by which the gate refuses a call without asking the checker; None if it does not."""
        if not self.started:
            return "starting", STARTING
        if self.strays:
            return "stray", ASTRAY
        return ("unavailable", AWAY) if request in self.away else None

    def where(self, call: CallId) -> SlotId | str | None:
        """Return the slot that a call runs in, or the request in whose waiting place it is; None if neither."""
        for slot, held in self.slots.items():
            if held.call == call:
                return slot
        return next((name for name, queued in self.places.items() if queued.call == call), None)

    @property
    def due(self) -> float:
        """The time of the next deadline; infinite if there is none."""
        times = [held.due for held in self.slots.values()] + [queued.until for queued in self.places.values()]
        return min((each for each in times if each is not None), default=math.inf)
