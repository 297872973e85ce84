"""Liveness to safety: a state is copied once; a run that comes back to it is a lasso (Biere, Artho, Schuppan 2002)."""

from dataclasses import dataclass, field

from exover.engines.aig.encoder import Encoding
from exover.engines.aig.graph import Literal
from exover.engines.aig.k_liveness import Staying


@dataclass
class LivenessToSafety:
    """Latches that copy a state of a run that stays, once, when an input says so.

    `bad`: a literal over the state, where it is the copied one, and the run has stayed and seen all signals since.
    """

    encoding: Encoding
    staying: Staying
    bad: Literal = field(init=False)
    _keep: Literal = field(init=False)

    def __post_init__(self) -> None:
        encoding, graph, step = self.encoding, self.encoding.graph, self.staying.step
        roots = [self.staying.begun, step, *self.staying.signals]
        latches = [2 * latch.node for latch in encoding.circuit(()).support(roots)]
        self._keep = graph.input()
        kept, left = graph.latch(False), graph.latch(False)
        now = graph.all((self._keep, kept ^ 1, self.staying.begun))
        since = graph.any((kept, now))
        encoding.follow(kept, since)
        encoding.follow(left, graph.any((left, graph.conjunction(since, step ^ 1))))
        alike = []
        for latch in latches:
            copy = graph.latch(False)
            encoding.follow(copy, graph.choose(now, latch, copy))
            alike.append(graph.differ(copy, latch) ^ 1)
        seen = []
        for signal in (encoding.legal, *self.staying.signals):
            flag = graph.latch(False)
            encoding.follow(flag, graph.conjunction(since, graph.any((flag, signal))))
            seen.append(flag)
        self.bad = graph.all((kept, left ^ 1, *seen, *alike))

    @property
    def keep(self) -> int:
        """The node of the input by which a state is kept."""
        return self._keep >> 1
