"""Why an event was answered so: what an explanation is made of."""

from typing import Literal

from exover.dataclass import dataclass
from exover.model.event import Action, Event
from exover.model.model import Location

Demand = Literal["nothing", "reject", "wait", "settle", "clear", "dismiss", "kill", "launch", "violation"]


@dataclass(frozen=True, slots=True)
class Fact:
    """A comparison or predicate that made a condition true or false, and what it read: `nd.speed = 0.3`."""

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
    """What one rule, guard, resource or launch rule said, in which imagined moment, and on which facts.

    `written`: its text in the spec, where that is at hand. `demand` is `nothing` where it did not object.
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
    """Why one action was taken, or none (`action` is None): the verdicts that decided, and those that did not."""

    action: Action | None
    text: str
    deciding: tuple[RuleVerdict, ...] = ()
    others: tuple[RuleVerdict, ...] = ()


@dataclass(frozen=True, slots=True)
class Counterfactual:
    """Changes of the state or of the event, as few as possible, and the answer that they would have brought."""

    changes: tuple[str, ...]
    actions: tuple[Action, ...]


@dataclass(frozen=True, slots=True)
class CounterfactualSearch:
    """The smallest changes that were found; `complete` iff all changes of up to `most` quantities were tried."""

    turns: tuple[Counterfactual, ...]
    tried: int
    most: int
    complete: bool


@dataclass(frozen=True, slots=True)
class Explanation:
    """The last event of a stream (None: no event at all), its answer, why, and what would have turned it.

    `search` is None where the event is invalid: it is to be written otherwise, and no state makes it right.
    `unanswered`: refusals of required launches beside the actions, for the reasons of the last step: not told again.
    `events`: how many of the lines were events, be they invalid.
    """

    step: int
    event: Event | None
    actions: tuple[Action, ...]
    accounts: tuple[Account, ...]
    search: CounterfactualSearch | None = None
    unanswered: tuple[Action, ...] = ()
    events: int = 1
