"""Outer events and outer effects of the gate, independent of any protocol (docs/gate.md)."""

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
    """Identifies a call of a client; each call has its own."""

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
    """A client cancels one of its calls."""

    call: CallId


@dataclass(frozen=True, slots=True)
class ClientGone:
    """A client has gone: it ended, died or lost its connection."""

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
    """A module refuses to stop a slot."""

    slot: SlotId


@dataclass(frozen=True, slots=True)
class ModuleGone:
    """The module of these requests has died or cannot be reached."""

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
    """What waits at a request is given up; `rule` is `deadline`, `unavailable` or `stray`. Made by `GateMachine.parts`
    only.
    """

    request: str
    rule: str


OuterEvent = (
    Called | Cancelled | ClientGone | Reported | Observed | CancelRefused | ModuleGone | SlotSaid | Ticked | GivenUp
)


# ---- outer effects ----


@dataclass(frozen=True, slots=True)
class Forward:
    """Start a slot at its module; without a call, a launch rule requires it."""

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
    """The call is refused: at once, after it was held, or since its module is gone."""

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
    """The slot has ended: its call, if there is one, gets what the module has answered."""

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


def reason_text(rule: str, because: str | None) -> str:
    """Return a rule, and its text if it has one, as `RULE: TEXT`."""
    return f"{rule}: {because}" if because else rule
