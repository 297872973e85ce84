"""The walker of the tables in Python: step for step what the C runtime does (docs/runtime.md).

It reads the decoded tables; the model gives names, types and arguments. Answers are those of the reference interpreter.
"""

from collections.abc import Iterable
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
from exover.model.types import from_ordinal
from exover.ocrd import tables as t
from exover.ocrd.memory import CLEARING, EMPTY, IDLE, RUNNING, STOPPING, WAITING, Memory
from exover.ocrd.packing import DamagedTable
from exover.ocrd.tables import NONE, Node, RequestRow
from exover.ocrd.vector import OUTCOMES


class Machine(Memory):
    """A running checker: the steps, on the data of `Memory`."""

    def step(self, event: Event) -> tuple[Action, ...]:
        """Return the actions that answer the event."""
        self.actions = []
        fault = self._validate(event)
        if fault:
            return (fault,)
        self.tried = [False] * len(self.tables.launches)
        self.refusing: list[int | None] = [None] * len(self.tables.launches)
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
            raise DamagedTable("the bound on passes is wrong")
        self.refused = self.refusing
        self._violations()
        return tuple(self.actions)

    def replay(self, events: Iterable[Event]) -> tuple[tuple[Action, ...], ...]:
        """Return the answers to these events, one by one, from the initial state."""
        self.restart()
        return tuple(self.step(event) for event in events)

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
                    self.put(self.tables.stocks[self.stock[name]].entry, int(value))
                else:
                    self.read(self.variable[name], value)
                self._latch(NONE)
            case Abort(name, slot):
                self._kill(self.index[name], slot, Reason("abort"))
            case AbortWaiting(name):
                self._vacate(self.index[name], Reason("aborted"))
            case _:
                assert_never(event)

    def _decide(self, request: int, args: Args) -> list[Node]:
        """Return the actions of the decision; asserts that the bit rows (`conflicts`) confirm it where they can."""
        self.load(request, args)
        path = self.walk(self.tables.requests[request].decide)
        first = path[0]
        if -first.code in (t.REJECT, t.WAIT, t.CLEAR):
            denials = self.tables.reasons[first.bound].denials
            if denials == t.ALL_DENIALS or (denials == t.CLEARINGS and first.code == -t.CLEAR):
                self._assert(self._in_conflict(request), "only the diagrams see a conflict")
        return path

    def _assert(self, is_so: bool, otherwise: str) -> None:
        if not is_so:
            raise DamagedTable(f"the tables contradict themselves: {otherwise}")

    def _in_conflict(self, request: int) -> bool:
        return any(self.held[other] for other in self.conflicts[request])

    def _ask(self, request: int, args: Args, launch: int | None) -> None:
        """Handle an ask; `launch`: the number of the launch rule that raised it."""
        row, name = self.tables.requests[request], self.model.requests[request].name
        required = None if launch is None else self.reasons[self.tables.launches[launch].reason]
        taken = self.place[request] != EMPTY
        if taken and not row.interrupts_self:
            self._refuse(request, self.reasons.index(BUSY), launch)
            return
        path = self._decide(request, args)
        if path[0].code == -t.REJECT:
            self._refuse(request, path[0].bound, launch)
            return
        if taken:
            self._say_rejected(request, Reason("superseded"), self.place_rule[request])
        waits = self._carry_out(request, args, path, required, required)
        if waits:
            self.place_rule[request] = required
            self.actions.append(Waits(name, waits.rule, waits.because, required.rule if required else None))

    def _refuse(self, request: int, reason: int, launch: int | None) -> None:
        """Reject a newcomer; no action if the last step refused this required launch for the same rule."""
        required = None
        if launch is not None:
            self.refusing[launch] = reason
            if self.refused[launch] == reason:
                return
            required = self.reasons[self.tables.launches[launch].reason]
        self._say_rejected(request, self.reasons[reason], required)

    def _vacate(self, request: int, reason: Reason) -> None:
        """Reject what is in the waiting place."""
        self.set_place(request, EMPTY, ())
        self._say_rejected(request, reason, self.place_rule[request])

    def _say_rejected(self, request: int, reason: Reason, required: Reason | None) -> None:
        name = self.model.requests[request].name
        self.actions.append(Rejected(name, reason.rule, reason.because, required.rule if required else None))

    def _carry_out(
        self, request: int, args: Args, path: list[Node], required: Reason | None, launch_rule: Reason | None
    ) -> Reason | None:
        """Do the actions of a decision that is no rejection; return why the newcomer waits, None if it does not.

        `launch_rule`: the origin of the newcomer; `required`: its launch rule, if that requires it in this step.
        """
        waits = None
        for node in path:
            reason = self.reasons[node.bound]
            match -node.code:
                case t.WAIT | t.CLEAR | t.SETTLE:
                    waits = reason
                    self.set_place(request, WAITING if node.code == -t.WAIT else CLEARING, args)
                case t.KILL:
                    self._kill_target(node, reason)
                case t.DISMISS:
                    if self.place[node.high] != EMPTY:
                        self._vacate(node.high, reason)
                case t.LAUNCH:
                    self._launch(request, args, required, launch_rule)
        return waits

    def _launch(self, request: int, args: Args, required: Reason | None, launch_rule: Reason | None) -> None:
        row = self.tables.requests[request]
        phases = self.phase[row.slots : row.slots + row.instances]
        self._assert(IDLE in phases, "a request is launched that has no idle slot")
        slot = phases.index(IDLE)
        self._assert(not self._in_conflict(request), "only the bit rows see a conflict")
        self.held[request] += 1
        self.set_place(request, EMPTY, ())
        for amount in self._counting(request, args, row.consumes, row.produces):
            self.add(self.tables.stocks[amount.stock].entry, -amount.amount)
        self.set_slot(request, slot, RUNNING, args)
        self._affect(row.on_launch, row.on_ok)
        rule, because = (required.rule, required.because) if required else (None, None)
        name = self.model.requests[request].name
        named = launch_rule.rule if launch_rule else None
        self.actions.append(Launched(name, slot, args, rule, because, named))

    def _counting(self, request: int, args: Args, start: int, end: int) -> list[t.AmountRow]:
        amounts = self.tables.amounts[start:end]
        if amounts:
            self.load(request, args)
        return [amount for amount in amounts if self.agrees(amount.predicate)]

    def _affect(self, start: int, end: int) -> None:
        for effect in self.tables.effects[start:end]:
            if effect.kind == t.SET:
                kind = self.model.variables[effect.target].type
                self.read(effect.target, from_ordinal(kind, effect.value))
            else:
                self._set_past(self.tables.requests[effect.target], known=False)

    def _set_past(self, row: RequestRow, known: bool) -> None:
        for past in self.tables.pasts[row.pasts : row.pasts_end]:
            self.put(past.entry, int(known and self.agrees(past.predicate)))

    def _end(self, report: Report) -> None:
        request = self.index[report.request]
        row = self.tables.requests[request]
        args = self.slot_args[row.slots + report.slot]
        self.set_slot(request, report.slot, IDLE, ())
        self.held[request] -= 1
        self.put(row.last, OUTCOMES.index(report.outcome))
        cleared_by = NONE
        if report.outcome == "ok":
            cleared_by = request
            self.load(request, args + report.results)
            self._set_past(row, known=True)
            for amount in self._counting(request, args, row.produces, row.produces_end):
                stock = self.tables.stocks[amount.stock]
                if stock.entry != NONE:
                    self.put(stock.entry, min(stock.capacity, self.vector[stock.entry] + amount.amount))
        edges = {"ok": (row.on_ok, row.on_failed), "failed": (row.on_failed, row.on_interrupted)}
        edges["interrupted"] = (row.on_interrupted, row.effects_end)
        self._affect(*edges[report.outcome])
        self._latch(cleared_by)

    def _latch(self, cleared_by: int) -> None:
        for latch in self.tables.latches:
            if self.agrees(latch.condition):
                self.read(latch.variable, True)
            elif cleared_by in self.tables.lists[latch.resets : latch.resets_end]:
                self.read(latch.variable, False)

    def _kill_target(self, node: Node, reason: Reason) -> None:
        if node.high >= 0:
            for slot in range(self.tables.requests[node.high].instances):
                self._kill(node.high, slot, reason)
            return
        number = -1 - node.high
        request = self.tables.request_of(number)
        self._kill(request, number - self.tables.requests[request].slots, reason)

    def _kill(self, request: int, slot: int, reason: Reason) -> None:
        number = self.tables.requests[request].slots + slot
        if self.phase[number] == RUNNING:
            self.set_slot(request, slot, STOPPING, self.slot_args[number])
            self.actions.append(Killed(self.model.requests[request].name, slot, reason.rule, reason.because))

    def _recover(self) -> None:
        for number, rule in enumerate(self.tables.rules):
            if self.dirty[number]:
                self.dirty[number] = False
                path = self.walk(rule.root)
                self.broken[number] = any(node.code == -t.VIOLATION for node in path)
                for node in path:
                    if node.code == -t.KILL:
                        self._kill_target(node, self.reasons[node.bound])

    def _launch_required(self) -> None:
        for number, launch in enumerate(self.tables.launches):
            if not self.tried[number] and self.agrees(launch.condition):
                self.tried[number] = True
                self._ask(launch.request, self.model.launches[number].args, number)

    def _settle(self) -> None:
        for request, place in enumerate(self.place):
            if place == EMPTY:
                continue
            args = self.place_args[request]
            path = self._decide(request, args)
            first = -path[0].code
            if first == t.REJECT:
                self._vacate(request, self.reasons[path[0].bound])
            elif first in (t.LAUNCH, t.DISMISS):
                self._carry_out(request, args, path, None, self.place_rule[request])
            elif first == t.WAIT or self.fallen[request]:
                self.fallen[request] |= self.place[request] == CLEARING
                self.set_place(request, WAITING, args)
            else:
                self._carry_out(request, args, path, None, self.place_rule[request])

    def _violations(self) -> None:
        rules = zip(self.tables.rules, self.broken, strict=True)
        found = [self.reasons[rule.reason] for rule, is_broken in rules if is_broken]
        self.actions += [Violated(reason.rule, reason.because) for reason in dict.fromkeys(found)]
