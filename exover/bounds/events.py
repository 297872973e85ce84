"""Worst-case bounds of each event, by static analysis of the tables: how many tests, answers and passes it can cost.

An event costs what it does itself (costs.py) and the actions that it wakes, in as many passes as they take
(settling.py). A walk costs the longest path of its diagram. But for decisions that ask anew, diagrams have no
test whose answer follows from those above it (exover/ocrd/forest.py), so each path belongs to a consistent state, as
far as the bounds of counters tell. Whether one reachable state takes all the longest paths is not asked: the figures
are upper bounds.
"""

from functools import cached_property

from exover.bounds.costs import Costs, Doing
from exover.bounds.settling import Settling
from exover.dataclass import dataclass
from exover.ocrd import tables as t
from exover.ocrd.tables import Tables

TABLES = "the longest paths of the tables"
"""The method of bounds that are found on the tables alone."""


@dataclass(frozen=True, slots=True)
class Bound:
    """The worst case of an event: the most tests `v[i] <= k`, answers, and passes of steps 3 to 5."""

    tests: int
    answers: int
    passes: int


@dataclass(frozen=True, slots=True)
class EventBounds:
    """The bounds of every event: by request, by variable (only posters are observed), by consumable."""

    asks: tuple[Bound, ...]
    reports: tuple[Bound, ...]
    aborts: tuple[Bound, ...]
    withdrawals: tuple[Bound, ...]
    """Of aborts of waiting requests, by request."""
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
    """Return the bounds of every event; `passes`: a number of passes that no event is known to exceed."""
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
    """What the bounds of all events have in common; `most`: passes that no event exceeds, if known."""

    tables: Tables
    cost: Costs
    settling: Settling
    most: int | None

    def bound(self, doing: Doing) -> Bound:
        """Return the bound of an event.

        The first step of a run walks every rule once, a later one those of which its moves may change an entry.
        """
        rows, cost = self.tables, self.cost
        woken = self.settling.woken(doing.moves)
        passes = 1 + woken.passes if rows.rules or rows.launches or self.settling.waiting else 0
        passes = passes if self.most is None else min(passes, self.most)
        slots, places = doing.slots | woken.slots, doing.places | woken.places
        tests = doing.tests + self.rules + passes * self.repeated + woken.tests
        tests += sum(cost.killing[self.tables.request_of(slot)] for slot in slots)
        tests += sum(self.settling.taken(request) * cost.leaving[request] for request in places)
        answers = doing.answers + self.violations + len(slots) + woken.answers
        return Bound(tests, answers + sum(map(self.settling.taken, places)), passes)

    @cached_property
    def repeated(self) -> int:
        """The tests of each pass: waiting requests are decided again, and the conditions of launch rules are walked."""
        found = sum(self.cost.walk(self.tables.requests[request].decide) for request in self.settling.waiting)
        return found + sum(self.cost.walk(launch.condition) for launch in self.tables.launches)

    @cached_property
    def rules(self) -> int:
        """The tests of walking every rule once."""
        return sum(self.cost.walk(rule.root) for rule in self.tables.rules)

    @cached_property
    def violations(self) -> int:
        """How many violations one answer can have: the reasons of rules that may raise one."""
        return len({rule.reason for rule in self.tables.rules if t.VIOLATION in self.tables.actions(rule.root)})
