"""Events that the environment raises, and the actions that answer them (docs/language.md sections 4 and 5)."""

from typing import Literal, get_args

from exover.dataclass import dataclass
from exover.model.types import Value

Ending = Literal["ok", "failed", "interrupted"]
ENDINGS: tuple[Ending, ...] = get_args(Ending)
Args = tuple[Value, ...]
"""Arguments or results in the order of their declaration."""
NO_RULES = ("busy", "superseded", "aborted", "abort")
"""Reasons that answers give without a rule, in the order of docs/serve.md; no rule is called so."""
INVALID_CODES = (
    "bad-event",
    "unknown-request",
    "unknown-poster",
    "unknown-argument",
    "missing-argument",
    "wrong-type",
    "out-of-range",
    "unknown-status",
    "not-active",
    "nothing-to-abort",
)
"""Codes of `Invalid`, in the order of the language, which is that of docs/serve.md."""


@dataclass(frozen=True, slots=True)
class Ask:
    """Run this request with these arguments."""

    request: str
    args: Args = ()


@dataclass(frozen=True, slots=True)
class Report:
    """Slot `slot` of the request has ended; `results` are there iff the outcome is ok."""

    request: str
    slot: int
    outcome: Ending
    results: Args = ()
    status: str | None = None


@dataclass(frozen=True, slots=True)
class Observe:
    """A poster now reads `value`, or a consumable has this level.

    `broken`: the reading was out of range, `value` is the poster's fallback, and the answer begins with `invalid`.
    """

    name: str
    value: Value
    broken: bool = False


@dataclass(frozen=True, slots=True)
class Abort:
    """End slot `slot` of the request."""

    request: str
    slot: int


@dataclass(frozen=True, slots=True)
class AbortWaiting:
    """Give up what stands in the request's waiting place."""

    request: str


Event = Ask | Report | Observe | Abort | AbortWaiting


@dataclass(frozen=True, slots=True)
class Launched:
    """A slot starts to run; `rule` is the launch rule if it was required and starts at once.

    Here and below, `launch_rule` is the launch rule that the request comes of, None if it was asked for.
    """

    request: str
    slot: int
    args: Args
    rule: str | None = None
    because: str | None = None
    launch_rule: str | None = None


@dataclass(frozen=True, slots=True)
class Waits:
    """The newcomer takes the waiting place."""

    request: str
    rule: str
    because: str | None = None
    launch_rule: str | None = None


@dataclass(frozen=True, slots=True)
class Rejected:
    """The request is refused; `rule` may also be `busy`, `superseded` or `aborted`, or `faulty` of compiled code."""

    request: str
    rule: str
    because: str | None = None
    launch_rule: str | None = None


@dataclass(frozen=True, slots=True)
class Killed:
    """A running slot is told to stop, for a rule or for `abort`."""

    request: str
    slot: int
    rule: str
    because: str | None = None


@dataclass(frozen=True, slots=True)
class Violated:
    """The rule could not be restored."""

    rule: str
    because: str | None = None


@dataclass(frozen=True, slots=True)
class Invalid:
    """The event was not one; `code` is one of `INVALID_CODES`."""

    code: str
    detail: str = ""

    @property
    def is_unread(self) -> bool:
        """Whether there was no event at all, rather than one that is invalid."""
        return self.code == "bad-event"


Action = Launched | Waits | Rejected | Killed | Violated | Invalid
