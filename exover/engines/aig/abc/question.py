"""Questions to ABC: a circuit as an AIGER file in which all latches are false at the start, and answers read back."""

from collections.abc import Mapping, Sequence

from exover.dataclass import dataclass
from exover.engines.aig.circuit import aiger
from exover.engines.aig.circuit.answer import Clause, Inputs
from exover.engines.aig.circuit.graph import FALSE, Circuit, Fanins, LatchNode, Literal


@dataclass(frozen=True)
class AbcQuestion:
    """Some of the bad literals of a circuit, by their places in it."""

    circuit: Circuit
    places: Sequence[int]

    @property
    def bad(self) -> list[Literal]:
        """The bad literals that are asked about."""
        return [self.circuit.bad[place] for place in self.places]

    def written(self) -> bytes:
        """Return the circuit as a binary AIGER file with at least one input and one latch.

        Latches that are true at the start are complemented in it.
        """
        circuit = self.circuit
        flipped = {latch.node for latch in circuit.latches if latch.initial}

        def literal(old: Literal) -> Literal:
            return old ^ (old >> 1 in flipped)

        count = len(circuit.fanins)
        fanins = Fanins.leaves(count + 2)
        cone = circuit.cone([*self.bad, *(each.next for each in circuit.latches)])
        for node, left, right in circuit.fanins.conjunctions(cone):
            fanins[node] = literal(left), literal(right)
        latches = [LatchNode(each.node, False, literal(each.next) ^ each.initial) for each in circuit.latches]
        idle = LatchNode(count + 1, False, FALSE)
        padded = Circuit(fanins, circuit.inputs or (count,), tuple(latches) or (idle,), tuple(map(literal, self.bad)))
        names = aiger.Names(latches=tuple(f"l{place}" for place in range(len(padded.latches))))
        return aiger.binary(aiger.Document(padded, names=names))

    def invariant(self, cubes: Sequence[Mapping[int, bool]]) -> tuple[Clause, ...]:
        """Return clauses of the circuit that exclude the cubes; these are of the file, with the latches by place."""
        latches = self.circuit.latches
        return tuple(
            tuple(2 * latches[place].node + (value != latches[place].initial) for place, value in cube.items())
            for cube in cubes
        )

    def inputs(self, steps: Sequence[Sequence[bool]]) -> Inputs:
        """Return a run; `steps`: by step the values of the inputs in their order."""
        nodes = self.circuit.inputs
        return tuple(frozenset(n for n, value in zip(nodes, step, strict=False) if value) for step in steps)
