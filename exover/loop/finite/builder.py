"""The closed loop: the functional modules and the checker whose decisions are the decoded tables (docs/checks.md).

Every event is a program on the variables of `LoopStates`, and `body` is one pass of steps 3 to 5.
"""

from collections.abc import Callable, Iterable
from dataclasses import field, replace
from functools import cached_property
from itertools import chain

from exover.dataclass import dataclass
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
from exover.loop.finite.variables import VariableKey
from exover.loop.step_semantics import StepSemantics
from exover.model.event import Abort, AbortWaiting, Ask, Ending, Event, Report
from exover.model.model import Request
from exover.model.property import Occurrence
from exover.model.types import Value
from exover.ocrd import tables as t
from exover.ocrd.memory import CLEARING, IDLE, RUNNING, STOPPING, WAITING
from exover.ocrd.tables import NONE, Node
from exover.ocrd.vector import LEFT, OUTCOMES, RIGHT

FAILURES: tuple[Ending, ...] = ("failed", "interrupted")


@dataclass(frozen=True, slots=True)
class LoopEvent:
    """A class of events that the tables do not tell apart: a representative, its program, and of an ask the cell."""

    event: Event
    program: Program
    cell: Cell | None = None


@dataclass(frozen=True, slots=True)
class Component:
    """A component of a pass, with the variables that it reads and writes."""

    program: Program
    reads: frozenset[int]
    writes: frozenset[int]
    always: bool
    """Whether it is spontaneous: it may do something in a step that has written nothing it reads."""


@dataclass(frozen=True, slots=True)
class FiniteNewcomer:
    """A request to be decided: the cell of its arguments, and how they compare with posters (`choice`).

    `settling`: it is in the waiting place; `fallen`: it fell from clearing to waiting in this step.
    """

    request: int
    cell: Cell
    choice: tuple[int, ...]
    settling: bool
    fallen: bool = False


@dataclass
class ClosedLoop(Observations, StepSemantics[FiniteNewcomer, Program]):
    """The states, the events, and one pass of steps 3 to 5."""

    decided: list[tuple[Walk, FiniteNewcomer]] = field(default_factory=list, init=False)
    """Every walk that decides on a newcomer, with the newcomer; complete once `events` and `body` have been made."""
    _killing: dict[tuple[int, str], Program] = field(default_factory=dict, init=False, repr=False)
    _shared: dict[Program, Program] = field(default_factory=dict, init=False, repr=False)
    _taking: dict[tuple[int, int], Apply] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def approximate(self) -> bool:
        """Whether the loop over-approximates: iff reals that change are compared with each other."""
        return any(key[0] in ("chosen", "pair") for key in self.index)

    # ---- events ----

    @cached_property
    def events(self) -> list[LoopEvent]:
        """The events; of several with the same program, the first."""
        found: dict[Program, LoopEvent] = {}
        for event in self._all_events():
            found.setdefault(event.program, event)
        return [replace(event, program=(*self.anew, *event.program)) for event in found.values()]

    def _all_events(self) -> Iterable[LoopEvent]:
        for number, request in enumerate(self.model.requests):
            for cell in self.arguments[number].cells:
                asked = self.noted("asked", number, cell.args)
                yield LoopEvent(Ask(request.name, cell.args), (*asked, *self.asked(number, cell)), cell)
        for number, request in enumerate(self.model.requests):
            yield from self._of_slots(number, request)
            if self.may_wait[number]:
                taken = Require(self.index["place", number], frozenset({WAITING, CLEARING}))
                yield LoopEvent(AbortWaiting(request.name), (taken, *self.marked("abort"), *self.given_up(number)))
        for observe, program in self.observations(self.latched(NONE)):
            yield LoopEvent(observe, program)

    def _of_slots(self, number: int, request: Request) -> Iterable[LoopEvent]:
        """Yield the reports and aborts of the slots of a request."""
        for slot in range(request.instances):
            active = Require(self.phase_index(number, slot), frozenset({RUNNING, STOPPING}))
            for results in self.arguments[number].result_samples:
                ended = self._reported(number, slot, "ok", results)
                yield LoopEvent(Report(request.name, slot, "ok", results), (active, *ended))
            for outcome in FAILURES:
                ended = self._reported(number, slot, outcome)
                yield LoopEvent(Report(request.name, slot, outcome), (active, *ended))
            aborted = (*self.marked("abort"), *self.kill(number, slot, None))
            yield LoopEvent(Abort(request.name, slot), (active, *aborted))

    def phase_index(self, request: int, number: int) -> int:
        """Return the variable that is the phase of a slot of a request."""
        return self.index["phase", self.tables.requests[request].slots + number]

    # ---- decisions ----

    def asked(self, request: int, cell: Cell) -> Program:
        """Return the program of an ask, or of what a launch rule asks for."""
        arguments = self.arguments[request]
        program: list[Op] = []
        for which, order in enumerate(arguments.poster_orders):
            poster = -1 - order.right
            chosen, value = self.index["chosen", request, which], float(cell.args[order.left])
            cases = range(len(self.samples[poster]))
            feasible = [(Choose(chosen, self.orders[request].feasible(which, value, c)),) for c in cases]
            program.append(Switch(self.index["reading", poster], tuple(feasible)))
        newcomer = FiniteNewcomer(request, cell, (), settling=False)
        return self.admitted(newcomer, (*program, *self._by_choice("chosen", newcomer)))

    def _by_choice(self, kind: str, newcomer: FiniteNewcomer) -> Program:
        """Return the decision on a newcomer, switched by the variables `kind`: how it compares with posters."""
        which = len(newcomer.choice)
        if which == len(self.arguments[newcomer.request].poster_orders):
            return (self._decide(newcomer),)
        cases = [replace(newcomer, choice=(*newcomer.choice, order)) for order in range(LEFT, RIGHT + 1)]
        var = self.index[kind, newcomer.request, which]
        return (Switch(var, tuple(self._by_choice(kind, case) for case in cases)),)

    def _decide(self, newcomer: FiniteNewcomer) -> Walk:
        root = self.tables.requests[newcomer.request].decide
        on = tuple((number, self.act(newcomer, node)) for number, node in self._actions(root))
        walk = Walk(root, self._fixed(newcomer), on)
        self.decided.append((walk, newcomer))
        return walk

    def _fixed(self, newcomer: FiniteNewcomer) -> tuple[tuple[int, int], ...]:
        orders = self.arguments[newcomer.request].poster_orders
        pairs = zip(orders, newcomer.choice, strict=True)
        return newcomer.cell.entries + tuple((order.entry, value) for order, value in pairs)

    # ---- the parts of steps ----

    def _one_object(self, program: Program) -> Program:
        """Return the object that stands for all programs equal to this one."""
        return self._shared.setdefault(program, program)

    def sequence(self, *parts: Program) -> Program:
        """Return the parts one after the other."""
        return tuple(chain.from_iterable(parts))

    def noted_of(self, occurrence: Occurrence, newcomer: FiniteNewcomer) -> Program:
        """Return the part that notes an occurrence of the newcomer."""
        return self.noted(occurrence, newcomer.request, newcomer.cell.args)

    def superseded(self, request: int) -> Program:
        """Return the part that notes that a newcomer supersedes the waiting request, if one waits."""
        if not self.may_wait[request]:
            return ()
        noted = self.refused(request)
        return (*self.left(request), *(self.if_waiting(request, noted) if noted else ()))

    def if_waiting(self, request: int, then: Program, otherwise: Program | None = None) -> Program:
        """Return the part that does `then` if a request waits, else `otherwise`."""
        return (Switch(self.index["place", request], (otherwise or (), then, then)),)

    def if_running(self, request: int, number: int, then: Program) -> Program:
        """Return the part that does `then` if a slot is running."""
        return (Switch(self.phase_index(request, number), ((), then, ())),)

    def unless_fallen(self, newcomer: FiniteNewcomer, part: Program) -> Program:
        """Return the part, guarded: it is skipped if the newcomer has fallen to waiting before in this step."""
        return () if newcomer.fallen else part

    def falling(self, newcomer: FiniteNewcomer, clearing: bool) -> Program:
        """Return the part that notes a fall to waiting: the place was clearing and will not be."""
        if clearing:
            return ()
        falls: Program = (Assign(self.index["fallen", newcomer.request], 1),)
        return (Switch(self.index["place", newcomer.request], ((), (), falls)),)

    def put_in_place(self, newcomer: FiniteNewcomer, clearing: bool) -> Program:
        """Return the part that puts or keeps the newcomer in the waiting place; one that fell before stays waiting."""
        request, phase = newcomer.request, CLEARING if clearing and not newcomer.fallen else WAITING
        ops: list[Op] = [Assign(self.index["place", request], phase)]
        if ("cell", request) in self.index:
            ops.append(Assign(self.index["cell", request], newcomer.cell.number))
        ops += [Assign(self.index["standing", request, k], order) for k, order in enumerate(newcomer.choice)]
        return tuple(ops)

    def vacated(self, request: int) -> Program:
        """Return the part that empties the waiting place."""
        keys: list[VariableKey] = [("place", request), ("cell", request)]
        keys += [("standing", request, k) for k in range(len(self.arguments[request].poster_orders))]
        return tuple(Assign(self.index[key], 0) for key in keys if key in self.index)

    def rejected(self, newcomer: FiniteNewcomer, rule: str) -> Program:
        """Return the part that rejects the newcomer for a rule."""
        return self._one_object(super().rejected(newcomer, rule))

    def killed(self, node: Node) -> Program:
        """Return the part that kills the slots which a node names, for its rule; cached by target and rule."""
        key = (node.high, self.reasons[node.bound].rule)
        if key not in self._killing:
            self._killing[key] = super().killed(node)
        return self._killing[key]

    def occupied(self, newcomer: FiniteNewcomer) -> Program:
        """Return the part that lets the newcomer run in the first idle slot."""
        row, cell = self.tables.requests[newcomer.request], newcomer.cell
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
            slots = self._one_object((Switch(self.index["phase", slot], (tuple(here), slots, slots)),))
        return slots

    def stopped(self, request: int, number: int) -> Program:
        """Return the part that sets a slot to stopping."""
        return (Assign(self.phase_index(request, number), STOPPING),)

    def consumed(self, newcomer: FiniteNewcomer, amount: t.AmountRow) -> Program:
        """Return the part by which the newcomer takes what it consumes."""
        var = self.index.get(("level", amount.stock))
        loader = self.arguments[newcomer.request].loader
        if var is None or not loader.agrees(amount.predicate, dict(newcomer.cell.entries)):
            return ()
        return (self._lowered(var, amount.stock, amount.amount),)

    def _lowered(self, var: int, stock: int, amount: int) -> Apply:
        if (var, amount) not in self._taking:
            levels = range(self.tables.stocks[stock].capacity + 1)
            self._taking[var, amount] = Apply(var, tuple(n - amount if n >= amount else None for n in levels))
        return self._taking[var, amount]

    def forgotten(self, request: int) -> Program:
        """Return the part that clears the past of a request."""
        past = self.index.get(("past", request))
        return () if past is None else (Assign(past, 0),)

    def assigned(self, variable: int, value: int) -> Program:
        """Return the part that sets a state of a module to the value of this ordinal."""
        if variable not in self.samples:
            return ()
        return (Assign(self.index["reading", variable], self.reading_cell(variable, value)),)

    # ---- reports ----

    def _reported(self, request: int, number: int, outcome: Ending, results: tuple[Value, ...] = ()) -> Program:
        return self.report(request, number, outcome, self._released(request, number, outcome, results))

    def _released(self, request: int, number: int, outcome: Ending, results: tuple[Value, ...]) -> Program:
        """Return the part that makes a slot idle and keeps its outcome and, after an ok, past and products."""
        arguments, at = self.arguments[request], self.tables.requests[request].slots + number
        kind = self.index.get(("class", at))
        ops: list[Op] = []
        if outcome == "ok":
            cases = tuple(self._ok(request, arguments.classes[k].args, results) for k in range(len(arguments.classes)))
            ops += cases[0] if kind is None else [Switch(kind, cases)]
        ops.append(Assign(self.index["phase", at], IDLE))
        if kind is not None:
            ops.append(Assign(kind, 0))
        ops += [Assign(self.index["order", at, which], 0) for which in arguments.remembered]
        if ("last", request) in self.index:
            ops.append(Assign(self.index["last", request], OUTCOMES.index(outcome)))
        return tuple(ops)

    def _ok(self, request: int, args: tuple[Value, ...], results: tuple[Value, ...]) -> Program:
        """Return the part that keeps the past and adds what is produced after an ok."""
        row, arguments = self.tables.requests[request], self.arguments[request]
        past = self.index.get(("past", request))
        ops: list[Op] = [Assign(past, 1 + arguments.pasts.number(args, results))] if past is not None else []
        loaded = arguments.loader.loaded(args)
        for amount in self.tables.amounts[row.produces : row.produces_end]:
            var = self.index.get(("level", amount.stock))
            if var is not None and arguments.loader.agrees(amount.predicate, loaded):
                capacity = self.tables.stocks[amount.stock].capacity
                ops.append(Apply(var, tuple(min(capacity, n + amount.amount) for n in range(capacity + 1))))
        return tuple(ops)

    # ---- steps 3 to 5 ----

    def following(self, root: int, on: Callable[[Node], Program]) -> Program:
        """Return the part that follows a diagram of the state and does at each action what `on` returns for it."""
        return (Walk(root, (), tuple((number, on(node)) for number, node in self._actions(root))),)

    def once_due(self, launch: int, attempt: Program) -> Program:
        """Return the attempt, done (and remembered) if the rule's condition holds and it was not tried in this step."""
        tried = self.index["tried", launch]
        attempt = (Assign(tried, 1), *attempt)
        walk = self.following(self.tables.launches[launch].condition, lambda _: attempt)
        return (Switch(tried, (walk, ())),)

    def required(self, launch: int) -> Program:
        """Return the part that asks for the request of a launch rule."""
        request = self.tables.launches[launch].request
        return self.asked(request, self.arguments[request].cell_of(self.model.launches[launch].args))

    @cached_property
    def body(self) -> list[Component]:
        """One pass: the rules, the required launches and the waiting requests, each in order."""
        found = [self._component(self.restored(rule), always=False) for rule in range(len(self.tables.rules))]
        found += [self._component(self.tried(launch), always=True) for launch in range(len(self.tables.launches))]
        for request in range(len(self.tables.requests)):
            if self.may_wait[request]:
                found.append(self._component(self._settle(request), self.may_fall[request]))
        return found

    def settling(self, request: int) -> int:
        """Return the number of the component that settles a request that can wait."""
        return len(self.tables.rules) + len(self.tables.launches) + sum(self.may_wait[:request])

    def _settle(self, request: int) -> Program:
        decided = self._decided_in_place(request, fallen=False)
        if self.may_fall[request]:
            stays = self._decided_in_place(request, fallen=True)
            decided = (Switch(self.index["fallen", request], (decided, stays)),)
        return self.if_waiting(request, decided)

    def _decided_in_place(self, request: int, fallen: bool) -> Program:
        """Return the decision on the waiting request."""
        cells = [
            self._by_choice("standing", FiniteNewcomer(request, cell, (), settling=True, fallen=fallen))
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
