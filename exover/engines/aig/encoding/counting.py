"""One step of the graph that counts what it costs: every test of a walk, every answer.

The tests of walks are counted one by one; what slots and waiting places cost is taken from the tables (`Costs`).
"""

from collections.abc import Iterable, Iterator
from dataclasses import field
from functools import cached_property

from exover.bounds.costs import Costs
from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import TRUE, Literal
from exover.engines.aig.circuit.words import Word, as_word, lit
from exover.engines.aig.encoding.encoder import Encoding
from exover.loop.exact.actions import Newcomer, TableActions, tried
from exover.loop.exact.events import RESTORING, Part
from exover.loop.exact.symbolic_state import SymbolicState
from exover.loop.exact.table_encoding import RequestArguments
from exover.loop.exact.term import Term
from exover.model.property import Label
from exover.ocrd import tables as t

_WAITING = (t.WAIT, t.CLEAR, t.SETTLE)


@dataclass
class CostObserver:
    """Marks every test of a walk, and what is told to wait: each passed mark counts once."""

    moment: tuple[str, ...] = ("event",)
    ran: Term | None = None
    """Where the present pass is run; None: everywhere."""

    def decides(self, actions: TableActions, frame: SymbolicState, guard: Term, newcomer: Newcomer) -> None:
        """Count the tests of a decision, and a newcomer that waits."""
        looked = RequestArguments(newcomer.request, newcomer.args)
        root = actions.tables.requests[newcomer.request].decide
        arrivals = self.walks(actions, frame, guard, root, looked)
        if newcomer.settling:
            self._mark(actions, frame, guard, "turns", str(newcomer.request))
            return
        waits = [here for node, here in arrivals if -node.code in _WAITING]
        self._mark(actions, frame, actions.terms.either(waits), "waits", str(newcomer.request))

    def restores(self, actions: TableActions, frame: SymbolicState) -> None:
        """Do nothing: rules are counted one by one."""

    def walks(
        self,
        actions: TableActions,
        frame: SymbolicState,
        guard: Term,
        root: int,
        looked: RequestArguments | None = None,
    ) -> list[tuple[t.Node, Term]]:
        """Count the tests of a walk, and return the nodes that it may come to, each with where it does."""
        arrivals = actions.vector.arrivals(frame, guard, root, looked) if root >= 0 else []
        for number, (node, here) in enumerate(arrivals):
            if node.code >= 0:
                self._mark(actions, frame, here, "test", str(number), str(root))
        return arrivals

    def _mark(self, actions: TableActions, frame: SymbolicState, guard: Term, *label: str) -> None:
        here = guard if self.ran is None else actions.terms.both((self.ran, guard))
        frame.mark(here, *label, *self.moment)


@dataclass
class CountingEncoding(Encoding):
    """The graph of a step that counts what it costs; one more pass follows the others, which must change nothing."""

    observer: CostObserver = field(default_factory=CostObserver)
    ran: list[Literal] = field(default_factory=list)
    """By pass a literal: it is run, for it is the first, or all before it have changed something."""

    def _settle(self) -> None:
        changed = TRUE
        for number in range(self.passes + 1):
            self.ran.append(self.graph.conjunction(self.ran[-1], changed) if self.ran else TRUE)
            self.observer.ran = self.terms.bit(self.ran[-1])
            changed = self.graph.any(list(self._pass(number)))
        self._unsettled = (changed,)

    def _pass(self, number: int) -> Iterator[Literal]:
        """Run all parts, and yield where they change the state."""
        rows, frame = self.actions.tables, self._frame
        roots = [*(rule.root for rule in rows.rules), *(launch.condition for launch in rows.launches)]
        for place, part in enumerate(self._acting):
            before, launch = dict(frame.values), place - len(rows.rules)
            self.observer.moment = (str(number), str(place))
            if place < len(roots):
                again = frame[tried(launch)] if launch >= 0 else self.terms.false
                self.observer.walks(self.actions, frame, self.terms.negation(again), roots[place])
            part.run(frame)
            for name in frame.written(before):
                frame.values[name] = self._narrowed(name, frame.values[name], self.terms.true)
                if name in self.latches.vars:
                    yield lit(self.terms.equal(frame.values[name], before[name])) ^ 1

    @cached_property
    def _acting(self) -> list[Part]:
        """The parts of a pass: rules, launches, waiting places."""
        return [part for part in self._parts if part.name != RESTORING]

    @cached_property
    def stable(self) -> Literal:
        """Where before a step no rule changes the state, nor a waiting place but those that may fall from clearing."""
        rules, launches = len(self.actions.tables.rules), len(self.actions.tables.launches)
        waiting = [request for request, may in enumerate(self.actions.may_wait) if may]
        spontaneous = [self.actions.may_fall[request] for request in waiting]
        asked = [*[True] * rules, *[False] * launches, *(not each for each in spontaneous)]
        same: list[Literal] = []
        for part, is_asked in zip(self._acting, asked, strict=True):
            if is_asked:
                frame = SymbolicState(self.terms, dict(self._present))
                part.run(frame)
                same += [lit(self.terms.equal(value, self._present[n])) for n, value in frame.values.items()]
        return self.graph.all(same)

    def lasting(self, values: dict[str, Term]) -> Literal:
        """Return where nothing is active together that a launch rules out: by bit rows, and by rules that only launches
        could break."""
        rows, terms = self.actions.tables, self.terms
        frame = SymbolicState(terms, values)
        broken = [
            here
            for rule in rows.invariants
            for node, here in self.actions.vector.walk(frame, terms.true, rule.root, None)
            if node.code == -t.VIOLATION
        ]
        active = [self._active(frame, request) for request in range(len(rows.requests))]
        for number, here in enumerate(active):
            others = sorted(rows.conflicting(number) - {number})
            broken += [terms.both((here, active[other])) for other in others]
        return lit(terms.either(broken)) ^ 1

    def _active(self, frame: SymbolicState, request: int) -> Term:
        name = self.actions.name(request)
        return self.terms.either(frame[slot.active] for (owner, _), slot in self.latches.slots.items() if owner == name)

    @property
    def states(self) -> tuple[Literal, Literal]:
        """What `lasting` says of the state before a step, and after it."""
        return self.lasting(dict(self._present)), self.lasting(dict(self.after))

    # ---- sums ----

    def tests(self, cost: Costs) -> Word:
        """Return the number of tests of a step, without those that are known from the kind of its event."""
        marks = {"test": lambda _: 1, "waits": cost.place.__getitem__, "turns": lambda number: 2 * cost.place[number]}
        counted = [(marks[kind](int(number)), where) for (kind, number, *_), where in self._counted]
        notes = {
            "rejected": cost.place.__getitem__,
            "launched": lambda number: cost.place[number] + cost.launch(number).tests,
            "killed": lambda number: 2 * cost.slot[number],
        }
        for note in self._frame.notes:
            if note.occurrence in notes:
                counted.append((notes[note.occurrence](self.actions.number[note.request]), note.guard))
        return self._sum(counted)

    def answers(self) -> Word:
        """Return the number of launches, kills, rejections, waits and violations that a step answers with."""
        told = [note.guard for note in self._frame.notes if note.occurrence in ("rejected", "launched", "killed")]
        told += [where for (kind, *_), where in self._counted if kind == "waits"]
        return self._sum([(1, where) for where in (*told, *self._violated)])

    @property
    def _counted(self) -> list[tuple[Label, Term]]:
        return [(label, where) for label, where in self._frame.marks.items() if label[0] in ("test", "waits", "turns")]

    @property
    def _violated(self) -> list[Term]:
        """By reason where a step says at its end that a rule is broken."""
        found: dict[int, list[Term]] = {}
        for rule in self.actions.tables.rules:
            for node, here in self.actions.vector.walk(self._frame, self.terms.true, rule.root, None):
                if node.code == -t.VIOLATION:
                    found.setdefault(rule.reason, []).append(here)
        return [self.terms.either(broken) for broken in found.values()]

    def _sum(self, counted: Iterable[tuple[int, Term]]) -> Word:
        return as_word(self.terms.sum(0, [(much, where) for much, where in counted if much]))
