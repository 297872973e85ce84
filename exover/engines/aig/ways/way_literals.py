"""The questions AG (since -> E [allowed U goal]) as literals: where a way must begin, and which step ends it."""

from collections.abc import Callable
from dataclasses import field

from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import FALSE, TRUE, Literal
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.encoding.questions import CutOff
from exover.model.property import Conjunction, Disjunction, Formula, Happened, Negation, Passed


@dataclass(frozen=True, slots=True)
class WayLiterals:
    """A question as literals.

    `since`: over the state in which a way begins; `hit`: over a step, where it reaches the goal by allowed steps alone;
    `lost`: over the state, where there is no way because the state itself is not allowed. `from_home`: whether the
    steps that lead to home states are allowed, so that it is enough to look at ways from these.
    """

    since: Literal
    hit: Literal
    from_home: bool
    lost: Literal = FALSE


@dataclass
class WayEncoder:
    """Encodes questions as literals; latches that remember what a step did are added to the graph."""

    encoding: Encoding
    _latched: dict[Formula, Literal] = field(default_factory=dict)
    _kept: dict[Formula, Literal] = field(default_factory=dict)

    def of(self, question: CutOff, allows_steps_home: Callable[[Formula], bool]) -> WayLiterals:
        """Return a question as literals; `allows_steps_home`: whether a formula allows the steps to home states."""
        encoding, graph, way = self.encoding, self.encoding.graph, question.stuck.way
        kept = self.kept(way.allowed)
        hit = graph.all((kept, encoding.legal, encoding.moments.truth(way.goal)))
        since = self.now(question.stuck.since)
        if way.strict:
            return WayLiterals(since, hit, allows_steps_home(way.allowed))
        since = graph.conjunction(since, self.now(way.goal) ^ 1)
        allowed = self.now(way.allowed)
        from_home = allowed == TRUE and allows_steps_home(way.allowed)
        return WayLiterals(since, hit, from_home, graph.conjunction(since, allowed ^ 1))

    def now(self, formula: Formula) -> Literal:
        """Return a literal over the state: a formula is true of the moment before the step."""
        match formula:
            case Passed() | Happened():
                return self._memory(formula)
            case Negation(part):
                return self.now(part) ^ 1
            case Conjunction(parts):
                return self.encoding.graph.all(map(self.now, parts))
            case Disjunction(parts):
                return self.encoding.graph.any(map(self.now, parts))
            case _:
                return self.encoding.moments.now(formula)

    def _memory(self, formula: Formula) -> Literal:
        known = self._latched.get(formula)
        if known is None:
            encoding = self.encoding
            known = self._latched[formula] = encoding.graph.latch(False)
            encoding.follow(known, encoding.moments.truth(formula))
        return known

    def kept(self, allowed: Formula) -> Literal:
        """Return a latch: `allowed` was true after all steps of the way so far. It is true where a way begins."""
        if allowed == Conjunction(()):
            return TRUE
        known = self._kept.get(allowed)
        if known is None:
            encoding, graph = self.encoding, self.encoding.graph
            known = self._kept[allowed] = graph.latch(True)
            wrong = graph.conjunction(encoding.legal, encoding.moments.truth(allowed) ^ 1)
            encoding.following[known] = graph.conjunction(known, wrong ^ 1)
        return known

    @property
    def fresh(self) -> frozenset[int]:
        """The latches that are true where a way begins."""
        return frozenset(literal >> 1 for literal in self._kept.values())
