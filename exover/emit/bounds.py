"""How many tests, answers and passes one event can cost: upper bounds for each event, found on the tables alone.

A pass of steps 3 to 5 runs *programs*: rules that are restored, launches that are required, requests whose waiting
place is decided again. Two programs belong to one *part* of the spec if one reads what another may write, so a part in
which a pass changes nothing changes no more in that step, and the changes that a part can make bound its passes.
Between steps every part is stable, so an event wakes those that read what it may write, those with a required launch,
which is tried anew, and those where a request that fell from clearing to waiting may clear again.

Walks cost their longest path. Diagrams have no test whose answer follows from those above it (exover/ocrd/forest.py),
so these paths are those of consistent states as far as bounds of counters tell. Nothing looks for a reachable state
that takes them all: the figures are upper bounds. All is found in one look at every diagram and one at what every event
writes.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

from exover.emit.costs import Costs, Doing
from exover.ocrd import tables as t
from exover.ocrd.tables import Tables

PHASES = 3
"""Changes of a waiting place that waits and clears in one step: it clears, falls back, and is left."""


@dataclass(frozen=True, slots=True)
class Bound:
    """What an event does not exceed: tests `v[i] <= k`, answers, and passes of steps 3 to 5."""

    tests: int
    answers: int
    passes: int


@dataclass(frozen=True, slots=True)
class Bounds:
    """The bounds of every event: by request, by variable (those of posters count), by consumable."""

    asks: tuple[Bound, ...]
    reports: tuple[Bound, ...]
    aborts: tuple[Bound, ...]
    withdrawals: tuple[Bound, ...]
    """Of aborts of what waits."""
    readings: tuple[Bound, ...]
    levels: tuple[Bound, ...]

    @property
    def worst(self) -> Bound:
        """The bound of any event."""
        every = [*self.asks, *self.reports, *self.aborts, *self.withdrawals, *self.readings, *self.levels]
        rows = [(bound.tests, bound.answers, bound.passes) for bound in every]
        return Bound(*(max(column) for column in zip((0, 1, 0), *rows, strict=True)))


def bounds(tables: Tables) -> Bounds:
    """Return the bounds of every event."""
    cost = Costs(tables)
    parts = _Parts(tables, cost)
    requests = range(len(tables.requests))
    posters = [row.role == t.POSTER for row in tables.variables]
    return Bounds(
        asks=tuple(parts.bound(cost.ask(r)) for r in requests),
        reports=tuple(parts.bound(cost.report(r)) for r in requests),
        aborts=tuple(parts.bound(cost.kill(r)) for r in requests),
        withdrawals=tuple(parts.bound(cost.withdrawal(r)) for r in requests),
        readings=tuple(parts.bound(cost.reading(v) if is_poster else Doing()) for v, is_poster in enumerate(posters)),
        levels=tuple(parts.bound(cost.level(k)) for k in range(len(tables.stocks))),
    )


@dataclass(slots=True)
class _Part:
    """Programs that hang together: what they can do in one step, whatever the pass."""

    changes: int = 0
    answers: int = 0
    tests: int = 0
    """Of all changes."""
    rules: int = 0
    """Tests of all its rules, once."""
    restless: bool = False
    """Whether it may change something although nothing was written."""
    slots: set[int] = field(default_factory=set)
    """Those that it may kill."""


@dataclass(slots=True)
class _Program:
    """What runs in a pass: its diagrams, what it may write, and what it adds to its part."""

    roots: tuple[int, ...]
    writes: set[int]
    part: _Part


class _Parts:
    """The parts of a spec."""

    def __init__(self, tables: Tables, cost: Costs) -> None:
        self.tables = tables
        self.cost = cost
        self.waiting = [
            r for r, row in enumerate(tables.requests) if self._codes(row.decide) & {t.WAIT, t.CLEAR, t.SETTLE}
        ]
        programs = [*self._rules(), *self._launches(), *map(self._settling, self.waiting)]
        self.repeated = sum(cost.walk(tables.requests[r].decide) for r in self.waiting)
        self.repeated += sum(cost.walk(launch.condition) for launch in tables.launches)
        broken = {rule.reason for rule in tables.rules if t.VIOLATION in self._codes(rule.root)}
        self.violations = len(broken)
        self.first = sum(cost.walk(rule.root) for rule in tables.rules)
        self.touching, self.parts = self._join(programs)
        self.restless = [number for number, part in enumerate(self.parts) if part.restless]

    def bound(self, doing: Doing) -> Bound:
        """Return the bound of an event: what it does itself, and what the parts that it wakes do.

        Rules of the others are looked at once, in the first step of all, and find nothing.
        """
        woken = {part for quantity in doing.writes for part in self.touching.get(quantity, ())}
        parts = [self.parts[number] for number in woken.union(self.restless)]
        looping = bool(self.repeated or self.tables.rules or self.waiting or self.tables.launches)
        passes = max((1 + part.changes for part in parts), default=1) if looping else 0
        tests = doing.tests + self.first + passes * self.repeated
        tests += sum(part.tests + part.changes * part.rules for part in parts)
        answers = doing.answers + self.violations + sum(part.answers for part in parts)
        return Bound(tests, answers, passes)

    def _codes(self, root: int) -> set[int]:
        nodes = self.tables.nodes
        return {-nodes[index].code for index in self.cost.tables.below(root) if nodes[index].code < 0}

    # ---- programs ----

    def _kills(self, roots: Iterable[int]) -> tuple[set[int], set[int]]:
        """Return what the kills of diagrams write, and which slots they end."""
        writes: set[int] = set()
        slots: set[int] = set()
        for root in roots:
            for request, found in self.cost.killed(root).items():
                writes |= self.cost.slot_writes(request)
                slots |= found
        return writes, slots

    def _rules(self) -> Iterable[_Program]:
        for rule in self.tables.rules:
            writes, slots = self._kills([rule.root])
            yield _Program((rule.root,), writes, _Part(rules=self.cost.walk(rule.root), slots=slots))

    def _launches(self) -> Iterable[_Program]:
        """Yield the required launches: each is tried once in a step, answered, and may wait and leave its place."""
        for launch in self.tables.launches:
            request = launch.request
            decide = self.tables.requests[request].decide
            doing, waits = self.cost.decision(request), request in self.waiting
            tests = doing.tests + (7 if waits else 0) * self.cost.place[request]
            part = _Part(1 + PHASES * waits, 1 + waits, tests, restless=True, slots=self._kills([decide])[1])
            yield _Program((launch.condition, decide), doing.writes, part)

    def _settling(self, request: int) -> _Program:
        """Return what becomes of a waiting place: it may clear and wait again, and is left once."""
        decide = self.tables.requests[request].decide
        codes, doing = self._codes(decide), self.cost.decision(request)
        turns = t.WAIT in codes and bool(codes & {t.CLEAR, t.SETTLE})
        tests = self.cost.launch(request).tests + (2 * PHASES if turns else 2) * self.cost.place[request]
        part = _Part(PHASES if turns else 1, 1, tests, restless=turns, slots=self._kills([decide])[1])
        return _Program((decide,), doing.writes, part)

    # ---- what hangs together ----

    def _join(self, programs: list[_Program]) -> tuple[dict[int, set[int]], list[_Part]]:
        """Return by quantity the parts that read or write it, and the parts."""
        reads = [self._reads(program) for program in programs]
        written = {quantity for program in programs for quantity in program.writes}
        leader = list(range(len(programs)))

        def find(number: int) -> int:
            while leader[number] != number:
                leader[number] = leader[leader[number]]
                number = leader[number]
            return number

        met: dict[int, int] = {}
        for number, program in enumerate(programs):
            for quantity in (reads[number] & written) | program.writes:
                leader[find(number)] = find(met.setdefault(quantity, number))
        numbers = {root: index for index, root in enumerate(dict.fromkeys(map(find, range(len(programs)))))}
        parts = [_Part() for _ in numbers]
        touching: dict[int, set[int]] = {}
        for number, program in enumerate(programs):
            index = numbers[find(number)]
            _merge(parts[index], program.part)
            for quantity in reads[number] | program.writes:
                touching.setdefault(quantity, set()).add(index)
        for part in parts:
            part.changes += len(part.slots)
            part.answers += len(part.slots)
            part.tests += sum(2 * self.cost.slot[self.cost.owner[slot]] for slot in part.slots)
        return touching, parts

    def _reads(self, program: _Program) -> set[int]:
        nodes = self.tables.nodes
        return {nodes[i].code for root in program.roots for i in self.cost.tables.below(root) if nodes[i].code >= 0}


def _merge(part: _Part, other: _Part) -> None:
    part.changes += other.changes
    part.answers += other.answers
    part.tests += other.tests
    part.rules += other.rules
    part.restless |= other.restless
    part.slots |= other.slots
