"""How many tests, answers and passes one event can cost: upper bounds for each event, found on the tables alone.

An event costs what it does itself (costs.py), and the actions that it wakes, in as many passes as they take
(settling.py). Walks cost their longest path. Diagrams have no test whose answer follows from those above it
(exover/ocrd/forest.py), so these paths are those of consistent states as far as bounds of counters tell. Nothing looks
for a reachable state that takes them all: the figures are upper bounds.
"""

from functools import cached_property

from exover.bounds.costs import Costs, Doing
from exover.bounds.settling import Settling
from exover.dataclass import dataclass
from exover.ocrd import tables as t
from exover.ocrd.tables import Tables

TABLES = "the longest paths of the tables"
"""How bounds are found that are read from the tables alone."""


@dataclass(frozen=True, slots=True)
class Bound:
    """What an event does not exceed: tests `v[i] <= k`, answers, and passes of steps 3 to 5."""

    tests: int
    answers: int
    passes: int


@dataclass(frozen=True, slots=True)
class EventBounds:
    """The bounds of every event: by request, by variable (those of posters count), by consumable."""

    asks: tuple[Bound, ...]
    reports: tuple[Bound, ...]
    aborts: tuple[Bound, ...]
    withdrawals: tuple[Bound, ...]
    """Of aborts of what waits."""
    readings: tuple[Bound, ...]
    levels: tuple[Bound, ...]
    method: str = TABLES
    """How they were found."""

    @property
    def worst(self) -> Bound:
        """The bound of any event."""
        every = [*self.asks, *self.reports, *self.aborts, *self.withdrawals, *self.readings, *self.levels]
        rows = [(bound.tests, bound.answers, bound.passes) for bound in every]
        return Bound(*(max(column) for column in zip((0, 1, 0), *rows, strict=True)))


def bounds(tables: Tables, passes: int | None = None) -> EventBounds:
    """Return the bounds of every event; `passes`: more than so many are known not to be taken by any."""
    cost = Costs(tables)
    whole = _Bounding(tables, cost, Settling(tables, cost), passes)
    requests = range(len(tables.requests))
    posters = [row.role == t.POSTER for row in tables.variables]
    return EventBounds(
        asks=tuple(whole.bound(cost.ask(r)) for r in requests),
        reports=tuple(whole.bound(cost.report(r)) for r in requests),
        aborts=tuple(whole.bound(cost.kill(r)) for r in requests),
        withdrawals=tuple(whole.bound(cost.withdrawal(r)) for r in requests),
        readings=tuple(whole.bound(cost.reading(v) if is_poster else Doing()) for v, is_poster in enumerate(posters)),
        levels=tuple(whole.bound(cost.level(k)) for k in range(len(tables.stocks))),
    )


@dataclass
class _Bounding:
    """What is the same for every event."""

    tables: Tables
    cost: Costs
    settling: Settling
    most: int | None

    def bound(self, doing: Doing) -> Bound:
        """Return the bound of an event.

        In the first step of all every rule is looked at once; else those that its moves are told to.
        """
        rows, cost = self.tables, self.cost
        passes, reached = self.settling.woken(doing.moves)
        passes = 1 + passes if rows.rules or rows.launches or self.settling.waiting else 0
        passes = passes if self.most is None else min(passes, self.most)
        slots = doing.slots.union(*(component.slots for component in reached))
        places = doing.places.union(*(component.places for component in reached))
        tests = doing.tests + self.rules + passes * self.repeated + sum(component.tests for component in reached)
        tests += sum(cost.killing[self.tables.request_of(slot)] for slot in slots)
        tests += sum(self.settling.taken(request) * cost.leaving[request] for request in places)
        answers = doing.answers + self.violations + len(slots) + sum(component.answers for component in reached)
        return Bound(tests, answers + sum(map(self.settling.taken, places)), passes)

    @cached_property
    def repeated(self) -> int:
        """The tests of each pass: waiting places are decided again, launches that were not tried asked whether due."""
        found = sum(self.cost.walk(self.tables.requests[request].decide) for request in self.settling.waiting)
        return found + sum(self.cost.walk(launch.condition) for launch in self.tables.launches)

    @cached_property
    def rules(self) -> int:
        """The tests of looking at every rule once."""
        return sum(self.cost.walk(rule.root) for rule in self.tables.rules)

    @cached_property
    def violations(self) -> int:
        """How many reasons can be told to be broken."""
        return len({rule.reason for rule in self.tables.rules if t.VIOLATION in self.cost.codes(rule.root)})
