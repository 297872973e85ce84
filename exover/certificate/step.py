"""What one event does to the state of a table: concretely on numbers, or for all states at once on terms of Z3.

The state is a value for each name of `layout`; some of them are *facts*, which tell what the last step did. On Python
values everything is computed at once, so that a run needs no solver (docs/certificates.md).
"""

from collections import namedtuple
from collections.abc import Collection, Iterable, Iterator, Sequence
from fractions import Fraction
from typing import Any

from exover.certificate import table as t
from exover.certificate.table import NONE, REAL, Refused, Rows, Table
from exover.certificate.term import conj, disj, ite, neg

IDLE, RUNNING, STOPPING = EMPTY, WAITING, CLEARING = range(3)
UNSAID, SUPERSEDED, ABORTED, BUSY = -1, -2, -3, 0
STANDS = (-t.WAIT, -t.CLEAR, -t.SETTLE)
FACTS = ("abort", "fault", "asked", "ended", "launch", "wait", "reject", "kill", "left", "named", "watched")
FORGOTTEN = (*FACTS, "start", "tried", "fallen")
ABOUT = {"ask": "request", "give up": "request", "observe": "variable", "level": "stock"}
Range = namedtuple("Range", "low high")
Event = tuple[Any, ...]
"""Kind, number of its subject, outcome of a report (1 ok, 2 failed, 3 interrupted; else 0), values or their ranges."""


def layout(table: Table) -> Iterator[tuple[str, Any, Any, str]]:
    """Yield the parts of the state: name, first value, range (None: a Bool), and the name that tells if it is held."""

    def held(name: str, rows: list[Any], owner: str) -> Iterator[tuple[str, Any, Any, str]]:
        yield from ((f"{name}.{k}", Fraction(0) if row.type == REAL else 0, row, owner) for k, row in enumerate(rows))

    yield from ((name, name == "start", None, "") for name in ("start", "abort", "fault"))
    for name, rows in (("named", table.reasons), ("tried", table.launches), ("watched", table.watched)):
        yield from ((f"{name}.{number}", False, None, "") for number in range(len(rows)))
    for r, row in enumerate(table.requests):
        for slot in table.slots(r):
            yield f"phase.{slot}", IDLE, Range(IDLE, STOPPING), ""
            yield from held(f"arg.{slot}", row.params, f"phase.{slot}")
        yield f"place.{r}", EMPTY, Range(EMPTY, CLEARING), ""
        yield from held(f"held.{r}", row.params, f"place.{r}")
        yield f"last.{r}", 0, Range(0, 3), ""
        yield from ((f"{name}.{r}", False, None, "") for name in (*FACTS[2:-2], "fallen", "past"))
        yield from held(f"past.{r}", row.params + row.results, f"past.{r}")
    yield from ((f"reading.{number}", row.initial, row, "") for number, row in enumerate(table.variables))
    yield from ((f"level.{k}", row.initial, Range(0, row.capacity), "") for k, row in enumerate(table.stocks))


def within(row: Any, value: Any) -> Any:
    """Return the condition that a value is in a range."""
    return conj(row.low == float("-inf") or row.low <= value, row.high == float("inf") or value <= row.high)


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


def worded(event: Event) -> str:
    """Return an event in words, for the texts of `Refused`."""
    outcome = ("", ", ok", ", failed", ", interrupted")[event[2]]
    return f"the event `{event[0]}` of {ABOUT.get(event[0], 'slot')} {event[1]}{outcome}"


def counted(table: Table) -> dict[int, list[tuple[Any, ...]]]:
    """Return by entry of the vector the sources of which it is the sum; more than one are all `count` or all `part`.

    A source is a `side` (a name of the state, or a request and the number of an argument), the `order` of a side and
    others, a `past`, a `count` of a slot or place (in a phase, with certain arguments), or a `part`, another entry.
    """
    found: dict[int, list[tuple[Any, ...]]] = {}

    def add(entry: int, *source: Any) -> None:
        if entry != NONE and table.entries[entry]:
            known = found.setdefault(entry, [])
            if not known or (source[0] == known[0][0] and source[0] in ("count", "part")):
                known.append(source)
            elif source not in known:
                raise Refused(f"entry {entry} is more than one thing")

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
            slots = [slot for slot in table.slots(r) if each.slot in (NONE, slot - row.slots)]
            places = [(f"phase.{slot}", f"arg.{slot}", each.running, each.stopping) for slot in slots]
            places += [(f"place.{r}", f"held.{r}", each.waiting, each.clearing)] if each.slot == NONE else []
            for name, where, *entries in places:
                for phase, entry in enumerate(entries, 1):
                    add(entry, "count", r, name, phase, where, each.predicate, each.weight)
    for k, row in enumerate(table.stocks):
        add(row.entry, "side", f"level.{k}")
    for number, row in enumerate(table.entries):
        for total in row.sums:
            add(total.entry, "part", number, total.factor)
    if any(found[n][0][0] == "part" for said in found.values() for kind, n, *_ in said if kind == "part" if n in found):
        raise Refused("a sum is part of a sum")
    return found


class TableStep:
    """One step under way: the state now, with the facts so far, and the answers, each with its condition.

    `touched`: the names that `put` may have changed.
    """

    def __init__(self, table: Table, state: dict[str, Any], answers: Iterable[tuple[Any, Any]] = ()) -> None:
        self.table, self.state, self.answers, self.touched = table, dict(state), list(answers), set[str]()

    # ---- small changes ----

    def put(self, cond: Any, value: Any, *names: str) -> None:
        """Set parts of the state to a value, if the condition holds."""
        for name in names if cond is not False else ():
            self.touched.add(name)
            self.state[name] = ite(cond, value, self.state[name])

    def note(self, cond: Any, fact: str, request: int, args: list[Any]) -> None:
        """Set a fact about a request, if the condition holds, and its `watched.N` that are true of the arguments."""
        self.put(cond, True, f"{fact}.{request}")
        for number, (watched, its, where) in enumerate(self.table.watched):
            if (watched, its) == (fact, request):
                self.put(conj(cond, where(args)), True, f"watched.{number}")

    def say(self, cond: Any, kind: str, request: int, args: list[Any], reason: int, slot: int = NONE) -> None:
        """Add an answer about a request with these arguments, if the condition holds, and set the facts of it."""
        if cond is not False:
            self.answers.append((cond, (kind, request, slot, reason)))
            self.put(cond, True, *([f"named.{reason}"] if reason >= 0 else []))
            self.note(cond, kind, request, args)

    def held(self, name: str, rows: list[Any]) -> Rows:
        """Return the values `NAME.K`, one for each record; `name`: `arg.SLOT`, `held.REQUEST` or `past.REQUEST`."""
        return Rows(self.state[f"{name}.{k}"] for k in range(len(rows)))

    def hold(self, cond: Any, name: str, values: list[Any]) -> None:
        """Set `NAME.K` to these values, if the condition holds."""
        for k, value in enumerate(values):
            self.put(cond, value, f"{name}.{k}")

    # ---- the vector and the diagrams ----

    def value(self, entry: int, loaded: dict[Any, Any]) -> Any:
        """Return the value of an entry of the vector; `loaded`: arguments, by request and number."""
        sources = self.table.counted.get(entry)
        return sum(self.source(each, loaded) for each in sources) if sources else self.table.entries[entry].initial

    def source(self, source: tuple[Any, ...], loaded: dict[Any, Any]) -> Any:
        """Return the value of one source of an entry."""
        match source:
            case "side", side:
                return self.state[side] if isinstance(side, str) else loaded[side]
            case "order", *sides:
                left, *rights = (self.state.get(side, loaded.get(side, side)) for side in sides)
                return sum(ite(left < right, 0, ite(left == right, 1, 2)) for right in rights)
            case "part", entry, factor:
                return factor * self.value(entry, loaded)
            case _, r, name, phase, where, predicate, weight:
                row = self.table.requests[r]
                values = self.held(where, row.params + row.results if name == where else row.params)
                there = conj(self.state[name] == phase, self.agrees(predicate, r, values))
                return ite(there, 1 if weight == NONE else values[weight], 0)

    def walk(self, root: int, codes: Collection[int], request: int = NONE, args: Sequence[Any] = ()) -> list[Any]:
        """Return the action nodes below a root, each with the condition that the path goes through it.

        Raises `Refused` for codes that are not in `codes`, and for REJECT, WAIT, CLEAR, SETTLE after another action.
        """
        loaded = {(request, k): value for k, value in enumerate(args)}
        ways: dict[int, tuple[Any, bool]] = {root: (True, False)} if root != NONE else {}
        found = []
        while ways:
            number = min(ways)
            (on, acted), node = ways.pop(number), self.table.nodes[number]
            if node.code < 0:
                if -node.code not in codes or (acted and -node.code <= t.SETTLE):
                    raise Refused(f"node {number} is no action that may stand there")
                found.append((node, on))
                then = [(node.low, True)]
            else:
                low = self.value(node.code, loaded) <= node.bound
                then = [(node.low, low), (node.high, neg(low))]
            for child, goes in then:
                if NONE != child <= number:
                    raise Refused(f"a child of node {number} does not come after it")
                if child != NONE and (more := conj(on, goes)) is not False:
                    known = ways.get(child, (False, False))
                    ways[child] = disj(known[0], more), known[1] or acted or node.code < 0
        return found

    def agrees(self, predicate: int, request: int = NONE, args: Sequence[Any] = ()) -> Any:
        """Return the condition that the diagram of a predicate leads to `AGREE`."""
        return predicate == t.ALWAYS or disj(*(on for _, on in self.walk(predicate, (t.AGREE,), request, args)))

    # ---- events ----

    def update(self, event: Event) -> Any:
        """Begin a step: clear the facts of the last, do what the event says, return the condition that it happens."""
        kind, number, outcome, values = event
        self.state |= {name: False for name in self.state if name.split(".")[0] in FORGOTTEN}
        there = f"{'place' if kind == 'give up' else 'phase'}.{number}"
        can = kind in ("ask", "observe", "level") or self.state[there] != IDLE
        self.put(kind in ("abort", "give up"), True, "abort")
        match kind:
            case "ask":
                self.note(True, "asked", number, values)
                self.decide(True, number, values, UNSAID)
            case "report":
                self.report(number, outcome, values)
            case "abort":
                self.kill(True, -1 - number, ABORTED)
            case "give up":
                self.vacate(True, number, ABORTED)
            case _:
                self.put(True, values[0], f"{'reading' if kind == 'observe' else kind}.{number}")
                self.latch(NONE)
        return can

    def report(self, slot: int, outcome: int, results: list[Any]) -> None:
        """End the instance in a slot: past, outcome, consumables that it produces, effects, latches."""
        request = self.table.owner[slot]
        row, ok = self.table.requests[request], outcome == 1
        args = self.held(f"arg.{slot}", row.params)
        self.note(True, "ended", request, args)
        self.state |= {f"phase.{slot}": IDLE, f"last.{request}": outcome}
        self.put(ok, True, f"past.{request}")
        self.hold(ok, f"past.{request}", args + results)
        self.supply(ok, request, args, row.produces, 1)
        self.affect(True, (row.on_ok, row.on_failed, row.on_interrupted)[outcome - 1])
        self.latch(request if ok else NONE)

    def supply(self, cond: Any, request: int, args: list[Any], amounts: Iterable[Any], sign: int) -> None:
        """Take (`sign` -1) or give (1) consumables, never above the capacity; a level below 0 is a `fault`."""
        for amount in amounts if cond is not False else ():
            level, capacity = f"level.{amount.stock}", self.table.stocks[amount.stock].capacity
            more = self.state[level] + sign * amount.amount
            counts = conj(cond, self.agrees(amount.predicate, request, args))
            self.put(counts, more if sign < 0 else ite(more > capacity, capacity, more), level)
            self.put(conj(counts, more < 0), True, "fault")

    def affect(self, cond: Any, effects: Iterable[Any]) -> None:
        """Apply effects, if the condition holds: set a variable, or forget a past."""
        for kind, target, value in effects:
            self.put(cond, *{0: (value, f"reading.{target}"), 1: (False, f"past.{target}")}[kind])

    def latch(self, reset: int) -> None:
        """Set and clear the latches, after a report `ok` of the request `reset`, or NONE."""
        for latch in self.table.latches:
            self.put((reset,) in latch.resets, 0, f"reading.{latch.variable}")
            self.put(self.agrees(latch.condition), 1, f"reading.{latch.variable}")

    def kill(self, cond: Any, target: int, reason: int) -> None:
        """Kill what runs in the slots of a request, or in slot s, given as -1 - s."""
        for slot in self.table.slots(target) if target >= 0 else [-1 - target]:
            request, runs = self.table.owner[slot], conj(cond, self.state[f"phase.{slot}"] == RUNNING)
            row = self.table.requests[request]
            self.put(runs, STOPPING, f"phase.{slot}")
            self.say(runs, "kill", request, self.held(f"arg.{slot}", row.params), reason, slot - row.slots)

    def empty(self, cond: Any, request: int) -> None:
        """Empty a waiting place, if the condition holds."""
        self.put(cond, EMPTY, f"place.{request}")
        self.put(cond, True, f"left.{request}")

    def vacate(self, cond: Any, request: int, reason: int) -> None:
        """Empty a waiting place and reject what stood there, if the condition holds."""
        self.empty(cond, request)
        self.supersede(cond, request, reason)

    def supersede(self, cond: Any, request: int, reason: int) -> None:
        """Answer that what stands in a waiting place is rejected, if the condition holds."""
        self.say(cond, "reject", request, self.held(f"held.{request}", self.table.requests[request].params), reason)

    # ---- decisions ----

    def decide(self, cond: Any, request: int, args: list[Any], reason: int, settling: bool = False) -> None:
        """Decide on a newcomer, if a reason is given for a launch rule; `settling`: anew on what stands waiting."""
        place, fallen, row = f"place.{request}", f"fallen.{request}", self.table.requests[request]
        before, taken = self.state[place], conj(cond, self.state[place] != EMPTY)
        if not settling and not row.interrupts_self:
            self.say(taken, "reject", request, args, BUSY)
            cond, taken = conj(cond, neg(taken)), False
        path = [(node, conj(cond, on)) for node, on in self.walk(row.decide, range(1, t.VIOLATION), request, args)]
        stands = [(node, on) for node, on in path if node.code in STANDS]
        quiet = neg(self.conflict(row))
        self.put(conj(cond, neg(disj(*(on for _, on in path)))), True, "fault")
        for node, on in path:
            if -node.code <= t.CLEAR and self.table.reasons[node.bound].denials + (node.code == -t.CLEAR) > 1:
                self.put(conj(on, quiet), True, "fault")  # only an active request of the bit row can have broken it
            if node.code == -t.REJECT:
                self.empty(conj(settling, on), request)
                self.say(on, "reject", request, args, node.bound)
        goes = conj(cond, neg(disj(*(on for node, on in path if node.code == -t.REJECT))))
        if settling:
            stays = disj(*(conj(on, node.code == -t.WAIT or self.state[fallen]) for node, on in stands))
            self.put(conj(stays, before == CLEARING), True, fallen)
            self.put(stays, WAITING, place)
            goes = conj(goes, neg(stays))
        else:
            self.put(goes, True, f"left.{request}")
            self.supersede(conj(taken, goes), request, SUPERSEDED)
        for node, on in path:
            self.act(conj(goes, on), node, request, args, reason)
        for node, on in stands if not settling else ():
            self.say(conj(goes, on), "wait", request, args, node.bound)

    def act(self, cond: Any, node: Any, request: int, args: list[Any], reason: int) -> None:
        """Do what an action node says, but for a rejection, which is answered already."""
        if node.code in STANDS:
            self.put(cond, WAITING if node.code == -t.WAIT else CLEARING, f"place.{request}")
            self.hold(cond, f"held.{request}", args)
        elif node.code == -t.KILL:
            self.kill(cond, node.high, node.bound)
        elif node.code == -t.DISMISS:
            self.vacate(conj(cond, self.state[f"place.{node.high}"] != EMPTY), node.high, node.bound)
        elif node.code == -t.LAUNCH:
            self.launch(cond, request, args, reason)

    def conflict(self, row: Any) -> Any:
        """Return the condition that a slot of a request in the bit row is active."""
        others = [16 * each.block + i for each in row.conflicts for i in range(16) if each.mask >> i & 1]
        return disj(*(self.state[f"phase.{s}"] != IDLE for other in others for s in self.table.slots(other)))

    def launch(self, cond: Any, request: int, args: list[Any], reason: int) -> None:
        """Let a newcomer take the lowest idle slot; the bit row must show no conflict."""
        row, free = self.table.requests[request], cond
        self.put(conj(cond, self.conflict(row)), True, "fault")
        self.empty(cond, request)
        for slot in self.table.slots(request):
            here = conj(free, self.state[f"phase.{slot}"] == IDLE)
            free = conj(free, neg(here))
            self.put(here, RUNNING, f"phase.{slot}")
            self.hold(here, f"arg.{slot}", args)
            self.say(here, "launch", request, args, reason, slot - row.slots)
        self.put(free, True, "fault")
        self.supply(cond, request, args, row.consumes, -1)
        self.affect(cond, row.on_launch)

    # ---- steps 3 to 5 ----

    def run(self, component: tuple[str, int]) -> None:
        """Run one part of a pass."""
        part, number = component
        if part == "rule":
            for node, on in self.walk(self.table.rules[number].root, (t.KILL, t.VIOLATION)):
                if node.code == -t.KILL:
                    self.kill(on, node.high, node.bound)
        elif part == "required launch":
            launch, words = self.table.launches[number], self.table.lists
            due = conj(neg(self.state[f"tried.{number}"]), self.agrees(launch.condition))
            self.put(due, True, f"tried.{number}")
            rows = enumerate(self.table.requests[launch.request].params, launch.args)
            args = [self.table.reals[words[at].word] if row.type == REAL else words[at].word for at, row in rows]
            self.decide(due, launch.request, args, launch.reason)
        else:
            args = self.held(f"held.{number}", self.table.requests[number].params)
            self.decide(self.state[f"place.{number}"] != EMPTY, number, args, UNSAID, settling=True)

    def broken(self, rule: Any) -> Any:
        """Return the condition that the diagram of a rule leads to a violation."""
        return disj(*(on for node, on in self.walk(rule.root, (t.KILL, t.VIOLATION)) if node.code == -t.VIOLATION))

    def said(self) -> list[list[Any]]:
        """Return the answers of a concrete step, violations last."""
        broken = dict.fromkeys(row.reason for row in self.table.rules if self.broken(row))
        return [list(each) for cond, each in self.answers if cond] + [["violation", NONE, NONE, n] for n in broken]
