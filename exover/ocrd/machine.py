"""The packed tables at work: a walker in Python, step for step what the C runtime does (docs/runtime.md).

It reads the decoded tables alone; the model is asked only for names. Answers are those of the reference interpreter.
"""

from dataclasses import dataclass, field
from typing import assert_never

from exover.model.decision import BUSY, Reason
from exover.model.event import (
    Abort,
    AbortWaiting,
    Action,
    Args,
    Ask,
    Event,
    Invalid,
    Killed,
    Launched,
    Observe,
    Rejected,
    Report,
    Violated,
    Waits,
)
from exover.model.model import Model
from exover.model.types import Value, from_ordinal, ordinal
from exover.ocrd import tables as t
from exover.ocrd.entries import compare
from exover.ocrd.reasons import reasons
from exover.ocrd.tables import NONE, Node, RequestRow, Tables
from exover.ocrd.vector import OUTCOMES, rank

IDLE, RUNNING, STOPPING = range(3)
EMPTY, WAITING, CLEARING = range(3)


@dataclass
class Machine:
    """A checker that runs: the state vector, what the slots and places hold, and what it remembers within a step."""

    model: Model
    tables: Tables
    vector: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.reasons = reasons(self.model)
        self.index = {request.name: number for number, request in enumerate(self.model.requests)}
        names = [v.name for v in self.model.variables] + [latch.name for latch in self.model.latches]
        self.variable = {name: number for number, name in enumerate(names)}
        self.stock = {r.name: k for k, r in enumerate(r for r in self.model.resources if r.consumable)}
        self.slots = sum(request.instances for request in self.tables.requests)
        self.initial = [entry.initial for entry in self.tables.entries]
        self.conflicts = [self._conflicts(row) for row in self.tables.requests]
        self.restart()

    def _conflicts(self, row: RequestRow) -> frozenset[int]:
        """Return the requests in the bit row of a request."""
        blocks = self.tables.conflicts[row.conflicts : row.conflicts_end]
        bits = range(t.BLOCK)
        return frozenset(t.BLOCK * block.block + bit for block in blocks for bit in bits if block.mask >> bit & 1)

    def restart(self) -> None:
        """Begin anew, in the initial state."""
        tables = self.tables
        self.vector = list(self.initial)
        self.phase = [IDLE] * self.slots
        self.held = [0] * len(tables.requests)
        self.slot_args: list[Args] = [()] * self.slots
        self.place = [EMPTY] * len(tables.requests)
        self.place_args: list[Args] = [()] * len(tables.requests)
        self.raw = {v.raw: tables.reals[v.initial] for v in tables.variables if v.raw != NONE}
        self.broken = [False] * len(tables.rules)
        self.dirty = [True] * len(tables.rules)
        self.actions: list[Action] = []
        self.changed = False

    def step(self, event: Event) -> tuple[Action, ...]:
        """Return the actions that answer the event."""
        self.actions = []
        fault = self._validate(event)
        if fault:
            return (fault,)
        self.tried = [False] * len(self.tables.launches)
        self.fallen = [False] * len(self.tables.requests)
        self._update(event)
        for _ in range(self.tables.limits[0].passes):
            self.changed = False
            self._recover()
            self._launch_required()
            self._settle()
            if not self.changed:
                break
        else:
            raise AssertionError("the bound on passes is wrong")
        self._violations()
        return tuple(self.actions)

    # ---- the vector ----

    def _add(self, entry: int, delta: int) -> None:
        if entry == NONE or not delta:
            return
        row = self.tables.entries[entry]
        self.vector[entry] += delta
        for rule in self.tables.lists[row.rules : row.rules_end]:
            self.dirty[rule] = True
        for other, factor in self.tables.sums[row.sums : row.sums_end]:
            self._add(other, factor * delta)

    def _put(self, entry: int, value: int) -> None:
        if entry != NONE:
            self._add(entry, value - self.vector[entry])

    def _walk(self, node: int) -> list[Node]:
        """Return the action nodes on the path that the vector takes from `node`."""
        found = []
        while node != NONE:
            here = self.tables.nodes[node]
            if here.code < 0:
                found.append(here)
                node = here.low
            else:
                node = here.low if self.vector[here.code] <= here.bound else here.high
        return found

    def _agrees(self, predicate: int) -> bool:
        return predicate == t.ALWAYS or bool(self._walk(predicate))

    # ---- arguments ----

    def _load(self, request: int, values: Args) -> None:
        """Put arguments, and results if there are any, into the entries that tests of them read."""
        row = self.tables.requests[request]
        for number, value in enumerate(values):
            param = self.tables.params[row.params + number]
            if param.type == t.REAL:
                self._put(param.rank, rank(self.tables.reals[param.cuts : param.cuts_end], float(value)))
            else:
                self._put(param.value, self._number(request, number, value))
        for order in self.tables.orders[row.orders : row.orders_end]:
            if order.left < len(values) and order.right < len(values):
                self._put(order.entry, compare(self._side(order.left, values), self._side(order.right, values)))

    def _number(self, request: int, number: int, value: Value) -> int:
        params = (*self.model.requests[request].params, *self.model.requests[request].results)
        return ordinal(params[number].type, value)

    def _side(self, side: int, values: Args) -> float:
        return float(values[side]) if side >= 0 else self.raw[self.tables.variables[-1 - side].raw]

    def _count(self, request: int, args: Args, slot: int, phase: str, sign: int) -> None:
        """Count what holds `args` in (or, sign -1, out of) every feature of its request."""
        row = self.tables.requests[request]
        features = self.tables.features[row.features : row.features_end]
        if any(feature.predicate != t.ALWAYS or feature.weight != NONE for feature in features):
            self._load(request, args)
        for feature in features:
            if feature.slot in (NONE, slot) and self._agrees(feature.predicate):
                weight = 1 if feature.weight == NONE else self._number(request, feature.weight, args[feature.weight])
                self._add(getattr(feature, phase), sign * weight)

    def _set_slot(self, request: int, slot: int, phase: int, args: Args) -> None:
        number = self.tables.requests[request].slots + slot
        names = {RUNNING: "running", STOPPING: "stopping"}
        if self.phase[number] != IDLE:
            self._count(request, self.slot_args[number], slot, names[self.phase[number]], -1)
        self.phase[number], self.slot_args[number] = phase, args
        if phase != IDLE:
            self._count(request, args, slot, names[phase], 1)
        self.changed = True

    def _set_place(self, request: int, phase: int, args: Args) -> None:
        if self.place[request] == phase and self.place_args[request] == args:
            return
        names = {WAITING: "waiting", CLEARING: "clearing"}
        if self.place[request] != EMPTY:
            self._count(request, self.place_args[request], NONE, names[self.place[request]], -1)
        self.place[request], self.place_args[request] = phase, args
        if phase != EMPTY:
            self._count(request, args, NONE, names[phase], 1)
        self.changed = True

    def _read(self, variable: int, value: Value) -> None:
        """Let a poster, state or latch read `value`."""
        row = self.tables.variables[variable]
        held = [
            (request, slot, {RUNNING: "running", STOPPING: "stopping"}[self.phase[number]], self.slot_args[number])
            for request in self.tables.lists[row.refresh : row.refresh_end]
            for slot in range(self.tables.requests[request].instances)
            if self.phase[number := self.tables.requests[request].slots + slot] != IDLE
        ]
        for request, slot, phase, args in held:
            self._count(request, args, slot, phase, -1)
        if row.type == t.REAL:
            self._put(row.rank, rank(self.tables.reals[row.cuts : row.cuts_end], float(value)))
            if row.raw != NONE:
                self.raw[row.raw] = float(value)
        else:
            kind = self.model.variables[variable].type if variable < len(self.model.variables) else None
            self._put(row.value, ordinal(kind, value) if kind else int(value))
        for order in self.tables.orders[row.orders : row.orders_end]:
            self._put(order.entry, compare(self._side(order.left, ()), self._side(order.right, ())))
        for request, slot, phase, args in held:
            self._count(request, args, slot, phase, 1)

    # ---- the step ----

    def _validate(self, event: Event) -> Invalid | None:
        match event:
            case Report(name, slot) if self.phase[self.tables.requests[self.index[name]].slots + slot] == IDLE:
                return Invalid("not-active", f"slot {slot} of {name} is idle")
            case Abort(name, slot) if self.phase[self.tables.requests[self.index[name]].slots + slot] == IDLE:
                return Invalid("nothing-to-abort", f"slot {slot} of {name} is idle")
            case AbortWaiting(name) if self.place[self.index[name]] == EMPTY:
                return Invalid("nothing-to-abort", f"nothing waits at {name}")
            case _:
                return None

    def _update(self, event: Event) -> None:
        match event:
            case Ask(name, args):
                self._ask(self.index[name], args, None)
            case Report():
                self._end(event)
            case Observe(name, value, broken):
                if broken:
                    self.actions.append(Invalid("out-of-range", f"taken as {value}"))
                if name in self.stock:
                    self._put(self.tables.stocks[self.stock[name]].entry, int(value))
                else:
                    self._read(self.variable[name], value)
                self._latch(NONE)
            case Abort(name, slot):
                self._kill(self.index[name], slot, Reason("abort"))
            case AbortWaiting(name):
                self._set_place(self.index[name], EMPTY, ())
                self.actions.append(Rejected(name, "aborted"))
            case _:
                assert_never(event)

    def _decide(self, request: int, args: Args) -> list[Node]:
        """Return the path of the decision; the second channel must agree where it can tell."""
        self._load(request, args)
        path = self._walk(self.tables.requests[request].decide)
        first = path[0]
        if -first.code in (t.REJECT, t.WAIT, t.CLEAR):
            denials = self.tables.reasons[first.bound].denials
            if denials == t.ALL_DENIALS or (denials == t.CLEARINGS and first.code == -t.CLEAR):
                assert self._in_conflict(request), "only the diagrams see a conflict"
        return path

    def _in_conflict(self, request: int) -> bool:
        return any(self.held[other] for other in self.conflicts[request])

    def _ask(self, request: int, args: Args, required: Reason | None) -> None:
        row, name = self.tables.requests[request], self.model.requests[request].name
        taken = self.place[request] != EMPTY
        if taken and not row.interrupts_self:
            self.actions.append(Rejected(name, BUSY.rule))
            return
        path = self._decide(request, args)
        if path[0].code == -t.REJECT:
            reason = self.reasons[path[0].bound]
            self.actions.append(Rejected(name, reason.rule, reason.because))
            return
        if taken:
            self.actions.append(Rejected(name, "superseded"))
        waits = self._carry_out(request, args, path, required)
        if waits:
            self.actions.append(Waits(name, waits.rule, waits.because))

    def _carry_out(self, request: int, args: Args, path: list[Node], required: Reason | None) -> Reason | None:
        """Do what the path of a decision says, that is no rejection; return what the newcomer waits for, if it does."""
        waits = None
        for node in path:
            reason = self.reasons[node.bound]
            match -node.code:
                case t.WAIT | t.CLEAR | t.SETTLE:
                    waits = reason
                    self._set_place(request, WAITING if node.code == -t.WAIT else CLEARING, args)
                case t.KILL:
                    self._kill_target(node, reason)
                case t.DISMISS:
                    if self.place[node.high] != EMPTY:
                        self._set_place(node.high, EMPTY, ())
                        dismissed = self.model.requests[node.high].name
                        self.actions.append(Rejected(dismissed, reason.rule, reason.because))
                case t.LAUNCH:
                    self._launch(request, args, required)
        return waits

    def _launch(self, request: int, args: Args, required: Reason | None) -> None:
        row = self.tables.requests[request]
        slot = self.phase[row.slots : row.slots + row.instances].index(IDLE)
        assert not self._in_conflict(request), "only the bit rows see a conflict"
        self.held[request] += 1
        self._set_place(request, EMPTY, ())
        for amount in self._counting(request, args, row.consumes, row.produces):
            self._add(self.tables.stocks[amount.stock].entry, -amount.amount)
        self._set_slot(request, slot, RUNNING, args)
        self._affect(row.on_launch, row.on_ok)
        why = (required.rule, required.because) if required else (None, None)
        self.actions.append(Launched(self.model.requests[request].name, slot, args, *why))

    def _counting(self, request: int, args: Args, start: int, end: int) -> list[t.AmountRow]:
        amounts = self.tables.amounts[start:end]
        if amounts:
            self._load(request, args)
        return [amount for amount in amounts if self._agrees(amount.predicate)]

    def _affect(self, start: int, end: int) -> None:
        for effect in self.tables.effects[start:end]:
            if effect.kind == t.SET:
                kind = self.model.variables[effect.target].type
                self._read(effect.target, from_ordinal(kind, effect.value))
            else:
                self._set_past(self.tables.requests[effect.target], known=False)

    def _set_past(self, row: RequestRow, known: bool) -> None:
        for past in self.tables.pasts[row.pasts : row.pasts_end]:
            self._put(past.entry, int(known and self._agrees(past.predicate)))

    def _end(self, report: Report) -> None:
        request = self.index[report.request]
        row = self.tables.requests[request]
        args = self.slot_args[row.slots + report.slot]
        self._set_slot(request, report.slot, IDLE, ())
        self.held[request] -= 1
        self._put(row.last, OUTCOMES.index(report.outcome))
        cleared_by = NONE
        if report.outcome == "ok":
            cleared_by = request
            self._load(request, args + report.results)
            self._set_past(row, known=True)
            for amount in self._counting(request, args, row.produces, row.produces_end):
                stock = self.tables.stocks[amount.stock]
                if stock.entry != NONE:
                    self._put(stock.entry, min(stock.capacity, self.vector[stock.entry] + amount.amount))
        edges = {"ok": (row.on_ok, row.on_failed), "failed": (row.on_failed, row.on_interrupted)}
        edges["interrupted"] = (row.on_interrupted, row.effects_end)
        self._affect(*edges[report.outcome])
        self._latch(cleared_by)

    def _latch(self, cleared_by: int) -> None:
        for latch in self.tables.latches:
            if self._agrees(latch.condition):
                self._read(latch.variable, True)
            elif cleared_by in self.tables.lists[latch.resets : latch.resets_end]:
                self._read(latch.variable, False)

    def _kill_target(self, node: Node, reason: Reason) -> None:
        if node.high >= 0:
            for slot in range(self.tables.requests[node.high].instances):
                self._kill(node.high, slot, reason)
            return
        number = -1 - node.high
        request = max(k for k, row in enumerate(self.tables.requests) if row.slots <= number)
        self._kill(request, number - self.tables.requests[request].slots, reason)

    def _kill(self, request: int, slot: int, reason: Reason) -> None:
        number = self.tables.requests[request].slots + slot
        if self.phase[number] == RUNNING:
            self._set_slot(request, slot, STOPPING, self.slot_args[number])
            self.actions.append(Killed(self.model.requests[request].name, slot, reason.rule, reason.because))

    def _recover(self) -> None:
        for number, rule in enumerate(self.tables.rules):
            if self.dirty[number]:
                self.dirty[number] = False
                path = self._walk(rule.root)
                self.broken[number] = any(node.code == -t.VIOLATION for node in path)
                for node in path:
                    if node.code == -t.KILL:
                        self._kill_target(node, self.reasons[node.bound])

    def _launch_required(self) -> None:
        for number, launch in enumerate(self.tables.launches):
            if not self.tried[number] and self._agrees(launch.condition):
                self.tried[number] = True
                self._ask(launch.request, self.model.launches[number].args, self.reasons[launch.reason])

    def _settle(self) -> None:
        for request, place in enumerate(self.place):
            if place == EMPTY:
                continue
            args = self.place_args[request]
            path = self._decide(request, args)
            first = -path[0].code
            if first == t.REJECT:
                reason = self.reasons[path[0].bound]
                self._set_place(request, EMPTY, ())
                self.actions.append(Rejected(self.model.requests[request].name, reason.rule, reason.because))
            elif first in (t.LAUNCH, t.DISMISS):
                self._carry_out(request, args, path, None)
            elif first == t.WAIT or self.fallen[request]:
                self.fallen[request] |= self.place[request] == CLEARING
                self._set_place(request, WAITING, args)
            else:
                self._carry_out(request, args, path, None)

    def _violations(self) -> None:
        rules = zip(self.tables.rules, self.broken, strict=True)
        found = [self.reasons[rule.reason] for rule, is_broken in rules if is_broken]
        self.actions += [Violated(reason.rule, reason.because) for reason in dict.fromkeys(found)]
