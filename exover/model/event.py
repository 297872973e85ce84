"""Events that the environment raises, and the actions that answer them (docs/language.md sections 4 and 5)."""

from typing import Literal, get_args

from exover.dataclass import dataclass
from exover.model.types import Value

Ending = Literal["ok", "failed", "interrupted"]
ENDINGS: tuple[Ending, ...] = get_args(Ending)
Args = tuple[Value, ...]
"""Arguments or results in the order of their declaration."""
NO_RULES = ("busy", "superseded", "aborted", "abort")
"""Reasons in answers that are not names of rules, in the order of docs/serve.md; no rule may have these names."""
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
"""Codes of `Invalid`, in the order of docs/language.md and docs/serve.md."""


@dataclass(frozen=True, slots=True)
class Ask:
    """The decisional level asks for this request with these arguments."""

    request: str
    args: Args = ()


@dataclass(frozen=True, slots=True)
class Report:
    """Slot `slot` of the request has ended; only the outcome ok has `results`, only failed may have a `status`."""

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
    """Give up what is in the request's waiting place."""

    request: str


Event = Ask | Report | Observe | Abort | AbortWaiting


@dataclass(frozen=True, slots=True)
class Launched:
    """A slot starts to run; `rule` is the launch rule if this is a required launch that did not wait before.

    Here and below, `launch_rule` is the launch rule that raised the request, None if it was asked for.
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
    """The request is refused; `rule` may also be `busy`, `superseded` or `aborted`, and in compiled code `faulty`."""

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
    """The event is invalid, or the reading of an `Observe` was broken; `code` is one of `INVALID_CODES`."""

    code: str
    detail: str = ""

    @property
    def is_unread(self) -> bool:
        """Whether the line held no event at all, as opposed to an invalid one."""
        return self.code == "bad-event"


Action = Launched | Waits | Rejected | Killed | Violated | Invalid
