"""The parts of an explanation: why an event was answered as it was."""

from typing import Literal

from exover.dataclass import dataclass
from exover.model.event import Action, Event
from exover.model.model import Location

Demand = Literal["nothing", "reject", "wait", "settle", "clear", "dismiss", "kill", "launch", "violation"]


@dataclass(frozen=True, slots=True)
class Fact:
    """A comparison or predicate that made a condition true or false, and the values it read: `nd.speed = 0.3`."""

    condition: str
    holds: bool
    read: str


@dataclass(frozen=True, slots=True)
class Attempt:
    """A remedy that was considered: whether it was chosen, and why or why not."""

    remedy: str
    chosen: bool
    note: str


@dataclass(frozen=True, slots=True)
class RuleVerdict:
    """The demand of one rule, guard, resource or launch rule, the supposed moment it was read in, and the facts.

    `written`: its text in the spec, None if the text is not at hand. `demand` is `nothing` if it did not object.
    """

    rule: str
    because: str | None
    written: str | None
    location: Location
    demand: Demand
    moment: str
    facts: tuple[Fact, ...]
    attempts: tuple[Attempt, ...] = ()


@dataclass(frozen=True, slots=True)
class Account:
    """Why one action was taken, or why none was (`action` is None): the verdicts that decided, and the others."""

    action: Action | None
    text: str
    deciding: tuple[RuleVerdict, ...] = ()
    others: tuple[RuleVerdict, ...] = ()


@dataclass(frozen=True, slots=True)
class Counterfactual:
    """As few changes of the state or event as possible, in words, and the answer that there would have been."""

    changes: tuple[str, ...]
    actions: tuple[Action, ...]


@dataclass(frozen=True, slots=True)
class CounterfactualSearch:
    """The smallest changes found, of `tried` ones; `complete` iff all changes of up to `most` quantities were tried."""

    turns: tuple[Counterfactual, ...]
    tried: int
    most: int
    complete: bool


@dataclass(frozen=True, slots=True)
class Explanation:
    """The last event of a stream (None: there is none), its answer, why, and which changes would have altered it.

    `search` is None for an invalid event: no change of the state makes it valid.
    `unanswered`: refusals of required launches that the answer omits, as the last step refused them for the same rule.
    `events`: the number of events in the stream, invalid ones included.
    """

    step: int
    event: Event | None
    actions: tuple[Action, ...]
    accounts: tuple[Account, ...]
    search: CounterfactualSearch | None = None
    unanswered: tuple[Action, ...] = ()
    events: int = 1
