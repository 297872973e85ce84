"""What one event does to the state of a table: concretely on numbers, or for all states at once on terms of Z3.

The state is a value for each name of `names`. A step updates it and notes *facts*: what it answered, and to whom.
Truths and numbers that are Python's are computed at once, so that a run needs no solver (docs/certificates.md).
"""

from collections.abc import Iterable, Iterator
from fractions import Fraction
from typing import Any

from exover.certificate import table as t
from exover.certificate.table import NONE, REAL, Refused, Table
from exover.certificate.term import compare, conj, disj, ite, neg, order, rank

IDLE, RUNNING, STOPPING = EMPTY, WAITING, CLEARING = range(3)
UNSAID, SUPERSEDED, ABORTED, BUSY = -1, -2, -3, 0
STANDS = (-t.WAIT, -t.CLEAR, -t.SETTLE)
Event = tuple[Any, ...]
Loaded = tuple[int, list[Any]] | None
"""A request and the arguments, with results or without, that tests of arguments are about."""


def layout(table: Table) -> Iterator[tuple[str, Any, Any, str]]:
    """Yield for each part of the state its name, its first value, its range (see `domain`) and what it belongs to."""

    def held(name: str, rows: list[Any], owner: str) -> Iterator[tuple[str, Any, Any, str]]:
        yield from ((f"{name}.{k}", Fraction(0) if row.type == REAL else 0, row, owner) for k, row in enumerate(rows))

    yield "start", True, None, ""
    for r, row in enumerate(table.requests):
        params, results = table.params[row.params : row.results], table.params[row.results : row.params_end]
        for slot in table.slots(r):
            yield f"phase.{slot}", IDLE, STOPPING, ""
            yield from held(f"arg.{slot}", params, f"phase.{slot}")
        yield f"place.{r}", EMPTY, CLEARING, ""
        yield from held(f"held.{r}", params, f"place.{r}")
        yield f"past.{r}", False, None, ""
        yield from held(f"past.{r}", params + results, f"past.{r}")
        yield from ((f"last.{r}", 0, 3, ""), (f"fallen.{r}", False, None, ""))
    for v, row in enumerate(table.variables):
        yield f"reading.{v}", table.reals[row.initial] if row.type == REAL else row.initial, row, ""
    yield from ((f"level.{k}", row.initial, row.capacity, "") for k, row in enumerate(table.stocks))
    yield from ((f"tried.{k}", False, None, "") for k in range(len(table.launches)))


def names(table: Table) -> dict[str, Any]:
    """Return by name of the state its first value: bools for truths, fractions for reals, else integers."""
    return {name: first for name, first, _, _ in layout(table)}


def domain(table: Table, row: Any, value: Any) -> list[Any]:
    """Return what it takes for a value to be in the range of a record, or from 0 to a number; None: it is a truth."""
    if row is None or isinstance(row, int):
        return [] if row is None else [value >= 0, value <= row]
    if row.type != REAL:
        return [value >= row.low, value <= row.high]
    low, high = table.reals[row.low], table.reals[row.high]
    parts = [disj(*compare(low, value))] if isinstance(low, Fraction) else []
    return parts + ([disj(*compare(value, high))] if isinstance(high, Fraction) else [])


class Step:
    """One step under way: the state as it is now, what was answered, and the facts that hold of the step so far."""

    def __init__(self, table: Table, state: dict[str, Any], facts: dict[str, Any] | None = None) -> None:
        self.table, self.state, self.facts = table, dict(state), dict(facts or {})
        self.answers: list[tuple[Any, tuple[Any, ...]]] = []

    def components(self) -> list[tuple[str, int]]:
        """Return the parts of a pass, in their order."""
        parts = {"recover": self.table.rules, "require": self.table.launches, "settle": self.table.requests}
        return [(part, number) for part, rows in parts.items() for number in range(len(rows))]

    # ---- small changes ----

    def put(self, name: str, cond: Any, value: Any) -> None:
        """Let a part of the state have this value, if the condition holds."""
        if cond is not False:
            self.state[name] = ite(cond, value, self.state[name])

    def note(self, cond: Any, *facts: str) -> None:
        """Note facts, if the condition holds."""
        for fact in facts if cond is not False else ():
            self.facts[fact] = disj(self.facts.get(fact, False), cond)

    def say(self, cond: Any, kind: str, request: int, slot: int, reason: int) -> None:
        """Answer, if the condition holds; what was answered is a fact."""
        if cond is not False:
            self.answers.append((cond, (kind, request, slot, reason)))
            self.note(cond, f"{kind}.{request}", *([f"named.{reason}"] if reason >= 0 else []))

    def held(self, name: str, request: int) -> list[Any]:
        """Return the arguments in `arg.SLOT` or `held.REQUEST`; with results, what `past.REQUEST` remembers."""
        row = self.table.requests[request]
        end = row.params_end if name.startswith("past") else row.results
        return [self.state[f"{name}.{k}"] for k in range(end - row.params)]

    def hold(self, name: str, cond: Any, values: list[Any]) -> None:
        """Let these be the arguments there, if the condition holds."""
        for k, value in enumerate(values):
            self.put(f"{name}.{k}", cond, value)

    # ---- the vector and the diagrams ----

    def value(self, entry: int, loaded: Loaded) -> Any:
        """Return the value of an entry of the vector."""
        sources = self.table.sources.get(entry)
        if sources is None:
            return self.table.entries[entry].initial
        return sum(self._source(source, loaded) for source in sources)

    def _source(self, source: tuple[Any, ...], loaded: Loaded) -> Any:
        match source:
            case ("side", side):
                return self._side(side, loaded)
            case ("rank", side, cuts):
                return rank(self._side(side, loaded), cuts)
            case ("order", left, right):
                return order(self._side(left, loaded), self._side(right, loaded))
            case ("part", entry, factor):
                return factor * self.value(entry, loaded)
            case ("past", r, predicate):
                there = self.state[f"past.{r}"]
                return ite(conj(there, self.agrees(predicate, (r, self.held(f"past.{r}", r)))), 1, 0)
            case (_, r, name, phase, where, feature):
                values = self.held(where, r)
                there = conj(self.state[name] == phase, self.agrees(feature.predicate, (r, values)))
                return ite(there, 1 if feature.weight == NONE else values[feature.weight], 0)

    def _side(self, side: Any, loaded: Loaded) -> Any:
        if isinstance(side, str):
            return self.state[side]
        if loaded is None or loaded[0] != side[0]:
            raise Refused("a diagram tests an argument of a request that it is not about")
        return loaded[1][side[1]]

    def walk(self, root: int, loaded: Loaded = None) -> list[tuple[Any, Any, Any]]:
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
            for child, also, still in then:
                if child != NONE and (more := conj(on, also)) is not False:
                    known = ways.get(child, (False, False))
                    ways[child] = (disj(known[0], more), disj(known[1], conj(first, still)))
        return found

    def agrees(self, predicate: int, loaded: Loaded) -> Any:
        """Return whether a predicate says `agree`."""
        if predicate == t.ALWAYS:
            return True
        return disj(*(on for node, on, _ in self.walk(predicate, loaded) if node.code == -t.AGREE))

    # ---- events ----

    def update(self, event: Event) -> Any:
        """Begin a step: nothing has happened in it; then do what the event says, and return whether it can happen."""
        self.state |= {name: False for name in self.state if name.startswith(("tried", "fallen", "start"))}
        self.facts = {}
        kind, number, outcome, values = event
        place = f"{'place' if kind == 'give up' else 'phase'}.{number}"
        there = True if kind in ("ask", "observe", "level") else self.state[place] != IDLE
        match kind:
            case "ask":
                self.note(True, f"asked.{number}")
                self.decide(True, number, values, UNSAID)
            case "report":
                self.report(number, outcome, values)
            case "abort":
                self.note(True, "abort")
                self.kill(True, [number], ABORTED)
            case "give up":
                self.note(True, "abort")
                self.vacate(True, number, ABORTED)
            case _:
                self.state[f"{'reading' if kind == 'observe' else kind}.{number}"] = values[0]
                self.latch(NONE)
        return there

    def report(self, slot: int, outcome: int, results: list[Any]) -> None:
        """End a slot: its past, what it gives, its effects, the latches."""
        request = self.table.owner(slot)
        row, args, ok = self.table.requests[request], self.held(f"arg.{slot}", request), outcome == 1
        self.note(True, f"ended.{request}")
        self.state |= {f"phase.{slot}": IDLE, f"last.{request}": outcome}
        if ok:
            self.put(f"past.{request}", True, True)
            self.hold(f"past.{request}", True, args + results)
            self.supply(True, request, args, self.table.amounts[row.produces : row.produces_end], 1)
        edges = (row.on_ok, row.on_failed, row.on_interrupted, row.effects_end)
        self.affect(True, edges[outcome - 1], edges[outcome])
        self.latch(request if ok else NONE)

    def supply(self, cond: Any, request: int, args: list[Any], amounts: Iterable[Any], sign: int) -> None:
        """Take or give what a launch or an ok does, never above the capacity."""
        for amount in amounts:
            level, capacity = f"level.{amount.stock}", self.table.stocks[amount.stock].capacity
            more = self.state[level] + sign * amount.amount
            counts = conj(cond, self.agrees(amount.predicate, (request, args)))
            self.put(level, counts, more if sign < 0 else ite(more > capacity, capacity, more))
            self.note(conj(counts, more < 0), "fault")

    def affect(self, cond: Any, start: int, end: int) -> None:
        """Apply effects: what a variable is set to, which past is forgotten."""
        for kind, target, value in self.table.effects[start:end]:
            self.put(*((f"reading.{target}", cond, value) if kind == 0 else (f"past.{target}", cond, False)))

    def latch(self, reset: int) -> None:
        """Set and clear the latches after a report ok of `reset`, or something else."""
        for latch in self.table.latches:
            resets = reset != NONE and (reset,) in self.table.lists[latch.resets : latch.resets_end]
            name = f"reading.{latch.variable}"
            self.state[name] = ite(self.agrees(latch.condition, None), 1, 0 if resets else self.state[name])

    def kill(self, cond: Any, slots: Iterable[int], reason: int) -> None:
        """Kill those of the slots that run."""
        for slot in slots:
            request, runs = self.table.owner(slot), conj(cond, self.state[f"phase.{slot}"] == RUNNING)
            self.put(f"phase.{slot}", runs, STOPPING)
            self.say(runs, "kill", request, slot - self.table.requests[request].slots, reason)

    def kill_target(self, cond: Any, node: Any) -> None:
        """Kill what an action node says: all slots of a request, or one of all."""
        self.kill(cond, self.table.slots(node.high) if node.high >= 0 else [-1 - node.high], node.bound)

    def vacate(self, cond: Any, request: int, reason: int) -> None:
        """Reject what stands in a waiting place."""
        self.put(f"place.{request}", cond, EMPTY)
        self.say(cond, "reject", request, NONE, reason)

    # ---- decisions ----

    def decide(self, cond: Any, request: int, args: list[Any], reason: int, settling: bool = False) -> None:
        """Decide on a newcomer, which a launch rule requires if there is a reason; or anew on what stands waiting."""
        place, row = f"place.{request}", self.table.requests[request]
        before, taken = self.state[place], conj(cond, self.state[place] != EMPTY)
        if not settling and not row.interrupts_self:
            self.say(taken, "reject", request, NONE, BUSY)
            cond, taken = conj(cond, neg(taken)), False
        path = self.walk(row.decide, (request, args))
        self.note(conj(cond, neg(disj(*(first for _, _, first in path)))), "fault")
        goes = conj(cond, neg(disj(*(first for node, _, first in path if node.code == -t.REJECT))))
        for node, _, first in path:
            if node.code == -t.REJECT:
                self.put(place, settling and conj(cond, first), EMPTY)
                self.say(conj(cond, first), "reject", request, NONE, node.bound)
        if settling:
            fallen = self.state[f"fallen.{request}"]
            standing = [(node.code, first) for node, _, first in path if node.code in STANDS]
            stays = conj(goes, disj(*(first if code == -t.WAIT else conj(first, fallen) for code, first in standing)))
            self.put(f"fallen.{request}", conj(stays, before == CLEARING), True)
            self.put(place, stays, WAITING)
            goes = conj(goes, neg(stays))
        else:
            self.say(conj(taken, goes), "reject", request, NONE, SUPERSEDED)
        for node, on, _ in path:
            self.act(conj(goes, on), node, request, args, reason)
        for node, on, _ in path if not settling else ():
            if node.code in STANDS:
                self.say(conj(goes, on), "wait", request, NONE, node.bound)

    def act(self, cond: Any, node: Any, request: int, args: list[Any], reason: int) -> None:
        """Do what an action node says, which is no rejection."""
        if node.code in STANDS:
            self.put(f"place.{request}", cond, WAITING if node.code == -t.WAIT else CLEARING)
            self.hold(f"held.{request}", cond, args)
        elif node.code == -t.KILL:
            self.kill_target(cond, node)
        elif node.code == -t.DISMISS:
            self.vacate(conj(cond, self.state[f"place.{node.high}"] != EMPTY), node.high, node.bound)
        elif node.code == -t.LAUNCH:
            self.launch(cond, request, args, reason)
        else:
            self.note(conj(cond, node.code != -t.REJECT), "fault")

    def launch(self, cond: Any, request: int, args: list[Any], reason: int) -> None:
        """Let a newcomer take the lowest idle slot; the bit row must show no conflict."""
        row, free = self.table.requests[request], cond
        others = [slot for n in self.table.conflicts_of(request) for slot in self.table.slots(n)]
        self.note(conj(cond, disj(*(self.state[f"phase.{slot}"] != IDLE for slot in others))), "fault")
        self.put(f"place.{request}", cond, EMPTY)
        for slot in self.table.slots(request):
            here = conj(free, self.state[f"phase.{slot}"] == IDLE)
            free = conj(free, neg(here))
            self.put(f"phase.{slot}", here, RUNNING)
            self.hold(f"arg.{slot}", here, args)
            self.say(here, "launch", request, slot - row.slots, reason)
        self.note(free, "fault")
        self.supply(cond, request, args, self.table.amounts[row.consumes : row.produces], -1)
        self.affect(cond, row.on_launch, row.on_ok)

    # ---- steps 3 to 5 ----

    def run(self, component: tuple[str, int]) -> None:
        """Run one part of a pass."""
        part, number = component
        if part == "recover":
            for node, on, _ in self.walk(self.table.rules[number].root):
                if node.code == -t.KILL:
                    self.kill_target(on, node)
        elif part == "require":
            launch = self.table.launches[number]
            due = conj(neg(self.state[f"tried.{number}"]), self.agrees(launch.condition, None))
            self.put(f"tried.{number}", due, True)
            row = self.table.requests[launch.request]
            words = zip(self.table.params[row.params : row.results], self.table.lists[launch.args :], strict=False)
            args = [self.table.reals[word] if param.type == REAL else word for param, (word,) in words]
            self.decide(due, launch.request, args, launch.reason)
        else:
            there = self.state[f"place.{number}"] != EMPTY
            self.decide(there, number, self.held(f"held.{number}", number), UNSAID, settling=True)


def step(
    table: Table, state: dict[str, Any], event: Event
) -> tuple[dict[str, Any], dict[str, Any], list[tuple[Any, ...]]]:
    """Return the state, the facts and the answers after an event, all concrete."""
    now = Step(table, state)
    if now.update(event) is not True:
        raise Refused(f"the event {event!r} cannot happen where the run is")
    for _ in range(table.limits[0].passes):
        before = dict(now.state)
        for component in now.components():
            now.run(component)
        if now.state == before:
            break
    else:
        raise Refused("a step does not end within the passes that the table allows")
    ends = [(rule.reason, node, on) for rule in table.rules for node, on, _ in now.walk(rule.root)]
    broken = dict.fromkeys(reason for reason, node, on in ends if on and node.code == -t.VIOLATION)
    violations = [("violation", NONE, NONE, reason) for reason in broken]
    return now.state, now.facts, [answer for cond, answer in now.answers if cond is True] + violations
