"""The parts of steps as changes of a symbolic state, each under a guard.

`StepSemantics` says which parts a step has; marks and notes are those of `ClosedLoop`.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import Protocol

from exover.dataclass import dataclass
from exover.loop.exact.layout import Layout, level_name
from exover.loop.exact.symbolic_state import SymbolicState
from exover.loop.exact.table_encoding import RequestArguments, TableEncoding
from exover.loop.exact.term import Term
from exover.loop.step_semantics import StepSemantics
from exover.model.event import Ending
from exover.model.index import ModelIndex
from exover.model.property import Occurrence
from exover.model.types import from_ordinal
from exover.ocrd import tables as t
from exover.ocrd.reasons import reasons
from exover.ocrd.tables import Node
from exover.ocrd.vector import OUTCOMES

Change = Callable[[SymbolicState, Term], None]
"""A part of a step: it changes a state where a guard holds."""


def tried(launch: int) -> str:
    """Return the variable by which a step remembers that it has tried a required launch."""
    return f"tried {launch}"


def fallen(request: str) -> str:
    """Return the variable by which a step remembers that a request fell from clearing to waiting."""
    return f"fallen {request}"


@dataclass(frozen=True, slots=True)
class Newcomer:
    """A request that is decided; `settling`: it is in its waiting place.

    `clears`: under which condition the present action may clear its way: it has not fallen to waiting in this step.
    """

    request: int
    args: tuple[Term, ...]
    settling: bool = False
    clears: Term | None = None


class Observer(Protocol):
    """Is called at every decision and before every restoring of rules, and may pass marks of its own."""

    def decides(self, actions: "TableActions", frame: SymbolicState, guard: Term, newcomer: Newcomer) -> None:
        """A newcomer is about to be decided where `guard` holds."""
        ...

    def restores(self, actions: "TableActions", frame: SymbolicState) -> None:
        """The rules are about to be restored, at the beginning of a pass."""
        ...


@dataclass
class TableActions(StepSemantics[Newcomer, Change]):
    """The parts of events and of passes."""

    vector: TableEncoding
    observer: Observer | None = None

    def __post_init__(self) -> None:
        self.layout: Layout = self.vector.layout
        self.model, self.tables, self.terms = self.layout.model, self.vector.tables, self.layout.terms
        self.reasons = reasons(self.model)
        self.may_wait, self.may_fall = self.tables.may_wait(), self.tables.may_fall()

    @cached_property
    def number(self) -> dict[str, int]:
        """The numbers of the requests by name."""
        return ModelIndex(self.model).request

    def name(self, request: int) -> str:
        """Return the name of a request."""
        return self.model.requests[request].name

    def sequence(self, *parts: Change) -> Change:
        """Return the parts one after the other."""

        def change(frame: SymbolicState, guard: Term) -> None:
            for part in parts:
                part(frame, guard)

        return change

    # ---- what happened ----

    def marked(self, *label: str) -> Change:
        """Return the part that passes a mark."""
        return lambda frame, guard: frame.mark(guard, *label)

    def noted_of(self, occurrence: Occurrence, newcomer: Newcomer) -> Change:
        """Return the part that notes an occurrence of the newcomer."""
        name = self.name(newcomer.request)
        return lambda frame, guard: frame.note(guard, occurrence, name, newcomer.args)

    def noted_in_slot(self, occurrence: Occurrence, request: int, number: int) -> Change:
        """Return the part that notes an occurrence of the request in a slot, with its arguments."""
        name = self.name(request)
        slot = self.layout.slots[name, number]
        return lambda frame, guard: frame.note(guard, occurrence, name, frame.all(slot.args))

    def refused(self, request: int) -> Change:
        """Return the part that notes the rejection of the waiting request, if one waits."""
        name = self.name(request)
        place = self.layout.places[name]

        def change(frame: SymbolicState, guard: Term) -> None:
            here = self.terms.both((guard, frame[place.taken]))
            frame.note(here, "rejected", name, frame.all(place.args))

        return change

    # ---- decisions ----

    def asked(self, request: int, args: tuple[Term, ...]) -> Change:
        """Return the part of an ask, by an event or by a launch rule."""
        newcomer = Newcomer(request, args)
        return self.admitted(newcomer, self.decided(newcomer))

    def settled(self, request: int) -> Change:
        """Return the decision on the waiting request."""
        place = self.layout.places[self.name(request)]

        def change(frame: SymbolicState, guard: Term) -> None:
            self.decided(Newcomer(request, frame.all(place.args), settling=True))(frame, guard)

        return self.if_waiting(request, change)

    def decided(self, newcomer: Newcomer) -> Change:
        """Return the decision on a newcomer, carried out."""
        return lambda frame, guard: self._decide(frame, guard, newcomer)

    def _decide(self, frame: SymbolicState, guard: Term, newcomer: Newcomer) -> None:
        if self.observer is not None:
            self.observer.decides(self, frame, guard, newcomer)
        looked = RequestArguments(newcomer.request, newcomer.args)
        actions = self.vector.walk(frame, guard, self.tables.requests[newcomer.request].decide, looked)
        stays = self.terms.false
        if newcomer.settling and self.may_fall[newcomer.request]:
            stays = frame[fallen(self.name(newcomer.request))]
        for node, here in actions:
            clears = self.terms.both((here, self.terms.negation(stays)))
            self.act(replace(newcomer, clears=clears), node)(frame, here)

    def unless_fallen(self, newcomer: Newcomer, part: Change) -> Change:
        """Return the part, guarded: it is skipped if the newcomer has fallen to waiting before in this step."""
        return lambda frame, _: part(frame, self._clears(newcomer))

    def _clears(self, newcomer: Newcomer, clearing: bool = True) -> Term:
        """Return the condition under which an action clears the way of a newcomer; false unless `clearing`."""
        return newcomer.clears if clearing and newcomer.clears is not None else self.terms.false

    def superseded(self, request: int) -> Change:
        """Return the part that notes that a newcomer supersedes the waiting request, if one waits."""
        return self.sequence(self.left(request), self.refused(request)) if self.may_wait[request] else self.sequence()

    def falling(self, newcomer: Newcomer, clearing: bool) -> Change:
        """Return the part that notes a fall to waiting: the place was clearing and will not be."""
        name = self.name(newcomer.request)
        place = self.layout.places[name]

        def change(frame: SymbolicState, guard: Term) -> None:
            stops = self.terms.negation(self._clears(newcomer, clearing))
            falls = self.terms.both((guard, frame[place.clearing], stops))
            frame.put(falls, fallen(name), self.terms.true)

        return change

    def put_in_place(self, newcomer: Newcomer, clearing: bool) -> Change:
        """Return the part that puts or keeps the newcomer in the waiting place; one that fell before stays waiting."""
        name = self.name(newcomer.request)
        place = self.layout.places[name]

        def change(frame: SymbolicState, guard: Term) -> None:
            if not newcomer.settling:
                frame.mark(guard, "put", name)
                frame.put_all(guard, place.args, newcomer.args)
            frame.put(guard, place.taken, self.terms.true)
            frame.put(guard, place.clearing, self._clears(newcomer, clearing))

        return change

    def occupied(self, newcomer: Newcomer) -> Change:
        """Return the part that lets the newcomer run in the first idle slot."""
        name, row = self.name(newcomer.request), self.tables.requests[newcomer.request]

        def change(frame: SymbolicState, guard: Term) -> None:
            rest = guard
            for number in range(row.instances):
                slot = self.layout.slots[name, number]
                busy = frame[slot.active]
                here = self.terms.both((rest, self.terms.negation(busy)))
                rest = self.terms.both((rest, busy))
                frame.put(here, slot.active, self.terms.true)
                frame.put(here, slot.stopping, self.terms.false)
                frame.put_all(here, slot.args, newcomer.args)

        return change

    # ---- waiting places and slots ----

    def if_waiting(self, request: int, then: Change, otherwise: Change | None = None) -> Change:
        """Return the part that does `then` if a request waits, else `otherwise`."""
        place = self.layout.places[self.name(request)]

        def change(frame: SymbolicState, guard: Term) -> None:
            taken = frame[place.taken]
            then(frame, self.terms.both((guard, taken)))
            if otherwise is not None:
                otherwise(frame, self.terms.both((guard, self.terms.negation(taken))))

        return change

    def if_running(self, request: int, number: int, then: Change) -> Change:
        """Return the part that does `then` if a slot is running."""
        slot = self.layout.slots[self.name(request), number]

        def change(frame: SymbolicState, guard: Term) -> None:
            then(frame, self.terms.both((guard, frame[slot.active], self.terms.negation(frame[slot.stopping]))))

        return change

    def vacated(self, request: int) -> Change:
        """Return the part that empties the waiting place."""
        place = self.layout.places[self.name(request)]
        return self.assigned_term(place.taken, self.terms.false, place.clearing)

    def stopped(self, request: int, number: int) -> Change:
        """Return the part that sets a slot to stopping."""
        return self.assigned_term(self.layout.slots[self.name(request), number].stopping, self.terms.true)

    def released(self, request: int, number: int, outcome: Ending, results: tuple[Term, ...]) -> Change:
        """Return the part that makes a slot idle and keeps its outcome and, after an ok, past and products."""
        name, row = self.name(request), self.tables.requests[request]
        slot, memory = self.layout.slots[name, number], self.layout.memories[name]

        def change(frame: SymbolicState, guard: Term) -> None:
            args = frame.all(slot.args)
            frame.put(guard, slot.active, self.terms.false)
            frame.put(guard, slot.stopping, self.terms.false)
            frame.put(guard, memory.last, self.terms.constant(OUTCOMES.index(outcome), "Int"))
            if outcome == "ok":
                frame.put(guard, memory.known, self.terms.true)
                frame.put_all(guard, memory.values, (*args, *results))
                looked = RequestArguments(request, (*args, *results))
                for amount in self.tables.amounts[row.produces : row.produces_end]:
                    self._change_level(frame, guard, looked, amount, taken=False)

        return change

    def assigned_term(self, name: str, value: Term, *more: str) -> Change:
        """Return the part that gives a variable, and each of `more`, this value."""

        def change(frame: SymbolicState, guard: Term) -> None:
            for each in (name, *more):
                frame.put(guard, each, value)

        return change

    # ---- what else changes ----

    def consumed(self, newcomer: Newcomer, amount: t.AmountRow) -> Change:
        """Return the part by which the newcomer takes what it consumes."""
        looked = RequestArguments(newcomer.request, newcomer.args)
        return lambda frame, guard: self._change_level(frame, guard, looked, amount, taken=True)

    def _change_level(
        self, frame: SymbolicState, guard: Term, looked: RequestArguments, amount: t.AmountRow, taken: bool
    ) -> None:
        name = level_name(self.vector.stocks[amount.stock])
        here = self.terms.both((guard, self.vector.agrees(frame, amount.predicate, looked)))
        value = self.terms.sum(-amount.amount if taken else amount.amount, ((1, frame[name]),))
        if not taken:
            full = self.terms.constant(self.tables.stocks[amount.stock].capacity, "Int")
            value = self.terms.choose(self.terms.at_most(full, value), full, value)
        frame.put(here, name, value)

    def forgotten(self, request: int) -> Change:
        """Return the part that clears the past of a request."""
        return self.assigned_term(self.layout.memories[self.name(request)].known, self.terms.false)

    def assigned(self, variable: int, value: int) -> Change:
        """Return the part that sets a state of a module to the value of this ordinal."""
        name = self.vector.names[variable]
        kind = self.layout.types[name]
        return self.assigned_term(name, self.layout.value(kind, from_ordinal(kind, value)))

    def latch(self, row: t.LatchRow, clears: bool) -> Change:
        """Return the part that sets a latch where its condition holds and, if it `clears`, clears it elsewhere."""
        name = self.vector.names[row.variable]

        def change(frame: SymbolicState, guard: Term) -> None:
            holds = self.vector.agrees(frame, row.condition, None)
            frame.put(guard, name, holds if clears else self.terms.either((holds, frame[name])))

        return change

    # ---- passes ----

    def following(self, root: int, on: Callable[[Node], Change]) -> Change:
        """Return the part that follows a diagram of the state and does at each action what `on` returns for it."""

        def change(frame: SymbolicState, guard: Term) -> None:
            for node, here in self.vector.walk(frame, guard, root, None):
                on(node)(frame, here)

        return change

    def once_due(self, launch: int, attempt: Change) -> Change:
        """Return the attempt, done (and remembered) if the rule's condition holds and it was not tried in this step."""
        condition = self.tables.launches[launch].condition

        def change(frame: SymbolicState, guard: Term) -> None:
            due = self.vector.agrees(frame, condition, None)
            here = self.terms.both((guard, due, self.terms.negation(frame[tried(launch)])))
            frame.put(here, tried(launch), self.terms.true)
            attempt(frame, here)

        return change

    def required(self, launch: int) -> Change:
        """Return the part that asks for the request of a launch rule."""
        rule = self.model.launches[launch]
        request = self.tables.launches[launch].request
        return self.asked(request, self.layout.values(self.model.requests[request].params, rule.args))
