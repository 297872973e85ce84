"""What one event does to the state of a table: concretely on numbers, or for all states at once on terms of Z3.

The state is a value for each name of `layout`; some of them are *facts*, which tell what the last step did. Truths and
numbers that are Python's are computed at once, so that a run needs no solver (docs/certificates.md).
"""

from collections import namedtuple
from collections.abc import Iterable, Iterator
from fractions import Fraction
from typing import Any

from exover.certificate import table as t
from exover.certificate.table import NONE, REAL, Refused, Rows, Table
from exover.certificate.term import compare, conj, disj, ite, neg, order

IDLE, RUNNING, STOPPING = EMPTY, WAITING, CLEARING = range(3)
UNSAID, SUPERSEDED, ABORTED, BUSY = -1, -2, -3, 0
STANDS = (-t.WAIT, -t.CLEAR, -t.SETTLE)
DECISIONS = range(t.REJECT, t.LAUNCH + 1)
FACTS = ("abort", "fault", "asked", "ended", "launch", "wait", "reject", "kill", "left", "named", "watched")
FORGOTTEN = (*FACTS, "start", "tried", "fallen")
Range = namedtuple("Range", "low high")
Event = tuple[Any, ...]
"""Its kind, what it is about, the outcome of a report (1 ok, 2 failed, 3 interrupted), its values or their ranges."""
Loaded = tuple[int, Any] | None
"""A request and the arguments, with results or without, that tests of arguments are about."""


def layout(table: Table) -> Iterator[tuple[str, Any, Any, str]]:
    """Yield the parts of the state: name, first value, range (None of a truth), and to what each belongs."""

    def held(name: str, rows: list[Any], owner: str) -> Iterator[tuple[str, Any, Any, str]]:
        yield from ((f"{name}.{k}", Fraction(0) if row.type == REAL else 0, row, owner) for k, row in enumerate(rows))

    yield from ((name, name == "start", None, "") for name in ("start", "abort", "fault"))
    yield from ((f"named.{number}", False, None, "") for number in range(len(table.reasons)))
    yield from ((f"tried.{number}", False, None, "") for number in range(len(table.launches)))
    yield from ((f"watched.{number}", False, None, "") for number in range(len(table.watched)))
    for r, row in enumerate(table.requests):
        for slot in table.slots(r):
            yield f"phase.{slot}", IDLE, Range(IDLE, STOPPING), ""
            yield from held(f"arg.{slot}", row.params, f"phase.{slot}")
        yield f"place.{r}", EMPTY, Range(EMPTY, CLEARING), ""
        yield from held(f"held.{r}", row.params, f"place.{r}")
        yield f"past.{r}", False, None, ""
        yield from held(f"past.{r}", row.params + row.results, f"past.{r}")
        yield f"last.{r}", 0, Range(0, 3), ""
        yield from ((f"{name}.{r}", False, None, "") for name in (*FACTS[2:-2], "fallen"))
    yield from ((f"reading.{number}", row.initial, row, "") for number, row in enumerate(table.variables))
    yield from ((f"level.{k}", row.initial, Range(0, row.capacity), "") for k, row in enumerate(table.stocks))


def within(row: Any, value: Any) -> Any:
    """Return whether a value is in a range."""
    low = True if row.low == -float("inf") else disj(*compare(row.low, value))
    return conj(low, True if row.high == float("inf") else disj(*compare(value, row.high)))


def inputs(table: Table) -> Iterator[Event]:
    """Yield every kind of event, with the ranges of its values."""
    for request, row in enumerate(table.requests):
        yield "ask", request, 0, row.params
        for slot in table.slots(request):
            yield "report", slot, 1, row.results
            yield from (("report", slot, 2, []), ("report", slot, 3, []), ("abort", slot, 0, []))
        yield "give up", request, 0, []
    yield from (("observe", number, 0, [row]) for number, row in enumerate(table.variables) if row.role == 0)
    yield from (("level", number, 0, [Range(0, row.capacity)]) for number, row in enumerate(table.stocks))


def components(table: Table) -> list[tuple[str, int]]:
    """Return the parts of a pass, in their order."""
    parts = {"recover": table.rules, "require": table.launches, "settle": table.requests}
    return [(part, number) for part, rows in parts.items() for number in range(len(rows))]


def counted(table: Table) -> dict[int, list[tuple[Any, ...]]]:
    """Return by entry of the vector what it is the sum of. All its sources are set at once, or all are counted.

    They are a `side` (a name of the state, or a request and the number of an argument), the `order` of a side and
    others, a `past`, a `count` of slots and places (in which phase, with what arguments), `part`s that are entries.
    """
    found: dict[int, list[tuple[Any, ...]]] = {}

    def add(entry: int, *source: Any) -> None:
        if entry != NONE and ((table.entries[entry] and source[0] == "count") or source not in found.get(entry, ())):
            found.setdefault(entry, []).append(source)

    sided = [((r, k), row) for r, each in enumerate(table.requests) for k, row in enumerate(each.params + each.results)]
    for side, row in [*sided, *((f"reading.{v}", row) for v, row in enumerate(table.variables))]:
        add(row.value, "side", side)
        add(row.rank, "order", side, *row.cuts)
    for r, row in [*enumerate(table.requests), *enumerate(table.variables)]:
        for left, right, entry in row.orders:
            add(entry, "order", *((r, k) if k >= 0 else f"reading.{-1 - k}" for k in (left, right)))
    for r, row in enumerate(table.requests):
        add(row.last, "side", f"last.{r}")
        for past in row.pasts:
            add(past.entry, "past", r, f"past.{r}", True, f"past.{r}", past.predicate, NONE)
        for each in row.features:
            places = [(f"phase.{s}", f"arg.{s}") for s in table.slots(r) if each.slot in (NONE, s - row.slots)]
            ways = [(*place, each.running, each.stopping) for place in places]
            ways += [(f"place.{r}", f"held.{r}", each.waiting, each.clearing)] if each.slot == NONE else []
            for name, where, *entries in ways:
                for phase, entry in enumerate(entries, 1):
                    add(entry, "count", r, name, phase, where, each.predicate, each.weight)
    for k, row in enumerate(table.stocks):
        add(row.entry, "side", f"level.{k}")
    for number, row in enumerate(table.entries):
        for total in row.sums:
            add(total.entry, "part", number, total.factor)
    for entry, sources in found.items():
        kinds = {source[0] for source in sources}
        if len(kinds) > 1 or (len(sources) > 1 and not kinds & {"count", "part"}):
            raise Refused(f"entry {entry} is more than one thing")
        if "part" in kinds and any(other[0] == "part" for source in sources for other in found.get(source[1], ())):
            raise Refused("a sum is part of a sum")
    return found


class Step:
    """One step under way: the state as it is now, with the facts so far, and the answers, each with its condition."""

    def __init__(self, table: Table, state: dict[str, Any]) -> None:
        self.table, self.state = table, dict(state)
        self.answers: list[tuple[Any, tuple[Any, ...]]] = []

    # ---- small changes ----

    def put(self, cond: Any, value: Any, *names: str) -> None:
        """Let parts of the state have this value, if the condition holds."""
        for name in names if cond is not False else ():
            self.state[name] = ite(cond, value, self.state[name])

    def note(self, cond: Any, fact: str, request: int, args: list[Any]) -> None:
        """Note a fact about a request, if the condition holds, and what is watched of it and true of the arguments."""
        self.put(cond, True, f"{fact}.{request}")
        for number, (watched, its, where) in enumerate(self.table.watched):
            if (watched, its) == (fact, request):
                self.put(conj(cond, where(args)), True, f"watched.{number}")

    def say(self, cond: Any, kind: str, request: int, slot: int, reason: int, args: list[Any]) -> None:
        """Answer about a request with these arguments, if the condition holds; what was answered is a fact."""
        if cond is not False:
            self.answers.append((cond, (kind, request, slot, reason)))
            self.put(cond, True, *([f"named.{reason}"] if reason >= 0 else []))
            self.note(cond, kind, request, args)

    def held(self, name: str, request: int) -> Rows:
        """Return the arguments in `arg.SLOT` or `held.REQUEST`; with results, what `past.REQUEST` remembers."""
        row = self.table.requests[request]
        rows = row.params + row.results if name.startswith("past") else row.params
        return Rows(self.state[f"{name}.{k}"] for k in range(len(rows)))

    def hold(self, cond: Any, name: str, values: list[Any]) -> None:
        """Let these be the arguments there, if the condition holds."""
        for k, value in enumerate(values):
            self.put(cond, value, f"{name}.{k}")

    # ---- the vector and the diagrams ----

    def value(self, entry: int, loaded: Loaded) -> Any:
        """Return the value of an entry of the vector."""
        sources = self.table.counted.get(entry)
        if sources is None:
            return self.table.entries[entry].initial
        return sum(self._source(source, loaded) for source in sources)

    def _source(self, source: tuple[Any, ...], loaded: Loaded) -> Any:
        match source:
            case "side", side:
                return self._side(side, loaded)
            case "order", left, *rights:
                return sum(order(self._side(left, loaded), self._side(right, loaded)) for right in rights)
            case "part", entry, factor:
                return factor * self.value(entry, loaded)
            case _, r, name, phase, where, predicate, weight:
                values = self.held(where, r)
                there = conj(self.state[name] == phase, self.agrees(predicate, (r, values)))
                return ite(there, 1 if weight == NONE else values[weight], 0)

    def _side(self, side: Any, loaded: Loaded) -> Any:
        if isinstance(side, str):
            return self.state[side]
        if not isinstance(side, tuple):
            return side
        if loaded is None or loaded[0] != side[0]:
            raise Refused("a diagram tests an argument of a request that it is not about")
        return loaded[1][side[1]]

    def walk(self, root: int, codes: Iterable[int], loaded: Loaded = None) -> list[tuple[Any, Any, Any]]:
        """Return the action nodes below a root: each with when the path goes through it, and when as its first."""
        ways: dict[int, tuple[Any, Any]] = {root: (True, True)} if root != NONE else {}
        found = []
        while ways:
            number = min(ways)
            on, first = ways.pop(number)
            node = self.table.nodes[number]
            if node.code < 0:
                found.append((node, on, first))
                then = [(node.low, True, False)]
            else:
                low = self.value(node.code, loaded) <= node.bound
                then = [(node.low, low, low), (node.high, neg(low), neg(low))]
            if any(NONE != child <= number for child, _, _ in then) or (node.code < 0 and -node.code not in codes):
                raise Refused(f"node {number} does not lead on, or is no action of its kind")
            for child, also, still in then:
                if child != NONE and (more := conj(on, also)) is not False:
                    known = ways.get(child, (False, False))
                    ways[child] = (disj(known[0], more), disj(known[1], conj(first, still)))
        return found

    def agrees(self, predicate: int, loaded: Loaded) -> Any:
        """Return whether a predicate says `agree`."""
        return predicate == t.ALWAYS or disj(*(on for _, on, _ in self.walk(predicate, [t.AGREE], loaded)))

    # ---- events ----

    def update(self, event: Event) -> Any:
        """Begin a step: nothing has happened in it; then do what the event says, and return whether it can happen."""
        kind, number, outcome, values = event
        self.state |= {name: False for name in self.state if name.split(".")[0] in FORGOTTEN}
        place = {"give up": f"place.{number}", "report": f"phase.{number}", "abort": f"phase.{number}"}.get(kind)
        can = place is None or self.state[place] != IDLE
        match kind:
            case "ask":
                self.note(True, "asked", number, values)
                self.decide(True, number, values, UNSAID)
            case "report":
                self.report(number, outcome, values)
            case "abort":
                self.put(True, True, "abort")
                self.kill(True, [number], ABORTED)
            case "give up":
                self.put(True, True, "abort")
                self.vacate(True, number, ABORTED)
            case _:
                self.put(True, values[0], f"{'reading' if kind == 'observe' else kind}.{number}")
                self.latch(NONE)
        return can

    def report(self, slot: int, outcome: int, results: list[Any]) -> None:
        """End a slot: its past, what it gives, its effects, the latches."""
        request = self.table.owner[slot]
        row, args, ok = self.table.requests[request], self.held(f"arg.{slot}", request), outcome == 1
        self.note(True, "ended", request, args)
        self.put(ok, True, f"past.{request}")
        self.state |= {f"phase.{slot}": IDLE, f"last.{request}": outcome}
        self.hold(ok, f"past.{request}", args + results)
        self.supply(ok, request, args, row.produces, 1)
        self.affect(True, (row.on_ok, row.on_failed, row.on_interrupted)[outcome - 1])
        self.latch(request if ok else NONE)

    def supply(self, cond: Any, request: int, args: list[Any], amounts: Iterable[Any], sign: int) -> None:
        """Take or give what a launch or an ok does, never above the capacity."""
        for amount in amounts if cond is not False else ():
            level, capacity = f"level.{amount.stock}", self.table.stocks[amount.stock].capacity
            more = self.state[level] + sign * amount.amount
            counts = conj(cond, self.agrees(amount.predicate, (request, args)))
            self.put(counts, more if sign < 0 else ite(more > capacity, capacity, more), level)
            self.put(conj(counts, more < 0), True, "fault")

    def affect(self, cond: Any, effects: Iterable[Any]) -> None:
        """Apply effects: what a variable is set to, which past is forgotten."""
        for kind, target, value in effects:
            self.put(cond, *{0: (value, f"reading.{target}"), 1: (False, f"past.{target}")}[kind])

    def latch(self, reset: int) -> None:
        """Set and clear the latches after a report ok of `reset`, or something else."""
        for latch in self.table.latches:
            name = f"reading.{latch.variable}"
            self.put((reset,) in latch.resets, 0, name)
            self.put(self.agrees(latch.condition, None), 1, name)

    def kill(self, cond: Any, slots: Iterable[int], reason: int) -> None:
        """Kill those of the slots that run."""
        for slot in slots:
            request, runs = self.table.owner[slot], conj(cond, self.state[f"phase.{slot}"] == RUNNING)
            self.put(runs, STOPPING, f"phase.{slot}")
            args = self.held(f"arg.{slot}", request)
            self.say(runs, "kill", request, slot - self.table.requests[request].slots, reason, args)

    def kill_target(self, cond: Any, node: Any) -> None:
        """Kill what an action node says: all slots of a request, or one of all."""
        self.kill(cond, self.table.slots(node.high) if node.high >= 0 else [-1 - node.high], node.bound)

    def empty(self, cond: Any, request: int) -> None:
        """Let nothing stand in a waiting place any more."""
        self.put(cond, EMPTY, f"place.{request}")
        self.put(cond, True, f"left.{request}")

    def vacate(self, cond: Any, request: int, reason: int) -> None:
        """Reject what stands in a waiting place."""
        self.empty(cond, request)
        self.say(cond, "reject", request, NONE, reason, self.held(f"held.{request}", request))

    # ---- decisions ----

    def decide(self, cond: Any, request: int, args: list[Any], reason: int, settling: bool = False) -> None:
        """Decide on a newcomer, which a launch rule requires if there is a reason; or anew on what stands waiting."""
        place, row = f"place.{request}", self.table.requests[request]
        before, taken = self.state[place], conj(cond, self.state[place] != EMPTY)
        if not settling and not row.interrupts_self:
            self.say(taken, "reject", request, NONE, BUSY, args)
            cond, taken = conj(cond, neg(taken)), False
        path = self.walk(row.decide, DECISIONS, (request, args))
        self.put(conj(cond, neg(disj(*(first for _, _, first in path)))), True, "fault")
        goes = conj(cond, neg(disj(*(first for node, _, first in path if node.code == -t.REJECT))))
        for node, _, first in path:
            if node.code == -t.REJECT:
                self.empty(settling and conj(cond, first), request)
                self.say(conj(cond, first), "reject", request, NONE, node.bound, args)
        if settling:
            fallen = self.state[f"fallen.{request}"]
            standing = [(node.code, first) for node, _, first in path if node.code in STANDS]
            stays = conj(goes, disj(*(first if code == -t.WAIT else conj(first, fallen) for code, first in standing)))
            self.put(conj(stays, before == CLEARING), True, f"fallen.{request}")
            self.put(stays, WAITING, place)
            goes = conj(goes, neg(stays))
        else:
            self.put(goes, True, f"left.{request}")
            self.say(conj(taken, goes), "reject", request, NONE, SUPERSEDED, self.held(f"held.{request}", request))
        for node, on, _ in path:
            self.act(conj(goes, on), node, request, args, reason)
        for node, on, _ in path if not settling else ():
            if node.code in STANDS:
                self.say(conj(goes, on), "wait", request, NONE, node.bound, args)

    def act(self, cond: Any, node: Any, request: int, args: list[Any], reason: int) -> None:
        """Do what an action node says; a rejection has been said."""
        if node.code in STANDS:
            self.put(cond, WAITING if node.code == -t.WAIT else CLEARING, f"place.{request}")
            self.hold(cond, f"held.{request}", args)
        elif node.code == -t.KILL:
            self.kill_target(cond, node)
        elif node.code == -t.DISMISS:
            self.vacate(conj(cond, self.state[f"place.{node.high}"] != EMPTY), node.high, node.bound)
        elif node.code == -t.LAUNCH:
            self.launch(cond, request, args, reason)

    def launch(self, cond: Any, request: int, args: list[Any], reason: int) -> None:
        """Let a newcomer take the lowest idle slot; the bit row must show no conflict."""
        row, free = self.table.requests[request], cond
        others = [16 * each.block + i for each in row.conflicts for i in range(16) if each.mask >> i & 1]
        busy = [self.state[f"phase.{slot}"] != IDLE for other in others for slot in self.table.slots(other)]
        self.put(conj(cond, disj(*busy)), True, "fault")
        self.empty(cond, request)
        for slot in self.table.slots(request):
            here = conj(free, self.state[f"phase.{slot}"] == IDLE)
            free = conj(free, neg(here))
            self.put(here, RUNNING, f"phase.{slot}")
            self.hold(here, f"arg.{slot}", args)
            self.say(here, "launch", request, slot - row.slots, reason, args)
        self.put(free, True, "fault")
        self.supply(cond, request, args, row.consumes, -1)
        self.affect(cond, row.on_launch)

    # ---- steps 3 to 5 ----

    def run(self, component: tuple[str, int]) -> None:
        """Run one part of a pass."""
        part, number = component
        if part == "recover":
            for node, on, _ in self.walk(self.table.rules[number].root, (t.KILL, t.VIOLATION)):
                if node.code == -t.KILL:
                    self.kill_target(on, node)
        elif part == "require":
            launch, words = self.table.launches[number], self.table.lists
            due = conj(neg(self.state[f"tried.{number}"]), self.agrees(launch.condition, None))
            self.put(due, True, f"tried.{number}")
            given = [
                (row.type, words[launch.args + k][0])
                for k, row in enumerate(self.table.requests[launch.request].params)
            ]
            args = [self.table.reals[word] if kind == REAL else word for kind, word in given]
            self.decide(due, launch.request, args, launch.reason)
        else:
            there = self.state[f"place.{number}"] != EMPTY
            self.decide(there, number, self.held(f"held.{number}", number), UNSAID, settling=True)


def step(table: Table, state: dict[str, Any], event: Event) -> tuple[dict[str, Any], list[tuple[Any, ...]]]:
    """Return the state and the answers after an event, all concrete."""
    now = Step(table, state)
    if now.update(event) is not True:
        raise Refused(f"the event {event!r} cannot happen where the run is")
    for _ in range(table.limits[0].passes):
        before = dict(now.state)
        for component in components(table):
            now.run(component)
        if now.state == before:
            break
    else:
        raise Refused("a step does not end within the passes that the table allows")
    ends = [
        (rule.reason, node, on) for rule in table.rules for node, on, _ in now.walk(rule.root, (t.KILL, t.VIOLATION))
    ]
    broken = dict.fromkeys(reason for reason, node, on in ends if on and node.code == -t.VIOLATION)
    violations = [("violation", NONE, NONE, reason) for reason in broken]
    return now.state, [answer for cond, answer in now.answers if cond is True] + violations
