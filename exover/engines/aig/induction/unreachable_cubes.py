"""Cubes of one or two literals that no reachable state lies in: an inductive invariant, guessed by simulation.

The guesses are the cubes that simulation did not reach; those that a step enters are dropped until the rest is
inductive (Flanagan, Leino 2001: "Houdini"). A constant latch is a cube of one literal, two equal latches are
two cubes of two (van Eijk 2000 finds them so), and so is most of what keeps requests that exclude each other apart.
"""

from collections.abc import Iterable, Sequence
from contextlib import closing
from random import Random

from exover.engines.aig.circuit.graph import Circuit, LatchNode
from exover.engines.aig.circuit.solver import Solver
from exover.engines.aig.simulation.evaluation import evaluator
from exover.engines.aig.simulation.lanes import LaneWord
from exover.engines.aig.simulation.reached import Cube, Reached

LANES = 1024
GROUP = 256
"""How many guesses one question is about."""
MANY, PATIENCE = 5_000, 600
"""How many guesses are too many, and after how many counterexamples all are given up: simulation saw too little to
guess well."""


def unreachable_cubes(
    circuit: Circuit,
    latches: Sequence[LatchNode],
    reached: Reached,
    granted: int = 100_000_000,
) -> list[Cube]:
    """Return cubes of one and two literals that do not hold the start, and that no step from outside of all enters.

    `latches`: those that are looked at, closed under what they depend on. `granted`: how many propagations the cubes of
    one literal may cost, and those of two; there are none of those that cost more, are too many, or of which too many
    were wrong.
    """
    singles = _inductive(circuit, latches, _unseen_singles(latches, reached), (), granted)
    fixed = {cube[0] >> 1 for cube in singles}
    pairs = _unseen_pairs([latch for latch in latches if latch.node not in fixed], reached)
    return [*singles, *_inductive(circuit, latches, pairs, singles, granted)]


def _unseen_singles(latches: Iterable[LatchNode], reached: Reached) -> list[Cube]:
    """Return the literals that no reached state makes true."""
    literals = (2 * latch.node + sign for latch in latches for sign in (0, 1))
    return [(literal,) for literal in literals if not reached.words[literal]]


def _unseen_pairs(latches: Iterable[LatchNode], reached: Reached) -> list[Cube]:
    """Return the pairs of literals that no reached state makes both true, but each of them some."""
    literals = [2 * latch.node + sign for latch in latches for sign in (0, 1)]
    literals = [literal for literal in literals if reached.words[literal]]
    few = (1 << LANES) - 1
    short = [reached.words[literal] & few for literal in literals]
    found: list[Cube] = []
    for i, one in enumerate(literals):
        for j in range(i):
            other = literals[j]
            if not short[i] & short[j] and one >> 1 != other >> 1 and not reached.words[one] & reached.words[other]:
                found.append((other, one))
    return found


def _inductive(
    circuit: Circuit, latches: Sequence[LatchNode], guesses: Sequence[Cube], known: Sequence[Cube], granted: int
) -> list[Cube]:
    """Return the largest part of the guesses that no step enters from outside of it and of the known cubes."""
    if not 0 < len(guesses) <= MANY:
        return []
    with closing(Solver(circuit)) as solver:
        return _kept(solver, circuit, latches, guesses, known, granted)


def _kept(
    solver: Solver,
    circuit: Circuit,
    latches: Sequence[LatchNode],
    guesses: Sequence[Cube],
    known: Sequence[Cube],
    granted: int,
) -> list[Cube]:
    """Return the same; none if the solver is asked too much."""
    following = {latch.node: latch.next for latch in latches}
    for cube in known:
        solver.add([-solver.literal(literal) for literal in cube])
    entered: dict[Cube, int] = {}
    for cube in guesses:
        entered[cube] = solver.fresh()
        for literal in cube:
            solver.add([-entered[cube], solver.literal(following[literal >> 1] ^ (literal & 1))])
    neighbours = _Neighbours(circuit, latches, known)
    alive, before, answers = list(guesses), -1, 0
    while alive and len(alive) != before:
        before = len(alive)
        assumed = tuple(alive)
        gate = solver.fresh()
        for cube in assumed:
            solver.add([-gate, *(-solver.literal(literal) for literal in cube)])
        for at in range(0, len(assumed), GROUP):
            group = set(assumed[at : at + GROUP])
            while True:
                group &= set(alive)
                some = solver.fresh()
                solver.add([-some, *(entered[cube] for cube in assumed[at : at + GROUP] if cube in group)])
                if solver.work >= granted or answers >= PATIENCE:
                    return []
                if not group or not solver.satisfiable([gate, some]):
                    break
                answers += 1
                true = solver.true([latch.node for latch in latches] + list(circuit.inputs))
                alive = neighbours.kept(true, assumed, alive)
                solver.add([-some])
        solver.add([-gate])
    return alive


class _Neighbours:
    """Simulates steps from states near one that the solver found, to drop many guesses for one answer."""

    def __init__(self, circuit: Circuit, latches: Sequence[LatchNode], known: Sequence[Cube]) -> None:
        self.latches, self.inputs, self.known = latches, circuit.inputs, known
        self.cone = evaluator(circuit, (), latches)
        self.random = Random(1)
        self.lanes = (1 << LANES) - 1

    def kept(self, true: set[int], assumed: Sequence[Cube], alive: Sequence[Cube]) -> list[Cube]:
        """Return the guesses that no step from near a state refutes; the step of the solver itself refutes one."""
        leaves = {node: self._near(node in true) for node in (*self.inputs, *(latch.node for latch in self.latches))}
        words = {2 * node + sign: word ^ (self.lanes * sign) for node, word in leaves.items() for sign in (0, 1)}
        allowed = self.lanes
        for cube in (*assumed, *self.known):
            allowed &= ~_where(words, cube)
        values = self.cone.values(leaves)
        after: dict[int, LaneWord] = {}
        for latch in self.latches:
            word = self.cone.read(values, latch.next, self.lanes)
            after[2 * latch.node], after[2 * latch.node + 1] = word & allowed, ~word & allowed
        return [cube for cube in alive if not _where(after, cube)]

    def _near(self, value: bool) -> LaneWord:
        """Return a word that is the value in lane 0, and in one of 32 lanes its opposite."""
        flips = self.lanes - 1
        for _ in range(5):
            flips &= self.random.getrandbits(LANES)
        return flips ^ (self.lanes if value else 0)


def _where(words: dict[int, LaneWord], cube: Cube) -> LaneWord:
    """Return where all literals of a cube are true."""
    return words[cube[0]] & words[cube[-1]]
