"""k-liveness: rounds of a run that stays; a round ends when all signals have been seen (Claessen, Sörensson 2012).

If for some `k` no run comes to the end of its k-th round, no infinite run stays and sees all signals infinitely often.
A run that leaves the part where it must stay, and comes back, begins anew.
"""

from dataclasses import field

from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import Literal
from exover.engines.aig.circuit.words import lit
from exover.engines.aig.encoding.encoder import Encoding


@dataclass(frozen=True, slots=True)
class Staying:
    """The part of a run that must go on for ever.

    `begun`: over the state: the run is in that part; `step`: over a step: it is legal, and the run stays there.
    `signals`: justice conditions, literals over a step; infinitely many steps must make each true.
    """

    begun: Literal
    step: Literal
    signals: tuple[Literal, ...]


def justice(encoding: Encoding, staying: Staying) -> tuple[Literal, ...]:
    """Return justice literals: some run makes each true infinitely often iff some run satisfies the question.

    An input guesses from where on the run stays; a latch remembers a step that leaves after that.
    """
    graph = encoding.graph
    commits, committed, left = graph.input(), graph.latch(False), graph.latch(False)
    stays = graph.any((committed, commits))
    encoding.follow(committed, stays)
    encoding.follow(left, graph.any((left, graph.conjunction(stays, staying.step ^ 1))))
    here = graph.all((encoding.legal, committed, left ^ 1))
    return (here, *(graph.conjunction(encoding.legal, signal) for signal in staying.signals))


@dataclass
class KLiveness:
    """Counts the rounds of a run while it stays: a round ends with the step by which all signals have been seen."""

    encoding: Encoding
    staying: Staying
    seen: tuple[Literal, ...] = field(init=False)
    """Latches: which of the signals have been seen in this round."""
    end: Literal = field(init=False)
    """A literal over a step that ends a round."""
    _done: list[Literal] = field(default_factory=list)

    def __post_init__(self) -> None:
        graph, step = self.encoding.graph, self.staying.step
        self.seen = tuple(graph.latch(False) for _ in self.staying.signals)
        now = [graph.any(pair) for pair in zip(self.seen, self.staying.signals, strict=True)]
        self.end = graph.all((step, *now))
        for latch, literal in zip(self.seen, now, strict=True):
            self.encoding.follow(latch, graph.all((step, self.end ^ 1, literal)))

    def bad(self, count: int) -> Literal:
        """Return a literal over a step: it ends the `count`-th round since the run began to stay, or a later one."""
        graph = self.encoding.graph
        while len(self._done) < count - 1:
            latch = graph.latch(False)
            before = self.bad(len(self._done) + 1)
            self._done.append(latch)
            self.encoding.follow(latch, graph.conjunction(self.staying.step, graph.any((latch, before))))
        return graph.all((self.end, *self._done[: count - 1]))


def fair_reports(encoding: Encoding) -> tuple[Literal, ...]:
    """Return for each slot a literal over a step: it leaves the slot idle, or reports it."""
    found = []
    for slot, numbers in encoding.reports.items():
        active = encoding.after[encoding.latches.slots[slot].active]
        here = [lit(encoding.events[each].chosen) for each in numbers]
        found.append(encoding.graph.any((lit(active) ^ 1, *here)))
    return tuple(found)
