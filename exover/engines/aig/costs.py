"""What events cost at most: tests and answers, as the greatest sum over every state that a step may leave.

One step of the graph counts what it costs (`CountingEncoding`), so costs add up only if some state lets them occur in
one step. A state that a step may leave is one in which no rule that kills, and nothing that waits, has anything left to
do, and in which nothing is active together that a launch rules out. Whether a run comes to such a state is not asked,
so the figures are upper bounds; those of the tables alone hold besides.
"""

from functools import partial

from exover.bounds.costs import Costs
from exover.bounds.events import Bound, EventBounds, bounds
from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import TRUE, Literal
from exover.engines.aig.circuit.solver import Exhausted, Solver
from exover.engines.aig.circuit.words import lit
from exover.engines.aig.encoding.counting import CostObserver, CountingEncoding
from exover.model.index import ModelIndex
from exover.model.property import NO_PROPERTIES
from exover.ocrd import tables as t
from exover.ocrd.compile import Compiled
from exover.ocrd.tables import Tables

MOST_PASSES = 6
"""Passes after which a step is not looked at any further."""
MOST_ENTRIES, MOST_NODES = 600, 6_000
"""The numbers of entries and nodes in the tables above which a graph would be too large."""
BUDGET = 5_000_000
"""Propagations of the solver for all bounds of a spec: some half a second."""

STATES, CUT_OFF = "steps from every state that a step may leave", ", as far as the solver came"
"""How bounds are found here."""
NEVER = Bound(0, 1, 0)
"""What an event costs that is always invalid."""


def tightened(compiled: Compiled, budget: int = BUDGET) -> EventBounds:
    """Return the bounds of every event: those of the tables, less where no state lets an event cost so much."""
    tables = compiled.tables
    known = bounds(tables)
    if not _settles(tables) or len(tables.entries) > MOST_ENTRIES or len(tables.nodes) > MOST_NODES:
        return known
    for passes in range(1, MOST_PASSES):
        found = _Maxima(CountingEncoding(compiled, NO_PROPERTIES, passes, CostObserver()), budget, known)
        try:
            if found.settles():
                return found.bounds()
        except Exhausted:
            return known
        finally:
            found.solver.close()
    return known


def _settles(tables: Tables) -> bool:
    """Return whether a step may do more than what its event does itself: else the bounds of the tables are attained."""
    waits = {t.WAIT, t.CLEAR, t.SETTLE, t.KILL, t.DISMISS}
    return bool(tables.rules or tables.launches or any(-node.code in waits for node in tables.nodes))


@dataclass
class _Maxima:
    """The greatest sums of one graph."""

    encoding: CountingEncoding
    left: int
    """Propagations that may still be spent."""
    known: EventBounds
    _lasting: bool = True

    def __post_init__(self) -> None:
        encoding, tables = self.encoding, self.encoding.actions.tables
        graph, terms = encoding.graph, encoding.terms
        self.cost = Costs(tables)
        self.sums = {"tests": encoding.tests(self.cost), "answers": encoding.answers()}
        self.least = {
            name: [lit(terms.at_most(terms.constant(k, "Int"), word)) for k in range(word.high + 2)]
            for name, word in self.sums.items()
        }
        self.before, self.after = encoding.states
        self.step = graph.all((encoding.stable, encoding.moments.domain, encoding.legal))
        self.unsettled = encoding.unsettled
        self.kinds: dict[tuple[str, str], Literal] = {}
        for event in encoding.events:
            key = (event.kind.verb, event.kind.name)
            self.kinds[key] = graph.any((self.kinds.get(key, 0), lit(event.chosen)))
        self.solver = Solver(encoding.circuit([]))

    def _some(self, *literals: Literal) -> bool:
        """Return whether a step makes all of these true. Raises `Exhausted`."""
        if self.left <= 0:
            raise Exhausted
        done = self.solver.work
        asked = [self.step, *([self.before] if self._lasting else []), *literals]
        try:
            return self.solver.possible(asked, self.left)
        finally:
            self.left -= self.solver.work - done

    def settles(self) -> bool:
        """Return whether the last pass never changes anything; `lasting` is assumed of states if it is inductive."""
        latches = self.encoding.graph.latches
        start = [2 * node + (not initial) for node, initial in latches]
        self._lasting = False
        if self._some(self.before ^ 1, *start):
            return not self._some(self.unsettled)
        self._lasting = True
        if self._some(self.unsettled):
            return False
        if self._some(self.after ^ 1):
            self._lasting = False
            return not self._some(self.unsettled)
        return True

    # ---- by event ----

    def bounds(self) -> EventBounds:
        """Return the bounds of every event: those that are known, or less."""
        tables, cost = self.encoding.actions.tables, self.cost
        self.known = known = bounds(tables, self._passes(self.known.worst.passes, TRUE))
        index = ModelIndex(self.encoding.compiled.model)
        names, stocks = index.requests, index.stocks
        reports = [cost.report(number).tests for number in range(len(names))]
        levels = [cost.level(number).tests for number in range(len(stocks))]
        self.most = self._less(known.worst, TRUE)
        return EventBounds(
            asks=tuple(map(partial(self._bound, "ask"), names, known.asks)),
            reports=tuple(map(partial(self._bound, "report"), names, known.reports, reports)),
            aborts=tuple(map(partial(self._bound, "abort"), names, known.aborts)),
            withdrawals=tuple(map(partial(self._bound, "abort waiting"), names, known.withdrawals)),
            readings=tuple(map(self._reading, range(len(known.readings)))),
            levels=tuple(map(partial(self._bound, "observe level"), stocks, known.levels, levels)),
            method=f"{STATES}{'' if self.left > 0 else CUT_OFF}",
        )

    def _reading(self, number: int) -> Bound:
        """Return the bound of an observation; of a module state or a latch there is none."""
        row, known = self.encoding.actions.tables.variables[number], self.known.readings[number]
        if row.role != t.POSTER:
            return NEVER
        name = self.encoding.compiled.model.variables[number].name
        return self._bound("observe", name, known, self.cost.reading(number).tests, row.has_fallback)

    def _bound(self, verb: str, name: str, known: Bound, tests: int = 0, answers: int = 0) -> Bound:
        """Return the bound of an event; `tests`, `answers`: what it costs beside what the graph counts."""
        if (verb, name) not in self.kinds:
            return NEVER
        most = self.most
        most = Bound(min(known.tests - tests, most.tests), min(known.answers - answers, most.answers), known.passes)
        found = self._less(most, self.kinds[verb, name])
        return Bound(tests + found.tests, max(1, answers + found.answers), found.passes)

    def _less(self, most: Bound, where: Literal) -> Bound:
        """Return the greatest sums of the steps that make a literal true, or `most` if they are not found."""
        passes, answers = self._passes(most.passes, where), self._greatest("answers", most.answers, where)
        return Bound(self._greatest("tests", most.tests, where), answers, passes)

    def _passes(self, most: int, where: Literal) -> int:
        """Return how many passes are run at most; an upper bound if the budget is spent."""
        ran = self.encoding.ran[:most]
        try:
            return next((k for k in range(1, len(ran)) if not self._some(where, ran[k])), len(ran))
        except Exhausted:
            return len(ran)

    def _greatest(self, name: str, most: int, where: Literal) -> int:
        """Return the greatest value of a sum, by binary search; an upper bound if the budget is spent."""
        least, reached = self.least[name], 0
        most = min(most, len(least) - 2)
        try:
            while reached < most:
                middle = (reached + most + 1) // 2
                if self._some(where, least[middle]):
                    reached = max(middle, self._value(name))
                else:
                    most = middle - 1
        except Exhausted:
            pass
        return most

    def _value(self, name: str) -> int:
        """Return what a sum is in the step that was found last."""
        word = self.sums[name]
        true = self.solver.true([bit >> 1 for bit in word.bits])
        return word.low + sum(1 << k for k, bit in enumerate(word.bits) if (bit >> 1 in true) != bit & 1)
