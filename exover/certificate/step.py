"""What one event does to the state of a table: concretely on numbers, or for all states at once on terms of Z3.

The state is a value for each name of `names`. A step updates it and notes *facts*: what it answered, and to whom.
Truths and numbers that are Python's are computed at once, so that a run needs no solver (docs/certificates.md).
"""

from collections.abc import Iterable, Iterator
from fractions import Fraction
from typing import Any

from exover.certificate.table import (
    AGREE,
    ALWAYS,
    CLEAR,
    DISMISS,
    KILL,
    LAUNCH,
    NONE,
    REAL,
    REJECT,
    SETTLE,
    VIOLATION,
    WAIT,
    Refused,
    Table,
)
from exover.certificate.term import compare, conj, disj, ite, neg, order, rank

IDLE, RUNNING, STOPPING = EMPTY, WAITING, CLEARING = range(3)
UNSAID, SUPERSEDED, ABORTED, BUSY = -1, -2, -3, 0
OUTCOMES = ("none", "ok", "failed", "interrupted")
Event = tuple[Any, ...]
Loaded = tuple[int, list[Any]] | None
"""A request and the arguments, with results or without, that tests of arguments are about."""


def names(table: Table) -> dict[str, Any]:
    """Return by name of the state its first value: bools for truths, fractions for reals, else integers."""
    found: dict[str, Any] = {"start": True}
    for r, row in enumerate(table.requests):
        kept = [zero(table.params[k].type) for k in range(row.params, row.params_end)]
        arity = row.results - row.params
        for slot in table.slots(r):
            found |= {f"phase.{slot}": IDLE} | {f"arg.{slot}.{k}": value for k, value in enumerate(kept[:arity])}
        found |= {f"place.{r}": EMPTY} | {f"held.{r}.{k}": value for k, value in enumerate(kept[:arity])}
        found |= {f"past.{r}": False, f"last.{r}": 0} | {f"past.{r}.{k}": value for k, value in enumerate(kept)}
        found[f"fallen.{r}"] = False
    for v, row in enumerate(table.variables):
        found[f"reading.{v}"] = table.reals[row.initial] if row.type == REAL else row.initial
    found |= {f"level.{k}": row.initial for k, row in enumerate(table.stocks)}
    return found | {f"tried.{k}": False for k in range(len(table.launches))}


def zero(kind: int) -> Any:
    """Return a value of a type, for where nothing is held."""
    return Fraction(0) if kind == REAL else 0


def domain(table: Table, row: Any, value: Any) -> list[Any]:
    """Return what it takes for a value to be in the range of a parameter, result or variable."""
    if row.type != REAL:
        return [row.low <= value, value <= row.high]
    bounds = [table.reals[row.low], table.reals[row.high]]
    parts = [disj(*compare(bounds[0], value))] if isinstance(bounds[0], Fraction) else []
    return parts + ([disj(*compare(value, bounds[1]))] if isinstance(bounds[1], Fraction) else [])


class Step:
    """One step under way: the state as it is now, what was answered, and the facts that hold of the step so far."""

    def __init__(self, table: Table, state: dict[str, Any], facts: dict[str, Any] | None = None) -> None:
        self.table, self.state, self.facts = table, dict(state), dict(facts or {})
        self.answers: list[tuple[Any, tuple[Any, ...]]] = []

    def fork(self) -> "Step":
        """Return a step that goes on from here by itself."""
        return Step(self.table, self.state, self.facts)

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
        """Return the arguments in `arg.SLOT` or `held.REQUEST`."""
        row = self.table.requests[request]
        return [self.state[f"{name}.{k}"] for k in range(row.results - row.params)]

    # ---- the vector and the diagrams ----

    def value(self, entry: int, loaded: Loaded) -> Any:
        """Return the value of an entry of the vector."""
        found = self.table.sources.get(entry)
        if found is None:
            return self.table.entries[entry].initial
        total: Any = 0
        for source in found:
            total = total + self._source(source, loaded)
        return total

    def _source(self, source: tuple[Any, ...], loaded: Loaded) -> Any:
        state = self.state
        match source:
            case ("reading" | "level" | "last" as kind, number):
                return state[f"{kind}.{number}"]
            case ("rank", number, cuts):
                return rank(state[f"reading.{number}"], cuts)
            case ("pair", left, right):
                return order(state[f"reading.{-1 - left}"], state[f"reading.{-1 - right}"])
            case ("part", entry, factor):
                return factor * self.value(entry, loaded)
            case ("past", request, predicate):
                row = self.table.requests[request]
                values = [state[f"past.{request}.{k}"] for k in range(row.params_end - row.params)]
                return ite(conj(state[f"past.{request}"], self.agrees(predicate, (request, values))), 1, 0)
            case ("count", request, name, phase, feature, slot):
                values = self.held(f"held.{request}" if slot == NONE else f"arg.{slot}", request)
                there = conj(state[name] == phase, self.agrees(feature.predicate, (request, values)))
                return ite(there, 1 if feature.weight == NONE else values[feature.weight], 0)
        if loaded is None or loaded[0] != source[1]:
            raise Refused("a diagram tests an argument of a request that it is not about")
        match source:
            case ("arg", _, k):
                return loaded[1][k]
            case ("argrank", _, k, cuts):
                return rank(loaded[1][k], cuts)
            case (_, _, left, right):
                sides = [loaded[1][k] if k >= 0 else state[f"reading.{-1 - k}"] for k in (left, right)]
                return order(*sides)
        raise AssertionError(source)

    def walk(self, root: int, loaded: Loaded = None) -> Iterator[tuple[Any, Any, Any]]:
        """Yield the action nodes below a root: each with when the path goes through it, and when as its first."""
        ways: dict[int, tuple[Any, Any]] = {root: (True, True)} if root != NONE else {}
        while ways:
            number = min(ways)
            on, first = ways.pop(number)
            node = self.table.nodes[number]
            if node.code < 0:
                yield node, on, first
                then = [(node.low, True, False)]
            else:
                low = self.value(node.code, loaded) <= node.bound
                then = [(node.low, low, low), (node.high, neg(low), neg(low))]
            for child, also, still in then:
                if child != NONE and (more := conj(on, also)) is not False:
                    known = ways.get(child, (False, False))
                    ways[child] = (disj(known[0], more), disj(known[1], conj(first, still)))

    def agrees(self, predicate: int, loaded: Loaded) -> Any:
        """Return whether a predicate says `agree`."""
        return predicate == ALWAYS or disj(*(on for node, on, _ in self.walk(predicate, loaded) if node.code == -AGREE))

    # ---- events: each returns whether it can happen ----

    def update(self, event: Event) -> Any:
        """Begin a step: nothing has happened in it; then do what the event says, and return whether it can happen."""
        for name in self.state:
            if name.startswith(("tried", "fallen")) or name == "start":
                self.state[name] = False
        self.facts = {}
        kind, number, outcome, values = event
        if kind == "ask":
            self.note(True, f"asked.{number}")
            self.ask(True, number, values, UNSAID)
        elif kind in ("observe", "level"):
            self.state[f"{'reading' if kind == 'observe' else kind}.{number}"] = values[0]
            self.latch(NONE)
        elif kind == "report":
            active = self.state[f"phase.{number}"] != IDLE
            self.report(number, outcome, values)
            return active
        elif kind == "abort":
            active = self.state[f"phase.{number}"] != IDLE
            self.note(True, "abort")
            self.kill(True, number, ABORTED)
            return active
        else:
            taken = self.state[f"place.{number}"] != EMPTY
            self.note(True, "abort")
            self.vacate(True, number, ABORTED)
            return taken
        return True

    def report(self, slot: int, outcome: int, results: list[Any]) -> None:
        """End a slot: its past, what it gives, its effects, the latches."""
        request = self.table.owner(slot)
        row, args, ok = self.table.requests[request], self.held(f"arg.{slot}", request), outcome == 1
        self.note(True, f"ended.{request}")
        self.state |= {f"phase.{slot}": IDLE, f"last.{request}": outcome}
        if ok:
            self.state |= {f"past.{request}": True}
            self.state |= {f"past.{request}.{k}": value for k, value in enumerate([*args, *results])}
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
        """Apply effects."""
        for effect in self.table.effects[start:end]:
            if effect.kind == 0:
                self.put(f"reading.{effect.target}", cond, effect.value)
            else:
                self.put(f"past.{effect.target}", cond, False)

    def latch(self, reset: int) -> None:
        """Set and clear the latches after a report ok of `reset`, or something else."""
        for latch in self.table.latches:
            resets = any(word.word == reset for word in self.table.lists[latch.resets : latch.resets_end])
            name, due = f"reading.{latch.variable}", self.agrees(latch.condition, None)
            self.state[name] = ite(due, 1, 0 if resets and reset != NONE else self.state[name])

    def kill(self, cond: Any, slot: int, reason: int) -> None:
        """Kill a slot that runs."""
        request, runs = self.table.owner(slot), conj(cond, self.state[f"phase.{slot}"] == RUNNING)
        self.put(f"phase.{slot}", runs, STOPPING)
        self.say(runs, "kill", request, slot - self.table.requests[request].slots, reason)

    def vacate(self, cond: Any, request: int, reason: int) -> None:
        """Reject what stands in a waiting place."""
        self.put(f"place.{request}", cond, EMPTY)
        self.say(cond, "reject", request, NONE, reason)

    # ---- decisions ----

    def ask(self, cond: Any, request: int, args: list[Any], reason: int) -> None:
        """Decide on a newcomer, which a launch rule requires if there is a reason."""
        taken = conj(cond, self.state[f"place.{request}"] != EMPTY)
        if not self.table.requests[request].interrupts_self:
            self.say(taken, "reject", request, NONE, BUSY)
            cond, taken = conj(cond, neg(taken)), False
        path = list(self.walk(self.table.requests[request].decide, (request, args)))
        refused = conj(cond, disj(*(first for node, _, first in path if node.code == -REJECT)))
        for node, _, first in path:
            if node.code == -REJECT:
                self.say(conj(cond, first), "reject", request, NONE, node.bound)
        self.say(conj(taken, neg(refused)), "reject", request, NONE, SUPERSEDED)
        self.carry_out(conj(cond, neg(refused)), request, args, path, reason, settling=False)

    def carry_out(self, cond: Any, request: int, args: list[Any], path: Any, reason: int, settling: bool) -> None:
        """Do what a path says, which is no rejection."""
        self.note(conj(cond, neg(disj(*(first for _, _, first in path)))), "fault")
        for node, on, _ in path:
            here, code = conj(cond, on), -node.code
            if code in (WAIT, CLEAR, SETTLE):
                self.stand(here, request, args, WAITING if code == WAIT else CLEARING)
            elif code == KILL:
                self.kill_target(here, node)
            elif code == DISMISS:
                self.vacate(conj(here, self.state[f"place.{node.high}"] != EMPTY), node.high, node.bound)
            elif code == LAUNCH:
                self.launch(here, request, args, reason)
            else:
                self.note(conj(here, code != REJECT), "fault")
        for node, on, _ in path if not settling else ():
            if -node.code in (WAIT, CLEAR, SETTLE):
                self.say(conj(cond, on), "wait", request, NONE, node.bound)

    def stand(self, cond: Any, request: int, args: list[Any], phase: int) -> None:
        """Let something stand in the waiting place."""
        self.put(f"place.{request}", cond, phase)
        for k, value in enumerate(args):
            self.put(f"held.{request}.{k}", cond, value)

    def kill_target(self, cond: Any, node: Any) -> None:
        """Kill what an action node says: all slots of a request, or one of all."""
        for slot in self.table.slots(node.high) if node.high >= 0 else [-1 - node.high]:
            self.kill(cond, slot, node.bound)

    def launch(self, cond: Any, request: int, args: list[Any], reason: int) -> None:
        """Let a newcomer take the lowest idle slot; the bit row must show no conflict."""
        row, free = self.table.requests[request], cond
        active = [
            self.state[f"phase.{slot}"] != IDLE
            for n in self.table.conflicts_of(request)
            for slot in self.table.slots(n)
        ]
        self.put(f"place.{request}", cond, EMPTY)
        for slot in self.table.slots(request):
            here = conj(free, self.state[f"phase.{slot}"] == IDLE)
            free = conj(free, neg(here))
            self.put(f"phase.{slot}", here, RUNNING)
            for k, value in enumerate(args):
                self.put(f"arg.{slot}.{k}", here, value)
            self.say(here, "launch", request, slot - row.slots, reason)
        self.note(disj(free, conj(cond, disj(*active))), "fault")
        self.supply(cond, request, args, self.table.amounts[row.consumes : row.produces], -1)
        self.affect(cond, row.on_launch, row.on_ok)

    # ---- steps 3 to 5 ----

    def run(self, component: tuple[str, int]) -> None:
        """Run one part of a pass."""
        part, number = component
        if part == "recover":
            for node, on, _ in list(self.walk(self.table.rules[number].root)):
                if node.code == -KILL:
                    self.kill_target(on, node)
        elif part == "require":
            row = self.table.launches[number]
            due = conj(neg(self.state[f"tried.{number}"]), self.agrees(row.condition, None))
            self.put(f"tried.{number}", due, True)
            self.ask(due, row.request, self.required(number), row.reason)
        else:
            self.settle(number)

    def required(self, number: int) -> list[Any]:
        """Return the arguments of a required launch."""
        launch = self.table.launches[number]
        row = self.table.requests[launch.request]
        kinds = [param.type for param in self.table.params[row.params : row.results]]
        words = [word.word for word in self.table.lists[launch.args : launch.args + len(kinds)]]
        return [self.table.reals[word] if kind == REAL else word for kind, word in zip(kinds, words, strict=True)]

    def settle(self, request: int) -> None:
        """Decide again on what stands in a waiting place."""
        place, fallen = self.state[f"place.{request}"], self.state[f"fallen.{request}"]
        there, args = place != EMPTY, self.held(f"held.{request}", request)
        path = list(self.walk(self.table.requests[request].decide, (request, args)))
        stays: Any = False
        for node, _, first in path:
            here = conj(there, first)
            if node.code == -REJECT:
                self.vacate(here, request, node.bound)
                there = conj(there, neg(first))
            elif node.code not in (-LAUNCH, -DISMISS):
                stays = disj(stays, here if node.code == -WAIT else conj(here, fallen))
        self.put(f"fallen.{request}", conj(stays, place == CLEARING), True)
        self.put(f"place.{request}", stays, WAITING)
        self.carry_out(conj(there, neg(stays)), request, args, path, UNSAID, settling=True)

    def broken(self) -> Iterator[tuple[Any, int]]:
        """Yield the reasons of the rules that could not be restored, with when that is so."""
        for rule in self.table.rules:
            yield disj(*(on for node, on, _ in self.walk(rule.root) if node.code == -VIOLATION)), rule.reason


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
    named = dict.fromkeys(reason for cond, reason in now.broken() if cond)
    answers = [answer for cond, answer in now.answers if cond is True]
    return now.state, now.facts, answers + [("violation", NONE, NONE, reason) for reason in named]
