"""The closed loop: the functional modules and the checker whose decisions are the decoded tables (docs/checks.md).

The loop's state is what a state of docs/language.md section 3 is to the tables: slots with classes of arguments,
waiting places with cells, readings by what tests can tell. Every event is a program, `body` one pass of steps 3 to 5.
"""

from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

from exover.model.event import Abort, AbortWaiting, Ask, Ending, Event, Observe, Report
from exover.model.model import Model
from exover.model.types import Value, from_ordinal, ordinal
from exover.ocrd import tables as t
from exover.ocrd.machine import CLEARING, EMPTY, IDLE, RUNNING, STOPPING, WAITING
from exover.ocrd.reasons import reasons
from exover.ocrd.tables import NONE, Node, Tables, VariableRow
from exover.ocrd.vector import OUTCOMES, Element, rank
from exover.verify.cells import Arguments, Bounds, Cell, TooLarge, points
from exover.verify.distinctions import Told, distinctions
from exover.verify.program import (
    Apply,
    Assign,
    Mark,
    Op,
    Program,
    Require,
    Switch,
    Variable,
    Walk,
    switched,
    walks,
    writes,
)

Guard = tuple[tuple[int, frozenset[int]], ...]
"""Variables and the values that each must have."""
Term = tuple[tuple[Guard, int], ...]
"""A value for each of some disjoint guards, 0 elsewhere."""
MOST_LEVELS = 4096
"""The capacity up to which a consumable is followed."""


@dataclass(frozen=True, slots=True)
class LoopEvent:
    """An event up to what the tables can tell apart; `event` stands for all that are alike."""

    event: Event
    program: Program


@dataclass(frozen=True, slots=True)
class Component:
    """A part of a pass: one rule, one required launch, or the settling of one request."""

    program: Program
    reads: frozenset[int]
    writes: frozenset[int]
    always: bool
    """Whether it may do something in a step that changed nothing it reads."""


@dataclass
class ClosedLoop:
    """Variables, what each entry of the vector is in terms of them, events, and one pass of steps 3 to 5."""

    model: Model
    tables: Tables
    entries: tuple[Element, ...]
    """What each entry of the vector is."""
    variables: list[Variable] = field(default_factory=list)
    index: dict[tuple[object, ...], int] = field(default_factory=dict)
    terms: dict[int, list[Term]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.bounds = Bounds(self.tables)
        self.reasons = reasons(self.model)
        self.entry_of = {element: entry for entry, element in enumerate(self.entries)}
        self.names = [v.name for v in self.model.variables] + [latch.name for latch in self.model.latches]
        self.told = distinctions(self.model)
        self.arguments = [
            Arguments(self.model, self.tables, self.bounds, self.told, r) for r in range(len(self.model.requests))
        ]
        self.may_wait = [self._has(r, {t.WAIT, t.CLEAR, t.SETTLE}) for r in range(len(self.model.requests))]
        self.may_fall = [
            self._has(r, {t.WAIT}) and self._has(r, {t.CLEAR, t.SETTLE}) for r in range(len(self.model.requests))
        ]
        self.samples: dict[int, list[Value]] = {}
        for number in range(len(self.tables.variables)):
            self._declare_variable(number)
        for number in range(len(self.tables.stocks)):
            self._declare_stock(number)
        for request in range(len(self.tables.requests)):
            self._declare_request(request)
        for number in range(len(self.tables.launches)):
            self._declare(("tried", number), 2, 0)
        self.body = self._components()

    # ---- variables ----

    def _declare(self, key: tuple[object, ...], size: int, initial: int) -> int:
        self.index[key] = len(self.variables)
        self.variables.append(Variable(key, size, initial))
        return self.index[key]

    def _term(self, entry: int, *cases: tuple[Guard, int]) -> None:
        if entry != NONE:
            self.terms.setdefault(entry, []).append(cases)

    def _declare_variable(self, number: int) -> None:
        """A poster, state or latch: one value of the variable for each way in which tests of it can turn out."""
        row = self.tables.variables[number]
        name = self.names[number]
        if row.value == NONE and row.rank == NONE and row.raw == NONE and name not in self.told.readings:
            return
        if row.orders < row.orders_end:
            raise TooLarge("two real posters are compared with each other")
        values, numbers = self._readings(number, row)
        self.samples[number] = values
        entry = row.rank if row.type == t.REAL else row.value
        initial = self.tables.reals[row.initial] if row.type == t.REAL else row.initial
        first = self.reading_cell(number, initial)
        var = self._declare(("reading", number), len(values), first)
        self._term(entry, *((((var, frozenset({cell})),), n) for cell, n in enumerate(numbers)))

    def _readings(self, number: int, row: VariableRow) -> tuple[list[Value], list[int]]:
        if row.type == t.REAL:
            cuts = self.tables.reals[row.cuts : row.cuts_end]
            found: dict[int, Value] = {}
            for point in points(self.tables.reals[row.low], self.tables.reals[row.high], cuts, 1):
                found.setdefault(rank(cuts, point), point)
            return list(found.values()), list(found)
        kind = self.model.variables[number].type if number < len(self.model.variables) else None
        told = self.told.readings.get(self.names[number]) or Told()
        numbers = self.bounds.samples([row.value] if row.value != NONE else [], row.low, row.high, told)
        return [from_ordinal(kind, n) if kind else bool(n) for n in numbers], numbers

    def reading_cell(self, number: int, value: float) -> int:
        """Return the value of the loop's variable for a reading: a double, or the ordinal of another type."""
        row = self.tables.variables[number]
        values = self.samples[number]
        if row.type == t.REAL:
            cuts = self.tables.reals[row.cuts : row.cuts_end]
            return [rank(cuts, float(v)) for v in values].index(rank(cuts, value))
        kind = self.model.variables[number].type if number < len(self.model.variables) else None
        numbers = [ordinal(kind, v) if kind else int(v) for v in values]
        return bisect_right(numbers, int(value)) - 1

    def _declare_stock(self, number: int) -> None:
        row = self.tables.stocks[number]
        if row.entry == NONE:
            return
        if row.capacity > MOST_LEVELS:
            raise TooLarge(f"a consumable has {row.capacity + 1} levels")
        var = self._declare(("level", number), row.capacity + 1, row.initial)
        self._term(row.entry, *((((var, frozenset({n})),), n) for n in range(row.capacity + 1)))

    def _declare_request(self, request: int) -> None:
        row, arguments = self.tables.requests[request], self.arguments[request]
        for slot in range(row.slots, row.slots + row.instances):
            self._declare(("phase", slot), 3, IDLE)
            if len(arguments.classes) > 1:
                self._declare(("class", slot), len(arguments.classes), 0)
        for past in self.tables.pasts[row.pasts : row.pasts_end]:
            var = self._declare(("entry", past.entry), 2, 0)
            self._term(past.entry, (((var, frozenset({1})),), 1))
        if row.last != NONE:
            var = self._declare(("entry", row.last), len(OUTCOMES), 0)
            self._term(row.last, *((((var, frozenset({n})),), n) for n in range(len(OUTCOMES))))
        if self.may_wait[request]:
            self._declare(("place", request), 3, EMPTY)
            if len(arguments.cells) > 1:
                self._declare(("cell", request), len(arguments.cells), 0)
            if self.may_fall[request]:
                self._declare(("fallen", request), 2, 0)
        if arguments.poster_orders:
            raise TooLarge(f"`{self.model.requests[request].name}` compares a real argument with a real poster")
        self._count(request)

    def _count(self, request: int) -> None:
        """Let the slots and the waiting place of a request count for the entries of its features."""
        row, arguments = self.tables.requests[request], self.arguments[request]
        features = self.tables.features[row.features : row.features_end]
        slot_weights = [arguments.weights(kind.args, ()) for kind in arguments.classes]
        cell_weights = [arguments.weights(cell.args, ()) for cell in arguments.cells]
        for number, feature in enumerate(features):
            for slot in range(row.instances):
                if feature.slot in (NONE, slot):
                    by_class = [weights[number] for weights in slot_weights]
                    at = row.slots + slot
                    entries = {RUNNING: feature.running, STOPPING: feature.stopping}
                    self._count_phases(("phase", at), ("class", at), entries, by_class)
            if self.may_wait[request] and feature.slot == NONE:
                by_cell = [weights[number] for weights in cell_weights]
                entries = {WAITING: feature.waiting, CLEARING: feature.clearing}
                self._count_phases(("place", request), ("cell", request), entries, by_cell)

    def _count_phases(
        self, where: tuple[object, ...], which: tuple[object, ...], entries: dict[int, int], weights: list[int]
    ) -> None:
        phase = self.index[where]
        kind = self.index.get(which)
        for entry in sorted(set(entries.values()) - {NONE}):
            phases = frozenset(p for p, e in entries.items() if e == entry)
            cases = []
            for weight in sorted(set(weights) - {0}):
                guard: Guard = ((phase, phases),)
                if kind is not None:
                    guard += ((kind, frozenset(k for k, w in enumerate(weights) if w == weight)),)
                cases.append((guard, weight))
            self._term(entry, *cases)

    # ---- events ----

    @cached_property
    def events(self) -> list[LoopEvent]:
        """Every event, those that are alike in what they do to the loop once."""
        found: dict[Program, LoopEvent] = {}
        for event in self._all_events():
            found.setdefault(event.program, event)
        return list(found.values())

    def _all_events(self) -> Iterable[LoopEvent]:
        for number, request in enumerate(self.model.requests):
            for cell in self.arguments[number].cells:
                yield LoopEvent(Ask(request.name, cell.args), self.ask(number, cell, None))
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
                yield LoopEvent(Abort(request.name, slot), (active, *self._kill(number, slot, None)))
            if self.may_wait[number]:
                taken = Require(self.index["place", number], frozenset({WAITING, CLEARING}))
                yield LoopEvent(AbortWaiting(request.name), (taken, *self._empty(number)))
        yield from self._observations()

    def _observations(self) -> Iterable[LoopEvent]:
        latched = tuple(self._latch(NONE))
        for number, variable in enumerate(self.model.variables):
            if variable.kind == "poster":
                for cell, value in enumerate(self.samples.get(number, [variable.initial])):
                    update: Program = (Assign(self.index["reading", number], cell),) if number in self.samples else ()
                    yield LoopEvent(Observe(variable.name, value), update + latched)
        consumables = [resource for resource in self.model.resources if resource.consumable]
        for number, resource in enumerate(consumables):
            var = self.index.get(("level", number))
            for level in range(resource.capacity + 1) if var is not None else [resource.initial]:
                update = () if var is None else (Assign(var, level),)
                yield LoopEvent(Observe(resource.name, level), update + latched)

    def ask(self, request: int, cell: Cell, required: int | None) -> Program:
        """Return the program of an ask, or of a required launch by the rule number `required`."""
        row = self.tables.requests[request]
        decide = self._decide(request, cell, required, settling=False)
        if not self.may_wait[request] or row.interrupts_self:
            return (decide,)
        busy = (self._named(request, "busy"),)
        return (Switch(self.index["place", request], ((decide,), busy, busy)),)

    def _named(self, request: int, rule: str) -> Mark:
        return Mark(("rule", rule))

    def _decide(self, request: int, cell: Cell, required: int | None, settling: bool) -> Walk:
        on = tuple(
            (number, self._act(request, cell, node, required, settling))
            for number, node in self._actions(self.tables.requests[request].decide)
        )
        return Walk(self.tables.requests[request].decide, cell.entries, on)

    def _act(self, request: int, cell: Cell, node: Node, required: int | None, settling: bool) -> Program:
        """Return what an action of a decision does."""
        mark = Mark(("rule", self.reasons[node.bound].rule))
        match -node.code:
            case t.REJECT:
                return (mark, *(self._empty(request) if settling else ()))
            case t.WAIT:
                fall: Program = ()
                if settling and self.may_fall[request]:
                    fallen = Assign(self.index["fallen", request], 1)
                    fall = (Switch(self.index["place", request], ((), (), (fallen,))),)
                return (*(() if settling else (mark,)), *fall, *self._stand(request, cell, WAITING))
            case t.CLEAR | t.SETTLE:
                return (*(() if settling else (mark,)), *self._stand(request, cell, CLEARING))
            case t.KILL:
                return tuple(self._kill_target(node, self.reasons[node.bound].rule))
            case t.DISMISS:
                if not self.may_wait[node.high]:
                    return ()
                emptied = (mark, *self._empty(node.high))
                return (Switch(self.index["place", node.high], ((), emptied, emptied)),)
            case t.LAUNCH:
                return self._launch(request, cell, required)
            case code:
                raise AssertionError(f"action {code} in a decision")

    def _stand(self, request: int, cell: Cell, phase: int) -> Program:
        ops: list[Op] = [Assign(self.index["place", request], phase)]
        if ("cell", request) in self.index:
            ops.append(Assign(self.index["cell", request], cell.number))
        return tuple(ops)

    def _empty(self, request: int) -> Program:
        keys = [key for key in (("place", request), ("cell", request)) if key in self.index]
        return tuple(Assign(self.index[key], 0) for key in keys)

    def _launch(self, request: int, cell: Cell, required: int | None) -> Program:
        row = self.tables.requests[request]
        ops: list[Op] = [Mark(("launch", self.model.requests[request].name))]
        if required is not None:
            ops.append(Mark(("rule", self.reasons[self.tables.launches[required].reason].rule)))
        ops += self._empty(request)
        for amount in self.tables.amounts[row.consumes : row.produces]:
            if self.arguments[request].agrees(amount.predicate, dict(cell.entries)):
                levels = range(self.tables.stocks[amount.stock].capacity + 1)
                taken = tuple(n - amount.amount if n >= amount.amount else None for n in levels)
                ops.append(Apply(self.index["level", amount.stock], taken))
        slots: Program = ()
        for slot in reversed(range(row.slots, row.slots + row.instances)):
            here: list[Op] = [Assign(self.index["phase", slot], RUNNING)]
            if ("class", slot) in self.index:
                here.append(Assign(self.index["class", slot], cell.slot_class))
            slots = (Switch(self.index["phase", slot], (tuple(here), slots, slots)),)
        return (*ops, *slots, *self._affect(row.on_launch, row.on_ok))

    def _affect(self, start: int, end: int) -> Program:
        ops: list[Op] = []
        for effect in self.tables.effects[start:end]:
            if effect.kind == t.FORGET:
                row = self.tables.requests[effect.target]
                pasts = self.tables.pasts[row.pasts : row.pasts_end]
                ops += [Assign(self.index["entry", past.entry], 0) for past in pasts]
            elif effect.target in self.samples:
                cell = self.reading_cell(effect.target, effect.value)
                ops.append(Assign(self.index["reading", effect.target], cell))
        return tuple(ops)

    def _kill_target(self, node: Node, rule: str) -> Iterable[Op]:
        for request, row in enumerate(self.tables.requests):
            for slot in range(row.instances):
                if node.high == request or -1 - node.high == row.slots + slot:
                    yield from self._kill(request, slot, rule)

    def _kill(self, request: int, slot: int, rule: str | None) -> Program:
        var = self.index["phase", self.tables.requests[request].slots + slot]
        mark = (Mark(("rule", rule)),) if rule else ()
        return (Switch(var, ((), (*mark, Assign(var, STOPPING)), ())),)

    def _report(self, request: int, slot: int, outcome: Ending, results: tuple[Value, ...]) -> Program:
        row, arguments = self.tables.requests[request], self.arguments[request]
        at = row.slots + slot
        kind = self.index.get(("class", at))
        ops: list[Op] = []
        if outcome == "ok":
            cases = tuple(self._ok(request, arguments.classes[k].args, results) for k in range(len(arguments.classes)))
            ops += cases[0] if kind is None else [Switch(kind, cases)]
        ops.append(Assign(self.index["phase", at], IDLE))
        if kind is not None:
            ops.append(Assign(kind, 0))
        if row.last != NONE:
            ops.append(Assign(self.index["entry", row.last], OUTCOMES.index(outcome)))
        edges = {"ok": (row.on_ok, row.on_failed), "failed": (row.on_failed, row.on_interrupted)}
        ops += self._affect(*edges.get(outcome, (row.on_interrupted, row.effects_end)))
        ops += self._latch(request if outcome == "ok" else NONE)
        return tuple(ops)

    def _ok(self, request: int, args: tuple[Value, ...], results: tuple[Value, ...]) -> Program:
        """Return what an ok leaves behind: the past, and what it produces."""
        row, arguments = self.tables.requests[request], self.arguments[request]
        pasts = zip(
            self.tables.pasts[row.pasts : row.pasts_end], arguments.pasts(args, results), strict=True
        )
        ops: list[Op] = [Assign(self.index["entry", past.entry], value) for past, value in pasts]
        loaded = arguments.loaded(args)
        for amount in self.tables.amounts[row.produces : row.produces_end]:
            var = self.index.get(("level", amount.stock))
            if var is not None and arguments.agrees(amount.predicate, loaded):
                capacity = self.tables.stocks[amount.stock].capacity
                ops.append(Apply(var, tuple(min(capacity, n + amount.amount) for n in range(capacity + 1))))
        return tuple(ops)

    def _latch(self, cleared_by: int) -> Iterable[Op]:
        for latch in self.tables.latches:
            if latch.variable in self.samples:
                var = self.index["reading", latch.variable]
                clears = cleared_by in self.tables.lists[latch.resets : latch.resets_end]
                end: Program = (Assign(var, 0),) if clears else ()
                on = tuple((number, (Assign(var, 1),)) for number, _ in self._actions(latch.condition))
                yield Walk(latch.condition, (), on, end)

    # ---- steps 3 to 5 ----

    def _components(self) -> list[Component]:
        found = []
        for rule in self.tables.rules:
            on = tuple(
                (number, tuple(self._kill_target(node, self.reasons[node.bound].rule)) if node.code == -t.KILL else ())
                for number, node in self._actions(rule.root)
            )
            found.append(self._component((Walk(rule.root, (), on),), always=False))
        for number, launch in enumerate(self.tables.launches):
            tried = self.index["tried", number]
            cell = self.arguments[launch.request].cell_of(self.model.launches[number].args)
            attempt: Program = (Assign(tried, 1), *self.ask(launch.request, cell, number))
            on = tuple((number, attempt) for number, _ in self._actions(launch.condition))
            walk = Walk(launch.condition, (), on)
            found.append(self._component((Switch(tried, ((walk,), ())),), always=True))
        for request in range(len(self.tables.requests)):
            if self.may_wait[request]:
                found.append(self._component(self._settle(request), self.may_fall[request]))
        return found

    def _settle(self, request: int) -> Program:
        place = self.index["place", request]
        cells = [(self._decide(request, cell, None, settling=True),) for cell in self.arguments[request].cells]
        decided: Program = cells[0]
        if ("cell", request) in self.index:
            decided = (Switch(self.index["cell", request], tuple(cells)),)
        if not self.may_fall[request]:
            return (Switch(place, ((), decided, decided)),)
        stays = tuple(
            (self._decide_fallen(request, cell),) for cell in self.arguments[request].cells
        )
        staying: Program = stays[0]
        if ("cell", request) in self.index:
            staying = (Switch(self.index["cell", request], stays),)
        fallen = Switch(self.index["fallen", request], (decided, staying))
        return (Switch(place, ((), (fallen,), (fallen,))),)

    def _decide_fallen(self, request: int, cell: Cell) -> Walk:
        """Return the decision on a request that fell: where it would clear or settle it stays waiting."""
        root = self.tables.requests[request].decide
        stay = self._stand(request, cell, WAITING)
        clearing = {number for number, node in self._actions(root) if -node.code in (t.CLEAR, t.SETTLE)}
        hidden = {n for start in clearing for n, node in self._actions(start) if node.code == -t.KILL}
        on = []
        for number, node in self._actions(root):
            if number in clearing:
                on.append((number, stay))
            elif number not in hidden:
                on.append((number, self._act(request, cell, node, None, settling=True)))
        return Walk(root, cell.entries, tuple(on))

    def _component(self, program: Program, always: bool) -> Component:
        read = set(switched(program))
        for walk in walks(program):
            fixed = {entry for entry, _ in walk.fixed}
            for entry in self._tested(walk.root) - fixed:
                read |= self.vars_of(entry)
        return Component(program, frozenset(read), frozenset(writes(program)), always)

    def vars_of(self, entry: int) -> set[int]:
        """Return the variables on which an entry of the vector depends."""
        return {var for _, term in self.all_terms(entry) for guard, _ in term for var, _ in guard}

    def all_terms(self, entry: int) -> list[tuple[int, Term]]:
        """Return the terms, with factors, whose sum an entry is."""
        parts = [(entry, 1), *self._parts.get(entry, ())]
        return [(factor, term) for part, factor in parts for term in self.terms.get(part, ())]

    @cached_property
    def _parts(self) -> dict[int, list[tuple[int, int]]]:
        """The parts of every sum with their factors."""
        found: dict[int, list[tuple[int, int]]] = {}
        for part, row in enumerate(self.tables.entries):
            for total, factor in self.tables.sums[row.sums : row.sums_end]:
                found.setdefault(total, []).append((part, factor))
        return found

    # ---- nodes ----

    def _below(self, root: int) -> list[int]:
        found: dict[int, None] = {}
        stack = [root]
        while stack:
            number = stack.pop()
            if number != NONE and number not in found:
                found[number] = None
                node = self.tables.nodes[number]
                stack += [node.low] if node.code < 0 else [node.high, node.low]
        return sorted(found)

    def _actions(self, root: int) -> list[tuple[int, Node]]:
        return [(n, self.tables.nodes[n]) for n in self._below(root) if self.tables.nodes[n].code < 0]

    def _tested(self, root: int) -> set[int]:
        return {self.tables.nodes[n].code for n in self._below(root) if self.tables.nodes[n].code >= 0}

    def _has(self, request: int, codes: set[int]) -> bool:
        return any(-node.code in codes for _, node in self._actions(self.tables.requests[request].decide))
