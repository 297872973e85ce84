"""And-Inverter Graphs: conjunctions and negations over inputs and latches, each conjunction once.

A *literal* is `2 * node + sign`, as in AIGER (Biere, Heljanko, Wieringa 2011); node 0 is false, so that `FALSE` is 0
and `TRUE` is 1. Nodes are numbered as they are made: a conjunction stands after what it is made of.
"""

from array import array
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from functools import reduce
from itertools import chain, compress
from operator import or_

from exover.dataclass import dataclass
from exover.engines.aig.circuit.kernel import address, held, kernel_for

FALSE, TRUE = 0, 1
Literal = int
Fanin = tuple[Literal, Literal] | None
"""The two literals of a conjunction; None for the constant, inputs and latches."""
WITHIN_A_STEP: Mapping[int, Literal] = {}


@dataclass(slots=True)
class Fanins:
    """The fanins of nodes, by node.

    `packed`: two literals of each node side by side in memory, as C reads them; both are `FALSE` for a node that is no
    conjunction, and of a conjunction the second is not. Those of node `n` stand at `2 * n` and `2 * n + 1`: for a
    literal, at the literal without its sign and at the literal with it.
    """

    packed: "array[int]" = field(default_factory=lambda: array("I"))

    @classmethod
    def of(cls, pairs: Iterable[Fanin]) -> "Fanins":
        """Return the fanins of so many nodes."""
        return cls(array("I", chain.from_iterable(pair or (FALSE, FALSE) for pair in pairs)))

    @classmethod
    def leaves(cls, count: int) -> "Fanins":
        """Return the fanins of so many nodes that are no conjunctions."""
        made = array("I", [FALSE])
        return cls(made * (2 * count))

    def __len__(self) -> int:
        """Return the number of nodes."""
        return len(self.packed) // 2

    def __getitem__(self, node: int) -> Fanin:
        right = self.packed[2 * node + 1]
        return (self.packed[2 * node], right) if right else None

    def __setitem__(self, node: int, pair: tuple[Literal, Literal]) -> None:
        self.packed[2 * node], self.packed[2 * node + 1] = pair

    def __iter__(self) -> Iterator[Fanin]:
        return map(self.__getitem__, range(len(self)))

    def is_leaf(self, node: int) -> bool:
        """Return whether a node is no conjunction."""
        return not self.packed[2 * node + 1]

    def conjunctions(self, nodes: Iterable[int]) -> Iterator[tuple[int, Literal, Literal]]:
        """Yield the conjunctions among nodes, in their order, each with its two literals."""
        packed = self.packed
        for node in nodes:
            right = packed[2 * node + 1]
            if right:
                yield node, packed[2 * node], right

    def copy(self) -> "Fanins":
        """Return a copy: what is added to one is not in the other."""
        return Fanins(self.packed[:])

    def add(self, left: Literal = FALSE, right: Literal = FALSE) -> Literal:
        """Add a node, and return its literal."""
        made = len(self.packed)
        self.packed.append(left)
        self.packed.append(right)
        return made


@dataclass(frozen=True, slots=True)
class LatchNode:
    """A bit of the state: its node, its value at the start, and the literal that it is after a step."""

    node: int
    initial: bool
    next: Literal


@dataclass(frozen=True, slots=True)
class Circuit:
    """A transition system: in every state each choice of inputs leads to one next state.

    `bad`: literals over state and inputs; the question is, for each, whether some run from the start makes it true.
    Every run has a step at any time: there are no constraints.
    """

    fanins: Fanins
    inputs: tuple[int, ...]
    latches: tuple[LatchNode, ...]
    bad: tuple[Literal, ...]

    def cone(self, roots: Iterable[Literal]) -> list[int]:
        """Return the nodes that literals depend on within one step, their own included, in ascending order."""
        marked = self._marked(roots, ())
        return sorted(cone(self.fanins, roots)) if marked is None else [*compress(range(len(marked)), marked)]

    def support(self, roots: Iterable[Literal]) -> tuple[LatchNode, ...]:
        """Return the latches that literals depend on in any number of steps: their cone of influence."""
        marked = self._marked(roots, self.latches)
        if marked is not None:
            return tuple(latch for latch in self.latches if marked[latch.node])
        seen = cone(self.fanins, roots, {latch.node: latch.next for latch in self.latches})
        return tuple(latch for latch in self.latches if latch.node in seen)

    def _marked(self, roots: Iterable[Literal], followed: Sequence[LatchNode]) -> bytearray | None:
        """Return by node whether literals depend on it, through these latches in any number of steps.

        None if that is not done in C.
        """
        native = kernel_for(len(self.fanins))
        if native is None:
            return None
        marked = bytearray(len(self.fanins))
        for root in roots:
            marked[root >> 1] = 1
        latches = array("I", chain.from_iterable((latch.node, latch.next >> 1) for latch in followed))
        native.mark(address(self.fanins.packed), len(marked), address(latches), len(followed), held(marked))
        return marked


def valuation(nodes: Iterable[int], true: Container[int]) -> list[Literal]:
    """Return literals of nodes that are all true iff, of the nodes, these are true and no others."""
    return [2 * node + (node not in true) for node in nodes]


class Influence:
    """The supports of many sets of literals of one circuit.

    Sets of latches are numbers, a bit for each latch, so that one pass over the nodes collects those of all nodes.
    """

    def __init__(self, circuit: Circuit) -> None:
        self._latches = circuit.latches
        bits = {latch.node: 1 << place for place, latch in enumerate(circuit.latches)}
        self._read: list[int] = []
        """By node the latches that it depends on within a step."""
        for node, pair in enumerate(circuit.fanins):
            self._read.append(
                bits.get(node, 0) if pair is None else self._read[pair[0] >> 1] | self._read[pair[1] >> 1]
            )

    def on(self, roots: Iterable[Literal]) -> tuple[LatchNode, ...]:
        """Return the latches in the cone of influence of literals, in their order."""
        found, new = 0, reduce(or_, (self._read[root >> 1] for root in roots), 0)
        while new:
            found |= new
            read = (self._read[latch.next >> 1] for place, latch in enumerate(self._latches) if new >> place & 1)
            new = reduce(or_, read) & ~found
        return tuple(latch for place, latch in enumerate(self._latches) if found >> place & 1)


def cone(
    fanins: Fanins,
    roots: Iterable[Literal],
    following: Mapping[int, Literal] = WITHIN_A_STEP,
) -> set[int]:
    """Return the nodes that literals depend on within one step, their own included.

    `following`: by latch its next-state literal, for latches through which any number of steps is followed.
    """
    seen: set[int] = set()
    stack = [root >> 1 for root in roots]
    while stack:
        node = stack.pop()
        if node not in seen:
            seen.add(node)
            pair = fanins[node]
            if pair is not None:
                stack += [pair[0] >> 1, pair[1] >> 1]
            elif node in following:
                stack.append(following[node] >> 1)
    return seen


@dataclass
class Graph:
    """A graph under construction; equal conjunctions are one node (structural hashing), constants are folded."""

    fanins: Fanins = field(default_factory=lambda: Fanins.leaves(1))
    inputs: list[int] = field(default_factory=list)
    latches: list[tuple[int, bool]] = field(default_factory=list)
    """Nodes of latches, with their values at the start."""
    _known: dict[tuple[Literal, Literal], Literal] = field(default_factory=dict)

    def copy(self) -> "Graph":
        """Return a copy: what is added to one is not in the other."""
        return Graph(self.fanins.copy(), list(self.inputs), list(self.latches), dict(self._known))

    def input(self) -> Literal:
        """Return a new input."""
        made = self.fanins.add()
        self.inputs.append(made >> 1)
        return made

    def latch(self, initial: bool) -> Literal:
        """Return a new latch."""
        made = self.fanins.add()
        self.latches.append((made >> 1, initial))
        return made

    def conjunction(self, left: Literal, right: Literal) -> Literal:
        """Return `left and right`, simplified by what the two are made of (Brummayer, Biere 2006, levels 1 and 2)."""
        if left > right:
            left, right = right, left
        if left == FALSE or left == right ^ 1:
            return FALSE
        if left in (TRUE, right):
            return right
        known = self._known.get((left, right))
        if known is not None:
            return known
        simpler = self._simplified(left, right)
        if simpler is None:
            simpler = self._simplified(right, left)
        if simpler is None:
            packed = self.fanins.packed
            simpler = len(packed)
            packed.extend((left, right))
        self._known[left, right] = simpler
        return simpler

    def _simplified(self, one: Literal, other: Literal) -> Literal | None:
        """Return `one and other` if what `one` is made of makes it simpler."""
        packed = self.fanins.packed
        first, second = packed[one & ~1], packed[one | 1]
        if not second:
            return None
        if not one & 1:
            if other in (first, second):
                return one
            if other ^ 1 in (first, second):
                return FALSE
            if not other & 1 and packed[other | 1]:
                mine = packed[other], packed[other | 1]
                if first ^ 1 in mine or second ^ 1 in mine:
                    return FALSE
            return None
        if other ^ 1 in (first, second):
            return other
        if other == first:
            return self.conjunction(other, second ^ 1)
        if other == second:
            return self.conjunction(other, first ^ 1)
        return None

    def all(self, literals: Iterable[Literal]) -> Literal:
        """Return the conjunction, as a balanced tree."""
        level = sorted(set(literals))
        while len(level) > 1:
            pairs = [self.conjunction(a, b) for a, b in zip(level[::2], level[1::2], strict=False)]
            level = pairs + level[len(pairs) * 2 :]
        return level[0] if level else TRUE

    def any(self, literals: Iterable[Literal]) -> Literal:
        """Return the disjunction."""
        return self.all(literal ^ 1 for literal in literals) ^ 1

    def choose(self, condition: Literal, then: Literal, otherwise: Literal) -> Literal:
        """Return `then` where the condition is true, else `otherwise`."""
        if then == otherwise:
            return then
        if then == otherwise ^ 1:
            return self.differ(condition, otherwise)
        return (
            self.conjunction(self.conjunction(condition, then) ^ 1, self.conjunction(condition ^ 1, otherwise) ^ 1) ^ 1
        )

    def differ(self, left: Literal, right: Literal) -> Literal:
        """Return the exclusive disjunction."""
        return self.conjunction(self.conjunction(left, right) ^ 1, self.conjunction(left ^ 1, right ^ 1) ^ 1)

    def decoded(self, code: Sequence[Literal], count: int) -> list[Literal]:
        """Return by number below `count` where literals are that number, the least significant first; numbers beyond
        the last are the last."""
        found = [TRUE]
        for bit in reversed(code):
            found = [self.conjunction(each, bit ^ sign) for each in found for sign in (1, 0)]
        return [*found[: count - 1], self.any(found[count - 1 :])]

    def pooled(self, pool: list[Literal], first: int, count: int) -> list[Literal]:
        """Return so many inputs of a pool from a place on; the pool grows as far as it must."""
        while len(pool) < first + count:
            pool.append(self.input())
        return pool[first : first + count]

    def replace(self, circuit: Circuit) -> None:
        """Become the graph of a circuit with the same inputs and latches; structural hashing knows its cones only."""
        self.fanins = circuit.fanins.copy()
        nodes = circuit.cone([*circuit.bad, *(latch.next for latch in circuit.latches)])
        self._known = {(min(pair), max(pair)): 2 * node for node, *pair in circuit.fanins.conjunctions(nodes)}

    def within_step(self) -> Circuit:
        """Return all nodes so far, for questions about one state and its step: what latches become is left out."""
        return self.circuit([FALSE] * len(self.latches), ())

    def circuit(self, following: Sequence[Literal], bad: Sequence[Literal]) -> Circuit:
        """Return the transition system whose latches, in order, become `following` by a step."""
        pairs = zip(self.latches, following, strict=True)
        latches = tuple(LatchNode(node, initial, literal) for (node, initial), literal in pairs)
        return Circuit(self.fanins.copy(), tuple(self.inputs), latches, tuple(bad))
