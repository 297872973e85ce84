"""What happens outside of the gate, and what the gate does there (docs/gate.md); no protocol is named here."""

from typing import Literal, NamedTuple

from exover.dataclass import dataclass
from exover.model.event import Args, Ask, Ending, Observe, Report
from exover.model.state import SlotId

AlarmKind = Literal[
    "no-report",
    "does-not-stop",
    "refuses-to-stop",
    "module-gone",
    "stray",
    "refused-launch",
    "violation",
    "invalid",
    "unknown-status",
    "blind",
    "faulty",
]


class CallId(NamedTuple):
    """A call of a client; no two are ever alike."""

    client: str
    number: int


# ---- outer events ----


@dataclass(frozen=True, slots=True)
class Called:
    """A client asks for a request."""

    call: CallId
    ask: Ask


@dataclass(frozen=True, slots=True)
class Cancelled:
    """A client gives up a call of its own."""

    call: CallId


@dataclass(frozen=True, slots=True)
class ClientGone:
    """A client is not there any more."""

    client: str


@dataclass(frozen=True, slots=True)
class Reported:
    """A module reports that a slot has ended."""

    report: Report


@dataclass(frozen=True, slots=True)
class Observed:
    """A poster, or the level of a consumable resource, was read."""

    observe: Observe


@dataclass(frozen=True, slots=True)
class CancelRefused:
    """A module does not stop a slot though it was told to."""

    slot: SlotId


@dataclass(frozen=True, slots=True)
class ModuleGone:
    """The module of these requests is not there any more."""

    requests: frozenset[str]


@dataclass(frozen=True, slots=True)
class SlotSaid:
    """A module says whether a slot runs."""

    slot: SlotId
    active: bool


@dataclass(frozen=True, slots=True)
class Ticked:
    """Time has passed."""


@dataclass(frozen=True, slots=True)
class GivenUp:
    """What waits at a request may wait no longer; `rule` is `deadline` or `unavailable`. Part of other events."""

    request: str
    rule: str


OuterEvent = (
    Called | Cancelled | ClientGone | Reported | Observed | CancelRefused | ModuleGone | SlotSaid | Ticked | GivenUp
)


# ---- outer effects ----


@dataclass(frozen=True, slots=True)
class Forward:
    """Let the module of a slot begin; without a call, a launch rule requires it."""

    call: CallId | None
    slot: SlotId
    args: Args


@dataclass(frozen=True, slots=True)
class Hold:
    """The call is accepted and waits."""

    call: CallId
    rule: str
    because: str | None


@dataclass(frozen=True, slots=True)
class Refuse:
    """The call is refused, at once or after it was held, or nobody is there any more to answer it."""

    call: CallId
    rule: str
    because: str | None


@dataclass(frozen=True, slots=True)
class Stop:
    """Tell the module of a slot to end it."""

    slot: SlotId
    rule: str
    because: str | None


@dataclass(frozen=True, slots=True)
class Finish:
    """The slot has ended: the call, if it has one, gets what the module has answered."""

    call: CallId | None
    slot: SlotId
    outcome: Ending


@dataclass(frozen=True, slots=True)
class Alarm:
    """Something that a person should know."""

    kind: AlarmKind
    request: str | None = None
    slot: int | None = None
    detail: str = ""

    def __str__(self) -> str:
        """Return the alarm as one line."""
        about = "" if self.request is None else f" {self.request}" + ("" if self.slot is None else f"[{self.slot}]")
        return f"{self.kind}{about}" + (f": {self.detail}" if self.detail else "")


OuterEffect = Forward | Hold | Refuse | Stop | Finish | Alarm
