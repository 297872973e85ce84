"""The semantics of steps by the decoded tables (docs/language.md section 4), for every representation of states.

`StepSemantics` composes an action, a kill, a report or an attempt to launch from parts. A representation defines the
parts: programs over finite variables (`exover.loop.finite.builder`), or changes of a symbolic state
(`exover.loop.exact.actions`). The reference interpreter, the walker of the tables and the checker of certificates are
independent of it and are compared with it.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

from exover.model.decision import BUSY, Reason
from exover.model.event import Ending
from exover.model.model import Model
from exover.model.property import Occurrence
from exover.ocrd import tables as t
from exover.ocrd.tables import NONE, Node, Tables


class AnyNewcomer(Protocol):
    """A request that is decided."""

    @property
    def request(self) -> int:
        """The number of the request."""
        ...

    @property
    def settling(self) -> bool:
        """Whether it is in its waiting place."""
        ...


N = TypeVar("N", bound=AnyNewcomer)
P = TypeVar("P")
"""A part of a step."""


class StepSemantics(ABC, Generic[N, P]):
    """Makes the parts of steps; requests, rules and stocks are numbers of the tables."""

    model: Model
    tables: Tables
    reasons: tuple[Reason, ...]
    may_wait: tuple[bool, ...]
    """For each request whether some decision lets it wait."""
    may_fall: tuple[bool, ...]
    """For each request whether it can fall from clearing to waiting."""

    # ---- parts that a representation defines ----

    @abstractmethod
    def sequence(self, *parts: P) -> P:
        """Return the parts one after the other."""

    @abstractmethod
    def marked(self, *label: str) -> P:
        """Return the part that passes a mark (`exover.model.property.Passed`)."""

    @abstractmethod
    def noted_of(self, occurrence: Occurrence, newcomer: N) -> P:
        """Return the part that notes an occurrence of the newcomer."""

    @abstractmethod
    def noted_in_slot(self, occurrence: Occurrence, request: int, number: int) -> P:
        """Return the part that notes an occurrence of the request in a slot, with its arguments."""

    @abstractmethod
    def refused(self, request: int) -> P:
        """Return the part that notes the rejection of the waiting request, without a mark."""

    @abstractmethod
    def superseded(self, request: int) -> P:
        """Return the part that notes that a newcomer supersedes the waiting request, if one waits."""

    @abstractmethod
    def if_waiting(self, request: int, then: P, otherwise: P | None = None) -> P:
        """Return the part that does `then` if a request waits, else `otherwise`."""

    @abstractmethod
    def if_running(self, request: int, number: int, then: P) -> P:
        """Return the part that does `then` if a slot is running."""

    @abstractmethod
    def unless_fallen(self, newcomer: N, part: P) -> P:
        """Return the part, guarded: it is skipped if the newcomer has fallen to waiting before in this step."""

    @abstractmethod
    def falling(self, newcomer: N, clearing: bool) -> P:
        """Return the part that notes a fall to waiting: the place was clearing and will not be."""

    @abstractmethod
    def put_in_place(self, newcomer: N, clearing: bool) -> P:
        """Return the part that puts or keeps the newcomer in the waiting place; one that fell before stays waiting."""

    @abstractmethod
    def vacated(self, request: int) -> P:
        """Return the part that empties the waiting place."""

    @abstractmethod
    def occupied(self, newcomer: N) -> P:
        """Return the part that lets the newcomer run in the first idle slot."""

    @abstractmethod
    def stopped(self, request: int, number: int) -> P:
        """Return the part that sets a slot to stopping."""

    @abstractmethod
    def consumed(self, newcomer: N, amount: t.AmountRow) -> P:
        """Return the part by which the newcomer takes what it consumes."""

    @abstractmethod
    def forgotten(self, request: int) -> P:
        """Return the part that clears the past of a request."""

    @abstractmethod
    def assigned(self, variable: int, value: int) -> P:
        """Return the part that sets a state of a module to the value of this ordinal."""

    @abstractmethod
    def latch(self, row: t.LatchRow, clears: bool) -> P:
        """Return the part that sets a latch where its condition holds and, if it `clears`, clears it elsewhere."""

    @abstractmethod
    def following(self, root: int, on: Callable[[Node], P]) -> P:
        """Return the part that follows a diagram of the state and does at each action what `on` returns for it."""

    @abstractmethod
    def once_due(self, launch: int, attempt: P) -> P:
        """Return the attempt, done (and remembered) if the rule's condition holds and it was not tried in this step."""

    @abstractmethod
    def required(self, launch: int) -> P:
        """Return the part that asks for the request of a launch rule."""

    # ---- decisions ----

    def act(self, newcomer: N, node: Node) -> P:
        """Return the part that carries out an action of the decision on a newcomer."""
        rule, request = self.reasons[node.bound].rule, newcomer.request
        named = self.sequence() if newcomer.settling else self.marked("rule", rule)
        match -node.code:
            case t.REJECT:
                return self.rejected(newcomer, rule)
            case t.WAIT:
                return self.sequence(named, self.marked("wait", rule), self.kept(newcomer, clearing=False))
            case t.CLEAR:
                return self.sequence(named, self.kept(newcomer, clearing=True))
            case t.SETTLE:
                return self.sequence(named, self.marked("settle", rule), self.kept(newcomer, clearing=True))
            case t.KILL:
                return self.unless_fallen(newcomer, self.killed(node))
            case t.DISMISS:
                return self.dismissed(node.high, rule)
            case t.LAUNCH:
                return self.launched(newcomer, self.model.requests[request].name)
            case code:
                raise AssertionError(f"action {code} in a decision")

    def admitted(self, newcomer: N, decided: P) -> P:
        """Return the decision on an asked request: `busy` if it waits already, unless it interrupts itself."""
        request = newcomer.request
        if not self.may_wait[request] or self.tables.requests[request].interrupts_self:
            return decided
        busy = self.sequence(self.marked("rule", BUSY.rule), self.noted_of("rejected", newcomer))
        return self.if_waiting(request, busy, decided)

    def rejected(self, newcomer: N, rule: str) -> P:
        """Return the part that rejects the newcomer for a rule."""
        marks = (self.marked("rule", rule), self.marked("reject", rule))
        emptied = (self.emptied(newcomer.request),) if newcomer.settling else ()
        return self.sequence(*marks, self.noted_of("rejected", newcomer), *emptied)

    def kept(self, newcomer: N, clearing: bool) -> P:
        """Return the part by which the newcomer waits or, if `clearing`, its way is cleared."""
        if not newcomer.settling:
            return self.sequence(self.superseded(newcomer.request), self.put_in_place(newcomer, clearing))
        falls = (self.falling(newcomer, clearing),) if self.may_fall[newcomer.request] else ()
        return self.sequence(*falls, self.put_in_place(newcomer, clearing))

    def launched(self, newcomer: N, name: str) -> P:
        """Return the part that launches the newcomer, a request of this name."""
        row = self.tables.requests[newcomer.request]
        superseded = () if newcomer.settling else (self.superseded(newcomer.request),)
        return self.sequence(
            self.marked("launch", name),
            *superseded,
            self.emptied(newcomer.request),
            self.noted_of("launched", newcomer),
            *(self.consumed(newcomer, amount) for amount in self.tables.amounts[row.consumes : row.produces]),
            self.occupied(newcomer),
            self.affected(row.on_launch, row.on_ok),
        )

    # ---- waiting places ----

    def left(self, request: int) -> P:
        """Return the part that passes the mark `left`: the waiting request leaves its place."""
        return self.marked("left", self.model.requests[request].name)

    def emptied(self, request: int) -> P:
        """Return the part that empties the waiting place, with the mark `left`."""
        return self.sequence(self.left(request), self.vacated(request))

    def given_up(self, request: int) -> P:
        """Return the part that rejects the waiting request and empties its place."""
        return self.sequence(self.refused(request), self.emptied(request))

    def dismissed(self, request: int, rule: str) -> P:
        """Return the part that gives up the waiting request for a rule, if one waits."""
        if not self.may_wait[request]:
            return self.sequence()
        killed = self.marked("kill", rule, self.model.requests[request].name)
        return self.if_waiting(request, self.sequence(self.marked("rule", rule), killed, self.given_up(request)))

    # ---- slots ----

    def killed(self, node: Node) -> P:
        """Return the part that kills the slots which a node names, for its rule."""
        rule = self.reasons[node.bound].rule
        return self.sequence(
            *(
                self.kill(request, number, rule)
                for request, row in enumerate(self.tables.requests)
                for number in range(row.instances)
                if node.high == request or -1 - node.high == row.slots + number
            )
        )

    def kill(self, request: int, number: int, rule: str | None) -> P:
        """Return the part that kills a slot if it runs, for a rule or (None) for an abort."""
        name = self.model.requests[request].name
        marks = (self.marked("rule", rule), self.marked("kill", rule, name)) if rule else ()
        noted = self.noted_in_slot("killed", request, number)
        return self.if_running(request, number, self.sequence(*marks, noted, self.stopped(request, number)))

    def report(self, request: int, number: int, outcome: Ending, released: P) -> P:
        """Return the part of a report; `released`: makes the slot idle and keeps what it leaves behind."""
        row = self.tables.requests[request]
        edges = {"ok": (row.on_ok, row.on_failed), "failed": (row.on_failed, row.on_interrupted)}
        return self.sequence(
            self.noted_in_slot("ended", request, number),
            released,
            self.affected(*edges.get(outcome, (row.on_interrupted, row.effects_end))),
            self.latched(request if outcome == "ok" else NONE),
        )

    def affected(self, start: int, end: int) -> P:
        """Return the effects of `on` clauses, in order."""
        return self.sequence(
            *(
                self.forgotten(each.target) if each.kind == t.FORGET else self.assigned(each.target, each.value)
                for each in self.tables.effects[start:end]
            )
        )

    def latched(self, cleared_by: int) -> P:
        """Return the part that updates all latches, after a report ok of `cleared_by` or (NONE) after another event."""
        rows = self.tables.latches
        return self.sequence(
            *(self.latch(row, cleared_by in self.tables.lists[row.resets : row.resets_end]) for row in rows)
        )

    # ---- passes ----

    def restored(self, rule: int) -> P:
        """Return the part that restores a rule by kills, where it is broken."""
        root = self.tables.rules[rule].root
        return self.following(root, lambda node: self.killed(node) if node.code == -t.KILL else self.sequence())

    def tried(self, launch: int) -> P:
        """Return the part by which a launch rule asks for its request, if it is due."""
        rule = self.reasons[self.tables.launches[launch].reason].rule
        return self.once_due(launch, self.sequence(self.marked("rule", rule), self.required(launch)))
