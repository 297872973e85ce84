"""Fraiging: a smaller circuit that is equal in all states.

Nodes that random simulation does not tell apart are compared by a solver in topological order, so that equal nodes are
merged before those that depend on them (Kuehlmann, Paruthi, Krohm, Ganai 2002; Mishchenko et al. 2005). Inputs, latches
and nodes keep their numbers: runs and invariants of the smaller circuit are those of the given one.
"""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import replace
from operator import itemgetter
from random import Random

from exover.engines.aig.circuit.graph import FALSE, TRUE, Circuit, LatchNode, Literal
from exover.engines.aig.circuit.solver import Exhausted, Solver
from exover.engines.aig.simulation.evaluation import ConeValues, evaluator
from exover.engines.aig.simulation.reached import Reached

LANES = 2048
REFINE = 16
"""After how many counterexamples to equality all nodes are simulated again, from these and from states near them."""


def reduced(circuit: Circuit, reached: Reached, granted: int = 100_000_000) -> Circuit:
    """Return a circuit with equal bad literals and next states in their cone of influence, but fewer nodes.

    `reached`: states in which nodes are simulated first; it must have all latches of that cone. `granted`: after how
    many propagations no more nodes are compared.
    """
    latches = circuit.support(circuit.bad)
    roots = [*circuit.bad, *(latch.next for latch in latches)]
    with closing(Solver(circuit)) as solver:
        sweep = _Sweep(circuit, latches, roots, reached, solver)
        sweep.run(circuit.cone(roots), granted)
    kept = {latch.node for latch in latches}
    return replace(
        circuit,
        fanins=sweep.fanins,
        latches=tuple(
            replace(latch, next=sweep.now(latch.next)) if latch.node in kept else latch for latch in circuit.latches
        ),
        bad=tuple(sweep.now(literal) for literal in circuit.bad),
    )


class _Sweep:
    """A sweep over the nodes: what each is in the smaller circuit, and counterexamples to equality."""

    def __init__(
        self,
        circuit: Circuit,
        latches: Sequence[LatchNode],
        roots: list[Literal],
        reached: Reached,
        solver: Solver,
    ) -> None:
        self.circuit, self.latches, self.solver = circuit, latches, solver
        self.fanins = circuit.fanins.copy()
        self.is_now: dict[int, Literal] = {}
        self.random = Random(1)
        self.cone = evaluator(circuit, roots)
        self.different: list[set[int]] = []
        self.everywhere = (1 << LANES) - 1
        self.alike: dict[int, list[int]] = {}
        """By node its class: the nodes not told apart so far, up to complement; absent if it is alone."""
        self.sign: dict[int, int] = {}
        """By node 1 if its complement is like the others of its class, else 0."""
        chosen = self.random.choices(range(reached.size), k=LANES)
        leaves = {node: self.random.getrandbits(LANES) for node in circuit.inputs}
        at_chosen = itemgetter(*(reached.size - 1 - at for at in reversed(chosen)))
        for latch in latches:
            digits = f"{reached.words[2 * latch.node]:0{reached.size}b}"
            leaves[latch.node] = int("".join(at_chosen(digits)), 2)
        values = self.cone.values(leaves)
        cone = circuit.cone([FALSE, *roots])
        self.sign = {node: self.cone.read(values, 2 * node, self.everywhere) & 1 for node in cone}
        self._split([cone], values)

    def now(self, literal: Literal) -> Literal:
        """Return what a literal is in the smaller circuit."""
        return self.is_now.get(literal >> 1, literal & ~1) ^ (literal & 1)

    def run(self, nodes: Sequence[int], granted: int) -> None:
        """Merge each node, in topological order, with an equal node or literal before it."""
        known: dict[tuple[Literal, Literal], Literal] = {}
        for node in nodes:
            if node and self.circuit.fanins.is_leaf(node):
                self._merge(node, granted)
        for node, left, right in self.circuit.fanins.conjunctions(nodes):
            one, other = self.now(left), self.now(right)
            pair = min(one, other), max(one, other)
            same = _folded(*pair)
            if same is None:
                same = known.get(pair)
            if same is not None:
                self._is(node, same)
                continue
            self.fanins[node] = pair
            self._merge(node, granted)
            known[pair] = self.now(2 * node)

    def _merge(self, node: int, granted: int) -> None:
        """Let a node be one of smaller number if it is found to be equal."""
        for other in self.alike.get(node, [])[:2]:
            if self.solver.work >= granted:
                return
            same = 2 * other ^ self.sign[node] ^ self.sign[other]
            if other < node and self._equal(2 * node, same):
                self._is(node, self.now(same))
                return
        if len(self.different) >= REFINE:
            self._refine(node)

    def _is(self, node: int, same: Literal) -> None:
        """Let a node be a literal from now on: no other is compared with it."""
        self.is_now[node] = same
        if node in self.alike:
            self.alike.pop(node).remove(node)

    def _split(self, classes: Sequence[list[int]], values: ConeValues) -> None:
        """Split each class by the simulated values of its nodes."""
        nodes = [node for members in classes for node in members]
        seen = iter(self.cone.signatures(values, [2 * node ^ self.sign[node] for node in nodes]))
        for members in classes:
            parts: dict[int, list[int]] = {}
            for node, signature in zip(members, seen, strict=False):
                parts.setdefault(signature, []).append(node)
            for part in parts.values():
                if len(part) > 1:
                    self.alike |= dict.fromkeys(part, part)
                else:
                    self.alike.pop(part[0], None)

    def _equal(self, one: Literal, other: Literal) -> bool:
        """Return True iff 20 000 propagations show that no state tells two literals apart."""
        a, b = self.solver.literal(one), self.solver.literal(other)
        for assumptions in ([a, -b], [-a, b]):
            try:
                if self.solver.satisfiable(assumptions, 20_000):
                    leaves = [*self.circuit.inputs, *(latch.node for latch in self.latches)]
                    self.different.append(self.solver.true(leaves))
                    return False
            except Exhausted:
                return False
        self.solver.add([a, -b])
        self.solver.add([-a, b])
        return True

    def _refine(self, done: int) -> None:
        """Split the classes of nodes after `done` by simulation of the counterexamples, and of states near them.

        In each of these a sixteenth, an eighth or a quarter of the latches and inputs are changed: closer ones tell
        fewer nodes apart.
        """
        share = LANES // len(self.different)
        far = self.everywhere & ~sum(1 << share * at for at in range(len(self.different)))
        denser = 0, 0, self.random.getrandbits(LANES), self.random.getrandbits(LANES)
        leaves = {}
        for node in (*self.circuit.inputs, *(latch.node for latch in self.latches)):
            word = sum(((1 << share) - 1) << share * at for at, true in enumerate(self.different) if node in true)
            flips = far
            for lanes in denser:
                flips &= self.random.getrandbits(LANES) | lanes
            leaves[node] = word ^ flips
        self.different.clear()
        values = self.cone.values(leaves)
        classes = {id(members): members for node, members in self.alike.items() if node > done}
        self._split(list(classes.values()), values)


def _folded(left: Literal, right: Literal) -> Literal | None:
    """Return the literal of a conjunction that needs no node, None if it needs one."""
    if left == FALSE or left == right ^ 1:
        return FALSE
    if left in (TRUE, right):
        return right
    return None
