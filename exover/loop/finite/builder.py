"""The closed loop: the functional modules and the checker whose decisions are the decoded tables (docs/checks.md).

Every event is a program on the variables of `LoopStates`, and `body` is one pass of steps 3 to 5.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property

from exover.loop.finite.argument_classes import Cell
from exover.loop.finite.observations import Observations
from exover.loop.finite.program import (
    Apply,
    Assign,
    Choose,
    Op,
    Program,
    Require,
    Switch,
    Walk,
    switched,
    walks,
    writes,
)
from exover.loop.finite.variables import Key
from exover.model.decision import BUSY
from exover.model.event import Abort, AbortWaiting, Ask, Ending, Event, Report
from exover.model.types import Value
from exover.ocrd import tables as t
from exover.ocrd.memory import CLEARING, IDLE, RUNNING, STOPPING, WAITING
from exover.ocrd.tables import NONE, Node
from exover.ocrd.vector import LEFT, OUTCOMES, RIGHT


@dataclass(frozen=True, slots=True)
class LoopEvent:
    """An event up to what the tables can tell apart; `event` stands for all that are alike, `cell` for an ask's."""

    event: Event
    program: Program
    cell: Cell | None = None


@dataclass(frozen=True, slots=True)
class Component:
    """A part of a pass: one rule, one required launch, or the settling of one request."""

    program: Program
    reads: frozenset[int]
    writes: frozenset[int]
    always: bool
    """Whether it may do something in a step that changed nothing it reads."""


@dataclass(frozen=True, slots=True)
class FiniteNewcomer:
    """A request to be decided: its arguments, how they compare with posters, the launch rule that requires it.

    `settling`: it stands in the waiting place; `fallen`: it fell from clearing to waiting in this step.
    """

    request: int
    cell: Cell
    choice: tuple[int, ...]
    required: int | None
    settling: bool
    fallen: bool = False


@dataclass
class ClosedLoop(Observations):
    """The states, the events, and one pass of steps 3 to 5."""

    decided: list[tuple[Walk, FiniteNewcomer]] = field(default_factory=list, init=False)
    """Every walk that decides on a newcomer, with it; events and passes add theirs when they are first asked for."""
    _killing: dict[tuple[int, str], Program] = field(default_factory=dict, init=False, repr=False)
    _emptying: dict[int, Program] = field(default_factory=dict, init=False, repr=False)
    _rejections: dict[tuple[str, Program, int | None], Program] = field(default_factory=dict, init=False, repr=False)
    _effects: dict[tuple[int, int], Program] = field(default_factory=dict, init=False, repr=False)
    _taking: dict[tuple[int, int], Apply] = field(default_factory=dict, init=False, repr=False)

    @property
    def approximate(self) -> bool:
        """Whether a run of the loop may have no concrete one: reals that change are compared with each other."""
        return any(key[0] in ("chosen", "pair") for key in self.index)

    # ---- events ----

    @cached_property
    def events(self) -> list[LoopEvent]:
        """Every event, those that are alike in what they do to the loop once."""
        found: dict[Program, LoopEvent] = {}
        for event in self._all_events():
            program = (*self.anew(), *event.program)
            found.setdefault(program, replace(event, program=program))
        return list(found.values())

    def _all_events(self) -> Iterable[LoopEvent]:
        for number, request in enumerate(self.model.requests):
            for cell in self.arguments[number].cells:
                asked = self.noted("asked", number, cell.args)
                yield LoopEvent(Ask(request.name, cell.args), (*asked, *self.ask(number, cell, None)), cell)
        for number, request in enumerate(self.model.requests):
            row = self.tables.requests[number]
            for slot in range(request.instances):
                active = Require(self.index["phase", row.slots + slot], frozenset({RUNNING, STOPPING}))
                for results in self.arguments[number].result_samples:
                    yield LoopEvent(
                        Report(request.name, slot, "ok", results), (active, *self._report(number, slot, "ok", results))
                    )
                for outcome in ("failed", "interrupted"):
                    yield LoopEvent(
                        Report(request.name, slot, outcome), (active, *self._report(number, slot, outcome, ()))
                    )
                yield LoopEvent(
                    Abort(request.name, slot), (active, *self.marked("abort"), *self._kill(number, slot, None))
                )
            if self.may_wait[number]:
                taken = Require(self.index["place", number], frozenset({WAITING, CLEARING}))
                yield LoopEvent(
                    AbortWaiting(request.name),
                    (taken, *self.marked("abort"), *self.refused(number), *self._empty(number)),
                )
        for observe, program in self.observations():
            yield LoopEvent(observe, program)

    def ask(self, request: int, cell: Cell, required: int | None) -> Program:
        """Return the program of an ask, or of a required launch by the rule number `required`."""
        row, arguments = self.tables.requests[request], self.arguments[request]
        program: list[Op] = []
        for which, order in enumerate(arguments.poster_orders):
            poster = -1 - order.right
            chosen, value = self.index["chosen", request, which], float(cell.args[order.left])
            cases = range(len(self.samples[poster]))
            feasible = [(Choose(chosen, self.orders[request].feasible(which, value, c)),) for c in cases]
            program.append(Switch(self.index["reading", poster], tuple(feasible)))
        program += self._by_choice("chosen", FiniteNewcomer(request, cell, (), required, settling=False))
        if not self.may_wait[request] or row.interrupts_self:
            return tuple(program)
        busy = (*self.marked("rule", BUSY.rule), *self.noted("rejected", request, cell.args))
        return (Switch(self.index["place", request], (tuple(program), busy, busy)),)

    def _by_choice(self, kind: str, newcomer: FiniteNewcomer) -> Program:
        """Return the decision on a newcomer, by what the variables `kind` say of how it compares with posters."""
        which = len(newcomer.choice)
        if which == len(self.arguments[newcomer.request].poster_orders):
            return (self._decide(newcomer),)
        cases = [replace(newcomer, choice=(*newcomer.choice, order)) for order in range(LEFT, RIGHT + 1)]
        var = self.index[kind, newcomer.request, which]
        return (Switch(var, tuple(self._by_choice(kind, case) for case in cases)),)

    def _decide(self, newcomer: FiniteNewcomer) -> Walk:
        root = self.tables.requests[newcomer.request].decide
        on = tuple((number, self._act(newcomer, node)) for number, node in self._actions(root))
        if newcomer.fallen:
            on = self._staying(newcomer, on)
        walk = Walk(root, self._fixed(newcomer), on)
        self.decided.append((walk, newcomer))
        return walk

    def _fixed(self, newcomer: FiniteNewcomer) -> tuple[tuple[int, int], ...]:
        orders = self.arguments[newcomer.request].poster_orders
        pairs = zip(orders, newcomer.choice, strict=True)
        return newcomer.cell.entries + tuple((order.entry, value) for order, value in pairs)

    def _staying(
        self, newcomer: FiniteNewcomer, on: tuple[tuple[int, Program], ...]
    ) -> tuple[tuple[int, Program], ...]:
        """Return what is done with a request that fell: where it would clear or settle it stays waiting."""
        nodes = self.tables.nodes
        stay = self._stand(newcomer, WAITING)
        staying = {number: stay for number, _ in on if nodes[number].code == -t.CLEAR}
        settling = [number for number, _ in on if nodes[number].code == -t.SETTLE]
        staying |= {n: (*self.marked("settle", self.reasons[nodes[n].bound].rule), *stay) for n in settling}
        hidden = {n for start in staying for n, node in self._actions(start) if node.code == -t.KILL}
        return tuple((n, staying.get(n, program)) for n, program in on if n not in hidden)

    def _act(self, newcomer: FiniteNewcomer, node: Node) -> Program:
        """Return what an action of a decision does."""
        request, settling = newcomer.request, newcomer.settling
        rule = self.reasons[node.bound].rule
        mark = self.marked("rule", rule)
        match -node.code:
            case t.REJECT:
                noted = self.noted("rejected", request, newcomer.cell.args)
                return self._rejecting(rule, noted, request if settling else None)
            case t.WAIT:
                fall: Program = ()
                if settling and self.may_fall[request]:
                    fallen = Assign(self.index["fallen", request], 1)
                    fall = (Switch(self.index["place", request], ((), (), (fallen,))),)
                return (*(() if settling else mark), *self.marked("wait", rule), *fall, *self._stand(newcomer, WAITING))
            case t.CLEAR:
                return (*(() if settling else mark), *self._stand(newcomer, CLEARING))
            case t.SETTLE:
                return (*(() if settling else mark), *self.marked("settle", rule), *self._stand(newcomer, CLEARING))
            case t.KILL:
                return self._killed(node, rule)
            case t.DISMISS:
                if not self.may_wait[node.high]:
                    return ()
                killed = self.marked("kill", rule, self.model.requests[node.high].name)
                emptied = (*mark, *killed, *self.refused(node.high), *self._empty(node.high))
                return (Switch(self.index["place", node.high], ((), emptied, emptied)),)
            case t.LAUNCH:
                return self._launch(newcomer)
            case code:
                raise AssertionError(f"action {code} in a decision")

    def _rejecting(self, rule: str, noted: Program, emptied: int | None) -> Program:
        """Return a rejection for a rule, and what becomes of the request whose waiting place is emptied by it."""
        key = (rule, noted, emptied)
        if key not in self._rejections:
            marks = (*self.marked("rule", rule), *self.marked("reject", rule))
            self._rejections[key] = (*marks, *noted, *(() if emptied is None else self._empty(emptied)))
        return self._rejections[key]

    def _stand(self, newcomer: FiniteNewcomer, phase: int) -> Program:
        request = newcomer.request
        ops: list[Op] = [] if newcomer.settling else list(self.superseded(request))
        ops.append(Assign(self.index["place", request], phase))
        if ("cell", request) in self.index:
            ops.append(Assign(self.index["cell", request], newcomer.cell.number))
        ops += [Assign(self.index["standing", request, k], order) for k, order in enumerate(newcomer.choice)]
        return tuple(ops)

    def _empty(self, request: int) -> Program:
        if request not in self._emptying:
            keys: list[Key] = [("place", request), ("cell", request)]
            keys += [("standing", request, k) for k in range(len(self.arguments[request].poster_orders))]
            cleared = (Assign(self.index[key], 0) for key in keys if key in self.index)
            self._emptying[request] = (*self.left(request), *cleared)
        return self._emptying[request]

    def _launch(self, newcomer: FiniteNewcomer) -> Program:
        request, cell = newcomer.request, newcomer.cell
        row = self.tables.requests[request]
        ops: list[Op] = [*self.marked("launch", self.model.requests[request].name)]
        if not newcomer.settling:
            ops += self.superseded(request)
        ops += (*self._empty(request), *self.noted("launched", request, cell.args))
        for amount in self.tables.amounts[row.consumes : row.produces]:
            var = self.index.get(("level", amount.stock))
            if var is not None and self.arguments[request].agrees(amount.predicate, dict(cell.entries)):
                ops.append(self._consumed(var, amount.stock, amount.amount))
        slots: Program = ()
        for slot in reversed(range(row.slots, row.slots + row.instances)):
            here: list[Op] = [Assign(self.index["phase", slot], RUNNING)]
            if ("class", slot) in self.index:
                here.append(Assign(self.index["class", slot], cell.slot_class))
            orders = [("order", slot, k) for k in range(len(newcomer.choice))]
            here += [
                Assign(self.index[key], order)
                for key, order in zip(orders, newcomer.choice, strict=True)
                if key in self.index
            ]
            slots = (Switch(self.index["phase", slot], (tuple(here), slots, slots)),)
        return (*ops, *slots, *self._affect(row.on_launch, row.on_ok))

    def _consumed(self, var: int, stock: int, amount: int) -> Apply:
        if (var, amount) not in self._taking:
            levels = range(self.tables.stocks[stock].capacity + 1)
            self._taking[var, amount] = Apply(var, tuple(n - amount if n >= amount else None for n in levels))
        return self._taking[var, amount]

    def _affect(self, start: int, end: int) -> Program:
        if (start, end) not in self._effects:
            self._effects[start, end] = self._affected(start, end)
        return self._effects[start, end]

    def _affected(self, start: int, end: int) -> Program:
        ops: list[Op] = []
        for effect in self.tables.effects[start:end]:
            if effect.kind == t.FORGET:
                past = self.index.get(("past", effect.target))
                ops += [Assign(past, 0)] if past is not None else []
            elif effect.target in self.samples:
                cell = self.reading_cell(effect.target, effect.value)
                ops.append(Assign(self.index["reading", effect.target], cell))
        return tuple(ops)

    def _killed(self, node: Node, rule: str) -> Program:
        key = (node.high, rule)
        if key not in self._killing:
            self._killing[key] = tuple(self._kill_target(node, rule))
        return self._killing[key]

    def _kill_target(self, node: Node, rule: str) -> Iterable[Op]:
        for request, row in enumerate(self.tables.requests):
            for slot in range(row.instances):
                if node.high == request or -1 - node.high == row.slots + slot:
                    yield from self._kill(request, slot, rule)

    def _kill(self, request: int, slot: int, rule: str | None) -> Program:
        at = self.tables.requests[request].slots + slot
        var = self.index["phase", at]
        killed = self.marked("kill", rule, self.model.requests[request].name) if rule else ()
        marks = (*self.marked("rule", rule), *killed) if rule else ()
        return (Switch(var, ((), (*marks, *self.noted_in_slot("killed", request, at), Assign(var, STOPPING)), ())),)

    def _report(self, request: int, slot: int, outcome: Ending, results: tuple[Value, ...]) -> Program:
        row, arguments = self.tables.requests[request], self.arguments[request]
        at = row.slots + slot
        kind = self.index.get(("class", at))
        ops: list[Op] = list(self.noted_in_slot("ended", request, at))
        if outcome == "ok":
            cases = tuple(self._ok(request, arguments.classes[k].args, results) for k in range(len(arguments.classes)))
            ops += cases[0] if kind is None else [Switch(kind, cases)]
        ops.append(Assign(self.index["phase", at], IDLE))
        if kind is not None:
            ops.append(Assign(kind, 0))
        ops += [Assign(self.index["order", at, which], 0) for which in self.arguments[request].remembered]
        if ("last", request) in self.index:
            ops.append(Assign(self.index["last", request], OUTCOMES.index(outcome)))
        edges = {"ok": (row.on_ok, row.on_failed), "failed": (row.on_failed, row.on_interrupted)}
        ops += self._affect(*edges.get(outcome, (row.on_interrupted, row.effects_end)))
        ops += self.latch(request if outcome == "ok" else NONE)
        return tuple(ops)

    def _ok(self, request: int, args: tuple[Value, ...], results: tuple[Value, ...]) -> Program:
        """Return what an ok leaves behind: the past, and what it produces."""
        row, arguments = self.tables.requests[request], self.arguments[request]
        past = self.index.get(("past", request))
        ops: list[Op] = [Assign(past, 1 + arguments.past_kind(args, results))] if past is not None else []
        loaded = arguments.loaded(args)
        for amount in self.tables.amounts[row.produces : row.produces_end]:
            var = self.index.get(("level", amount.stock))
            if var is not None and arguments.agrees(amount.predicate, loaded):
                capacity = self.tables.stocks[amount.stock].capacity
                ops.append(Apply(var, tuple(min(capacity, n + amount.amount) for n in range(capacity + 1))))
        return tuple(ops)

    # ---- steps 3 to 5 ----

    @cached_property
    def body(self) -> list[Component]:
        """One pass: the rules, the required launches and the waiting requests, each in order."""
        found = []
        for rule in self.tables.rules:
            on = tuple(
                (number, self._killed(node, self.reasons[node.bound].rule) if node.code == -t.KILL else ())
                for number, node in self._actions(rule.root)
            )
            found.append(self._component((Walk(rule.root, (), on),), always=False))
        for number, launch in enumerate(self.tables.launches):
            tried = self.index["tried", number]
            cell = self.arguments[launch.request].cell_of(self.model.launches[number].args)
            mark = self.marked("rule", self.reasons[launch.reason].rule)
            attempt: Program = (Assign(tried, 1), *mark, *self.ask(launch.request, cell, number))
            on = tuple((number, attempt) for number, _ in self._actions(launch.condition))
            walk = Walk(launch.condition, (), on)
            found.append(self._component((Switch(tried, ((walk,), ())),), always=True))
        for request in range(len(self.tables.requests)):
            if self.may_wait[request]:
                found.append(self._component(self._settle(request), self.may_fall[request]))
        return found

    def settling(self, request: int) -> int:
        """Return the number of the component that settles a request that can wait."""
        return len(self.tables.rules) + len(self.tables.launches) + sum(self.may_wait[:request])

    def _settle(self, request: int) -> Program:
        place = self.index["place", request]
        decided = self._decided_in_place(request, fallen=False)
        if self.may_fall[request]:
            stays = self._decided_in_place(request, fallen=True)
            decided = (Switch(self.index["fallen", request], (decided, stays)),)
        return (Switch(place, ((), decided, decided)),)

    def _decided_in_place(self, request: int, fallen: bool) -> Program:
        """Return the decision on what stands in the waiting place."""
        cells = [
            self._by_choice("standing", FiniteNewcomer(request, cell, (), None, settling=True, fallen=fallen))
            for cell in self.arguments[request].cells
        ]
        return (Switch(self.index["cell", request], tuple(cells)),) if len(cells) > 1 else cells[0]

    def _component(self, program: Program, always: bool) -> Component:
        return Component(program, self.reads(program), frozenset(writes(program)), always)

    def reads(self, program: Program) -> frozenset[int]:
        """Return the variables that a program looks at."""
        read = set(switched(program))
        entries: set[int] = set()
        for walk in walks(program):
            entries |= self.tested(walk.root) - {entry for entry, _ in walk.fixed}
        return frozenset(read.union(*map(self.vars_of, entries)))
