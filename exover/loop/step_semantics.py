"""What the decoded tables do in a step (docs/language.md section 4), told once for every representation of states.

`StepSemantics` says of which parts an action, a kill, a report or an attempt to launch consists, and in which order. A
representation says what the parts are: programs over finite variables (`exover.loop.finite.builder`), or changes of a
symbolic state (`exover.loop.exact.actions`). The reference interpreter, the walker of the tables and the checker of
certificates share nothing with it: they are compared with it.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from typing import Generic, Protocol, TypeVar

from exover.model.decision import BUSY, Reason
from exover.model.event import Ending
from exover.model.model import Model
from exover.model.property import Occurrence
from exover.ocrd import tables as t
from exover.ocrd.tables import NONE, Node, Tables


class AnyNewcomer(Protocol):
    """A request that is decided; `settling`: it stands in its waiting place."""

    @property
    def request(self) -> int:
        """The number of the request."""
        ...

    @property
    def settling(self) -> bool:
        """Whether it stands in its waiting place."""
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
    """By request whether some decision lets it wait."""
    may_fall: tuple[bool, ...]
    """By request whether it can fall from clearing to waiting."""

    # ---- what a representation says ----

    @abstractmethod
    def sequence(self, *parts: P) -> P:
        """Return the parts one after the other."""

    @abstractmethod
    def marked(self, *label: str) -> P:
        """Return that a mark is passed (`exover.model.property.Passed`)."""

    @abstractmethod
    def noted_of(self, occurrence: Occurrence, newcomer: N) -> P:
        """Return that this has happened to the newcomer."""

    @abstractmethod
    def noted_in_slot(self, occurrence: Occurrence, request: int, number: int) -> P:
        """Return that this has happened to what a slot holds."""

    @abstractmethod
    def refused(self, request: int) -> P:
        """Return that what stands in the waiting place is rejected, without a mark."""

    @abstractmethod
    def superseded(self, request: int) -> P:
        """Return that what stands in the waiting place, if something does, is driven out by a newcomer."""

    @abstractmethod
    def if_waiting(self, request: int, then: P, otherwise: P | None = None) -> P:
        """Return `then` where the waiting place is taken, and `otherwise` where it is not."""

    @abstractmethod
    def if_running(self, request: int, number: int, then: P) -> P:
        """Return `then` where a slot is running."""

    @abstractmethod
    def unless_fallen(self, newcomer: N, part: P) -> P:
        """Return a part that is left out where the newcomer fell to waiting before in this step."""

    @abstractmethod
    def falling(self, newcomer: N, clearing: bool) -> P:
        """Return that the newcomer falls to waiting, where its place was clearing and is not to be any more."""

    @abstractmethod
    def put_in_place(self, newcomer: N, clearing: bool) -> P:
        """Return that the newcomer takes, or keeps, the waiting place; one that fell before stays waiting."""

    @abstractmethod
    def vacated(self, request: int) -> P:
        """Return that the waiting place is empty."""

    @abstractmethod
    def occupied(self, newcomer: N) -> P:
        """Return that the newcomer runs in the first slot that is idle."""

    @abstractmethod
    def stopped(self, request: int, number: int) -> P:
        """Return that a slot is stopping."""

    @abstractmethod
    def consumed(self, newcomer: N, amount: t.AmountRow) -> P:
        """Return that the newcomer takes what it consumes."""

    @abstractmethod
    def forgotten(self, request: int) -> P:
        """Return that the past of a request is empty."""

    @abstractmethod
    def assigned(self, variable: int, value: int) -> P:
        """Return that a state of a module has the value of this ordinal."""

    @abstractmethod
    def latch(self, row: t.LatchRow, clears: bool) -> P:
        """Return that a latch is set where its condition holds, and elsewhere cleared if it `clears`."""

    @abstractmethod
    def following(self, root: int, on: Callable[[Node], P]) -> P:
        """Return the walk through a diagram of the state; at an action what `on` has for it."""

    @abstractmethod
    def once_due(self, launch: int, attempt: P) -> P:
        """Return the attempt where the condition of a launch rule holds that was not tried before in this step."""

    @abstractmethod
    def required(self, launch: int) -> P:
        """Return the ask for what a launch rule launches."""

    # ---- decisions ----

    def act(self, newcomer: N, node: Node) -> P:
        """Return what an action of a decision on a newcomer does."""
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
        """Return the decision on a request that comes; it is busy if the waiting place is taken for good."""
        request = newcomer.request
        if not self.may_wait[request] or self.tables.requests[request].interrupts_self:
            return decided
        busy = self.sequence(self.marked("rule", BUSY.rule), self.noted_of("rejected", newcomer))
        return self.if_waiting(request, busy, decided)

    def rejected(self, newcomer: N, rule: str) -> P:
        """Return that the newcomer is rejected for a rule."""
        marks = (self.marked("rule", rule), self.marked("reject", rule))
        emptied = (self.emptied(newcomer.request),) if newcomer.settling else ()
        return self.sequence(*marks, self.noted_of("rejected", newcomer), *emptied)

    def kept(self, newcomer: N, clearing: bool) -> P:
        """Return that the newcomer waits, or its way is cleared."""
        if not newcomer.settling:
            return self.sequence(self.superseded(newcomer.request), self.put_in_place(newcomer, clearing))
        falls = (self.falling(newcomer, clearing),) if self.may_fall[newcomer.request] else ()
        return self.sequence(*falls, self.put_in_place(newcomer, clearing))

    def launched(self, newcomer: N, name: str) -> P:
        """Return that the newcomer, a request of this name, is launched."""
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
        """Return the mark that what stands in the waiting place does so no longer."""
        return self.marked("left", self.model.requests[request].name)

    def emptied(self, request: int) -> P:
        """Return that nothing stands in the waiting place any longer."""
        return self.sequence(self.left(request), self.vacated(request))

    def given_up(self, request: int) -> P:
        """Return that what stands in the waiting place is rejected."""
        return self.sequence(self.refused(request), self.emptied(request))

    def dismissed(self, request: int, rule: str) -> P:
        """Return that what stands in the waiting place, if something does, is given up for a rule."""
        if not self.may_wait[request]:
            return self.sequence()
        killed = self.marked("kill", rule, self.model.requests[request].name)
        return self.if_waiting(request, self.sequence(self.marked("rule", rule), killed, self.given_up(request)))

    # ---- slots ----

    def killed(self, node: Node) -> P:
        """Return that the slots which a node names are killed for its rule."""
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
        """Return that a slot is killed, if it runs, for a rule or for an abort."""
        name = self.model.requests[request].name
        marks = (self.marked("rule", rule), self.marked("kill", rule, name)) if rule else ()
        noted = self.noted_in_slot("killed", request, number)
        return self.if_running(request, number, self.sequence(*marks, noted, self.stopped(request, number)))

    def report(self, request: int, number: int, outcome: Ending, released: P) -> P:
        """Return that a slot has ended; `released`: that it is idle, and what it leaves behind."""
        row = self.tables.requests[request]
        edges = {"ok": (row.on_ok, row.on_failed), "failed": (row.on_failed, row.on_interrupted)}
        return self.sequence(
            self.noted_in_slot("ended", request, number),
            released,
            self.affected(*edges.get(outcome, (row.on_interrupted, row.effects_end))),
            self.latched(request if outcome == "ok" else NONE),
        )

    def affected(self, start: int, end: int) -> P:
        """Return what `on` clauses do, in order."""
        return self.sequence(
            *(
                self.forgotten(each.target) if each.kind == t.FORGET else self.assigned(each.target, each.value)
                for each in self.tables.effects[start:end]
            )
        )

    def latched(self, cleared_by: int) -> P:
        """Return that the latches are set and cleared, after a report ok of `cleared_by` or after something else."""
        rows = self.tables.latches
        return self.sequence(
            *(self.latch(row, cleared_by in self.tables.lists[row.resets : row.resets_end]) for row in rows)
        )

    # ---- passes ----

    def restored(self, rule: int) -> P:
        """Return that what restores a rule is killed, where it is broken."""
        root = self.tables.rules[rule].root
        return self.following(root, lambda node: self.killed(node) if node.code == -t.KILL else self.sequence())

    def tried(self, launch: int) -> P:
        """Return that a launch rule asks for its request, if it is due."""
        rule = self.reasons[self.tables.launches[launch].reason].rule
        return self.once_due(launch, self.sequence(self.marked("rule", rule), self.required(launch)))


def may_wait(tables: Tables) -> tuple[bool, ...]:
    """Return by request whether some decision lets it wait."""
    return tuple(bool(codes & {t.WAIT, t.CLEAR, t.SETTLE}) for codes in _codes(tables))


def may_fall(tables: Tables) -> tuple[bool, ...]:
    """Return by request whether it can fall from clearing to waiting."""
    return tuple(t.WAIT in codes and bool(codes & {t.CLEAR, t.SETTLE}) for codes in _codes(tables))


def _codes(tables: Tables) -> Iterator[set[int]]:
    """Yield by request the actions of its decisions."""
    for row in tables.requests:
        yield {-tables.nodes[number].code for number in tables.below(row.decide)}
