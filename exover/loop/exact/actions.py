"""What the decoded tables do: decisions carried out, slots killed, latches set (docs/language.md section 4).

Every function changes a `SymbolicState` where `guard` holds. Marks and notes are those of `ClosedLoop`.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from exover.loop.exact.layout import Layout, level_name
from exover.loop.exact.symbolic_state import SymbolicState
from exover.loop.exact.table_encoding import RequestArguments, TableEncoding
from exover.loop.exact.term import Term
from exover.model.decision import BUSY
from exover.model.event import Ending
from exover.model.index import ModelIndex
from exover.model.types import from_ordinal
from exover.ocrd import tables as t
from exover.ocrd.reasons import reasons
from exover.ocrd.tables import NONE, Node
from exover.ocrd.vector import OUTCOMES


def tried(launch: int) -> str:
    """Return the name of what a step remembers of a required launch."""
    return f"tried {launch}"


def fallen(request: str) -> str:
    """Return the name of what a step remembers of a request that fell from clearing to waiting."""
    return f"fallen {request}"


@dataclass(frozen=True, slots=True)
class Newcomer:
    """A request that is decided; `required`: the number of the launch rule; `settling`: it stands in its place."""

    request: int
    args: tuple[Term, ...]
    required: int | None = None
    settling: bool = False


class Observer(Protocol):
    """Looks on at every moment at which something is decided, and may pass marks of its own."""

    def decides(self, acts: "TableActions", frame: SymbolicState, guard: Term, newcomer: Newcomer) -> None:
        """A newcomer is about to be decided where `guard` holds."""
        ...

    def restores(self, acts: "TableActions", frame: SymbolicState) -> None:
        """The rules are about to be restored, at the beginning of a pass."""
        ...


@dataclass
class TableActions:
    """The parts of events and of passes."""

    vector: TableEncoding
    observer: Observer | None = None

    def __post_init__(self) -> None:
        self.layout: Layout = self.vector.layout
        self.model, self.tables, self.terms = self.layout.model, self.vector.tables, self.layout.terms
        self.reasons = reasons(self.model)

    @cached_property
    def number(self) -> dict[str, int]:
        """The numbers of the requests by name."""
        return ModelIndex(self.model).request

    @cached_property
    def may_wait(self) -> tuple[bool, ...]:
        """By request whether some decision lets it wait."""
        return tuple(self._has(row.decide, {t.WAIT, t.CLEAR, t.SETTLE}) for row in self.tables.requests)

    @cached_property
    def may_fall(self) -> tuple[bool, ...]:
        """By request whether it can fall from clearing to waiting."""
        rows = self.tables.requests
        return tuple(self._has(r.decide, {t.WAIT}) and self._has(r.decide, {t.CLEAR, t.SETTLE}) for r in rows)

    def _has(self, root: int, codes: set[int]) -> bool:
        return any(-self.tables.nodes[number].code in codes for number in self.tables.below(root))

    def name(self, request: int) -> str:
        """Return the name of a request."""
        return self.model.requests[request].name

    # ---- decisions ----

    def ask(
        self, frame: SymbolicState, guard: Term, request: int, args: tuple[Term, ...], required: int | None = None
    ) -> None:
        """Handle an ask, or what a launch rule asks for."""
        name = self.name(request)
        if required is not None:
            frame.mark(guard, "rule", self.reasons[self.tables.launches[required].reason].rule)
        if self.may_wait[request] and not self.tables.requests[request].interrupts_self:
            taken = frame[self.layout.places[name].taken]
            busy = self.terms.both((guard, taken))
            frame.mark(busy, "rule", BUSY.rule)
            frame.note(busy, "rejected", name, args)
            guard = self.terms.both((guard, self.terms.negation(taken)))
        self.decide(frame, guard, Newcomer(request, args, required))

    def settle(self, request: int, frame: SymbolicState) -> None:
        """Decide what stands in the waiting place."""
        place = self.layout.places[self.name(request)]
        self.decide(frame, frame[place.taken], Newcomer(request, frame.all(place.args), settling=True))

    def decide(self, frame: SymbolicState, guard: Term, newcomer: Newcomer) -> None:
        """Decide on a newcomer and carry the decision out."""
        if self.observer is not None:
            self.observer.decides(self, frame, guard, newcomer)
        looked = RequestArguments(newcomer.request, newcomer.args)
        actions = self.vector.walk(frame, guard, self.tables.requests[newcomer.request].decide, looked)
        stays = self.terms.false
        if newcomer.settling and self.may_fall[newcomer.request]:
            stays = frame[fallen(self.name(newcomer.request))]
        for node, here in actions:
            self._act(frame, here, stays, newcomer, node)

    def _act(self, frame: SymbolicState, here: Term, stays: Term, newcomer: Newcomer, node: Node) -> None:
        """Do an action of a decision; where the request fell before in this step (`stays`) it clears nothing."""
        rule, name, settling = self.reasons[node.bound].rule, self.name(newcomer.request), newcomer.settling
        clearing = self.terms.both((here, self.terms.negation(stays)))
        match -node.code:
            case t.REJECT:
                frame.mark(here, "rule", rule)
                frame.mark(here, "reject", rule)
                frame.note(here, "rejected", name, newcomer.args)
                if settling:
                    self._empty(frame, here, newcomer.request)
            case t.WAIT | t.CLEAR | t.SETTLE:
                if not settling:
                    frame.mark(here, "rule", rule)
                if node.code != -t.CLEAR:
                    frame.mark(here, "wait" if node.code == -t.WAIT else "settle", rule)
                self._stand(frame, here, newcomer, self.terms.false if node.code == -t.WAIT else clearing)
            case t.KILL:
                self.kill_target(frame, clearing, node)
            case t.DISMISS:
                self._dismiss(frame, here, node.high, rule)
            case t.LAUNCH:
                self._launch(frame, here, newcomer)
            case code:
                raise AssertionError(f"action {code} in a decision")

    def _stand(self, frame: SymbolicState, guard: Term, newcomer: Newcomer, clearing: Term) -> None:
        """Let the newcomer take, or keep, the waiting place, clearing where that holds."""
        name = self.name(newcomer.request)
        place = self.layout.places[name]
        if newcomer.settling:
            if self.may_fall[newcomer.request]:
                falls = (guard, frame[place.clearing], self.terms.negation(clearing))
                frame.put(self.terms.both(falls), fallen(name), self.terms.true)
        else:
            self._supersede(frame, guard, newcomer.request)
            frame.put_all(guard, place.args, newcomer.args)
        frame.put(guard, place.taken, self.terms.true)
        frame.put(guard, place.clearing, clearing)

    def _supersede(self, frame: SymbolicState, guard: Term, request: int) -> None:
        if self.may_wait[request]:
            frame.mark(guard, "left", self.name(request))
            self.refuse(frame, guard, request)

    def refuse(self, frame: SymbolicState, guard: Term, request: int) -> None:
        """Note that what stands in the waiting place, if something does, is rejected."""
        place = self.layout.places[self.name(request)]
        frame.note(self.terms.both((guard, frame[place.taken])), "rejected", self.name(request), frame.all(place.args))

    def _empty(self, frame: SymbolicState, guard: Term, request: int) -> None:
        place = self.layout.places[self.name(request)]
        frame.mark(guard, "left", self.name(request))
        frame.put(guard, place.taken, self.terms.false)
        frame.put(guard, place.clearing, self.terms.false)

    def _dismiss(self, frame: SymbolicState, guard: Term, request: int, rule: str) -> None:
        if self.may_wait[request]:
            here = self.terms.both((guard, frame[self.layout.places[self.name(request)].taken]))
            frame.mark(here, "rule", rule)
            frame.mark(here, "kill", rule, self.name(request))
            self.give_up(frame, here, request)

    def give_up(self, frame: SymbolicState, guard: Term, request: int) -> None:
        """Reject what stands in the waiting place."""
        self.refuse(frame, guard, request)
        self._empty(frame, guard, request)

    def _launch(self, frame: SymbolicState, guard: Term, newcomer: Newcomer) -> None:
        request, row = newcomer.request, self.tables.requests[newcomer.request]
        name = self.name(request)
        frame.mark(guard, "launch", name)
        if not newcomer.settling:
            self._supersede(frame, guard, request)
        self._empty(frame, guard, request)
        frame.note(guard, "launched", name, newcomer.args)
        for amount in self.tables.amounts[row.consumes : row.produces]:
            self._change_level(frame, guard, RequestArguments(request, newcomer.args), amount, taken=True)
        rest = guard
        for number in range(row.instances):
            slot = self.layout.slots[name, number]
            busy = frame[slot.active]
            here = self.terms.both((rest, self.terms.negation(busy)))
            rest = self.terms.both((rest, busy))
            frame.put(here, slot.active, self.terms.true)
            frame.put(here, slot.stopping, self.terms.false)
            frame.put_all(here, slot.args, newcomer.args)
        self._affect(frame, guard, row.on_launch, row.on_ok)

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

    def _affect(self, frame: SymbolicState, guard: Term, start: int, end: int) -> None:
        for effect in self.tables.effects[start:end]:
            if effect.kind == t.FORGET:
                frame.put(guard, self.layout.memories[self.name(effect.target)].known, self.terms.false)
            else:
                name = self.vector.names[effect.target]
                kind = self.layout.types[name]
                frame.put(guard, name, self.layout.value(kind, from_ordinal(kind, effect.value)))

    # ---- slots ----

    def kill_target(self, frame: SymbolicState, guard: Term, node: Node) -> None:
        """Kill the slots that a node names."""
        for request, row in enumerate(self.tables.requests):
            for number in range(row.instances):
                if node.high == request or -1 - node.high == row.slots + number:
                    self.kill(frame, guard, request, number, self.reasons[node.bound].rule)

    def kill(self, frame: SymbolicState, guard: Term, request: int, number: int, rule: str | None) -> None:
        """Kill a slot, if it runs, for a rule or for an abort."""
        name = self.name(request)
        slot = self.layout.slots[name, number]
        here = self.terms.both((guard, frame[slot.active], self.terms.negation(frame[slot.stopping])))
        if rule is not None:
            frame.mark(here, "rule", rule)
            frame.mark(here, "kill", rule, name)
        frame.note(here, "killed", name, frame.all(slot.args))
        frame.put(here, slot.stopping, self.terms.true)

    def report(
        self, frame: SymbolicState, request: int, number: int, outcome: Ending, results: tuple[Term, ...]
    ) -> None:
        """End a slot that is active."""
        name, row, yes = self.name(request), self.tables.requests[request], self.terms.true
        slot, memory = self.layout.slots[name, number], self.layout.memories[name]
        args = frame.all(slot.args)
        frame.note(yes, "ended", name, args)
        frame.put(yes, slot.active, self.terms.false)
        frame.put(yes, slot.stopping, self.terms.false)
        frame.put(yes, memory.last, self.terms.constant(OUTCOMES.index(outcome), "Int"))
        if outcome == "ok":
            frame.put(yes, memory.known, yes)
            frame.put_all(yes, memory.values, (*args, *results))
            for amount in self.tables.amounts[row.produces : row.produces_end]:
                self._change_level(frame, yes, RequestArguments(request, (*args, *results)), amount, taken=False)
        edges = {"ok": (row.on_ok, row.on_failed), "failed": (row.on_failed, row.on_interrupted)}
        self._affect(frame, yes, *edges.get(outcome, (row.on_interrupted, row.effects_end)))
        self.latch(frame, request if outcome == "ok" else NONE)

    def latch(self, frame: SymbolicState, cleared_by: int) -> None:
        """Set and clear the latches after a report ok of `cleared_by`, or after something else."""
        for latch in self.tables.latches:
            name = self.vector.names[latch.variable]
            holds = self.vector.agrees(frame, latch.condition, None)
            clears = cleared_by in self.tables.lists[latch.resets : latch.resets_end]
            frame.put(self.terms.true, name, holds if clears else self.terms.either((holds, frame[name])))
