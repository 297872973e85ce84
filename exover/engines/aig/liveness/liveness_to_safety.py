"""Liveness to safety: a state is copied once; a run that comes back to it is a lasso (Biere, Artho, Schuppan 2002).

If only some latches are copied, that no run comes back to them proves that there is no lasso; a run that does come back
need not be one.
"""

from collections.abc import Mapping, Sequence
from dataclasses import field, replace

from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import TRUE, Circuit, Literal
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.liveness.k_liveness import Staying


@dataclass
class LivenessToSafety:
    """A monitor that copies latches once, in a state that an input chooses while the run stays; `copied`: their nodes.

    `bad`: a literal over the state: the latches have the copied values again, and the run has stayed, taken a step and
    seen all signals since.
    """

    encoding: Encoding
    staying: Staying
    copied: Sequence[int]
    bad: Literal = field(init=False)
    _keep: Literal = field(init=False)

    def __post_init__(self) -> None:
        encoding, graph = self.encoding, self.encoding.graph
        self._keep = graph.input()
        kept = graph.latch(False)
        now = graph.all((self._keep, kept ^ 1, self.staying.begun))
        since = graph.any((kept, now))
        encoding.follow(kept, since)
        alike = []
        for node in self.copied:
            copy = graph.latch(False)
            encoding.follow(copy, graph.choose(now, 2 * node, copy))
            alike.append(graph.differ(copy, 2 * node) ^ 1)
        self.bad = graph.all((kept, *_fulfilled(encoding, self.staying, since), *alike))

    @property
    def keep(self) -> int:
        """The node of the input that says when to copy."""
        return self._keep >> 1


def return_to(encoding: Encoding, staying: Staying, state: Mapping[int, bool]) -> Circuit:
    """Return the circuit that begins in a state; its bad literal says that a run is there again, as a lasso.

    That is, it has stayed and seen all signals. `state`: by latch whether it is true; monitors not named begin anew.
    """
    again = [2 * node ^ (not state[node]) for node in looked_at(encoding, staying)]
    circuit = encoding.circuit([encoding.graph.all((*_fulfilled(encoding, staying, TRUE), *again))])
    latches = tuple(replace(latch, initial=state.get(latch.node, latch.initial)) for latch in circuit.latches)
    return replace(circuit, latches=latches)


def looked_at(encoding: Encoding, staying: Staying) -> list[int]:
    """Return the latches in the cone of influence of what a question looks at, by their nodes."""
    roots = [staying.begun, staying.step, *staying.signals]
    return [latch.node for latch in encoding.circuit(()).support(roots)]


def _fulfilled(encoding: Encoding, staying: Staying, since: Literal) -> list[Literal]:
    """Return literals, all true iff the run has stayed, taken a step and seen each signal since `since` was true."""
    graph, left = encoding.graph, encoding.graph.latch(False)
    encoding.follow(left, graph.any((left, graph.conjunction(since, staying.step ^ 1))))
    found = [left ^ 1]
    for signal in (encoding.legal, *staying.signals):
        flag = graph.latch(False)
        encoding.follow(flag, graph.conjunction(since, graph.any((flag, signal))))
        found.append(flag)
    return found
