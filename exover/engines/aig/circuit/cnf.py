"""CNF of a circuit by technology mapping: clauses that define its nodes, in fewer variables than nodes.

A node is a function of up to `LEAVES` others, its leaves: nodes used only in between have no variable of their own
(Eén, Mishchenko, Sörensson 2007). So a solver has less than half as many variables to decide.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from functools import cache
from operator import itemgetter

from exover.engines.aig.circuit.graph import FALSE, Circuit, Fanins, Literal

LEAVES = 5
"""The greatest number of leaves of a node."""
VARIABLES = tuple(sum(1 << row for row in range(1 << LEAVES) if row >> place & 1) for place in range(LEAVES))
"""The truth tables of the leaves: bit `r` is the value in row `r`."""
Product = tuple[int, ...]
"""A conjunction or disjunction of leaves: the place of each plus one, negated where the leaf is false."""
Pick = Callable[[Sequence[int]], Sequence[int]]
"""Picks a clause from what `signed` returns of the variables of leaves and, after them, of their node."""
NodeClauses = tuple[tuple[int, ...], tuple[Pick, ...]]
"""The leaves of a node, and the clauses that define it over them."""


def signed(variables: Sequence[int]) -> list[int]:
    """Return literals of variables: that of place `p`, from 1 on, stands at `p`, its negation at `-p`."""
    return [0, *variables, *[-each for each in reversed(variables)]]


class Cnf:
    """The clauses of the nodes of a circuit; it may grow if it has no bad literals."""

    def __init__(self, circuit: Circuit) -> None:
        self._fanins = Fanins()
        self._uses: Counter[int] = Counter()
        """How many conjunctions, latches and questions a node is used by."""
        self._gates: dict[int, NodeClauses] = {}
        if circuit.bad:
            roots = (*circuit.bad, *(latch.next for latch in circuit.latches))
            self._uses.update(literal >> 1 for literal in roots)
            gates = circuit.fanins.conjunctions(circuit.cone(roots))
            self._uses.update([node for _, left, right in gates for node in (left >> 1, right >> 1)])
            self._fanins = circuit.fanins
        else:
            self.grow(circuit)

    def grow(self, circuit: Circuit) -> None:
        """Continue with a circuit that has the same nodes and further ones."""
        new = circuit.fanins.packed[len(self._fanins.packed) :]
        self._uses.update([literal >> 1 for literal in new if literal])
        self._fanins = circuit.fanins

    def gate(self, node: int) -> NodeClauses | None:
        """Return the leaves of a conjunction and the clauses that define it; None: the node is no conjunction."""
        found = self._gates.get(node)
        if found is None:
            pair = self._fanins[node]
            if pair is not None:
                found = self._gates[node] = self._gate(node, *pair)
        return found

    def _gate(self, node: int, left: Literal, right: Literal) -> NodeClauses:
        leaves, inner = self._cut([left >> 1, right >> 1])
        if not inner:
            return tuple(leaves), _conjunction(left & 1, right & 1)
        return tuple(leaves), _clauses(self._table(node, leaves, inner), len(leaves))

    def _cut(self, leaves: list[int]) -> tuple[list[int], list[int]]:
        """Return up to `LEAVES` nodes, a cut below these: nodes used only here are replaced by their fanins.

        Also those that were replaced, each before those that took its place.
        """
        packed, uses, inner = self._fanins.packed, self._uses, list[int]()
        while True:
            chosen, fewest = FALSE, 3
            for leaf in leaves:
                if uses[leaf] == 1 and packed[2 * leaf + 1]:
                    new = (packed[2 * leaf] >> 1 not in leaves) + (packed[2 * leaf + 1] >> 1 not in leaves)
                    if new < fewest:
                        chosen, fewest = leaf, new
            if not chosen or len(leaves) + fewest - 1 > LEAVES:
                return leaves, inner
            inner.append(chosen)
            leaves.remove(chosen)
            leaves += [each for each in (packed[2 * chosen] >> 1, packed[2 * chosen + 1] >> 1) if each not in leaves]

    def _table(self, node: int, leaves: Sequence[int], inner: Sequence[int]) -> int:
        """Return the truth table of a node over leaves; `inner`: the nodes between, from the top down."""
        packed, values = self._fanins.packed, dict(zip(leaves, VARIABLES, strict=False))
        for each in (*reversed(inner), node):
            left, right = packed[2 * each], packed[2 * each + 1]
            values[each] = (values[left >> 1] ^ -(left & 1)) & (values[right >> 1] ^ -(right & 1))
        return values[node] & (1 << (1 << len(leaves))) - 1


@cache
def _conjunction(first: int, second: int) -> tuple[Pick, ...]:
    """Return clauses that define a node as the conjunction of two leaves, each complemented if its argument is 1."""
    return _clauses((VARIABLES[0] ^ -first) & (VARIABLES[1] ^ -second) & 15, 2)


@cache
def _clauses(table: int, count: int) -> tuple[Pick, ...]:
    """Return clauses that define a node by its truth table over so many leaves."""
    ones = (1 << (1 << count)) - 1
    node = count + 1
    found = [(*(-each for each in cube), node) for cube in _cover(table, table, count)[0]]
    found += [(*(-each for each in cube), -node) for cube in _cover(ones ^ table, ones ^ table, count)[0]]
    return tuple(map(_pick, found))


def _pick(clause: Product) -> Pick:
    """Return what picks a clause by the places of its literals."""
    return itemgetter(*clause) if len(clause) > 1 else itemgetter(slice(clause[0], clause[0] + 1 or None))


@cache
def _cover(lower: int, upper: int, count: int) -> tuple[tuple[Product, ...], int]:
    """Return an irredundant sum of products between two functions of so many variables, and its table (Minato 1992)."""
    if not lower:
        return (), 0
    ones = (1 << (1 << count)) - 1
    if upper == ones:
        return ((),), ones
    half = 1 << (count - 1)
    low = (1 << half) - 1
    l0, l1, u0, u1 = lower & low, lower >> half, upper & low, upper >> half
    without, f0 = _cover(l0 & ~u1, u0, count - 1)
    within, f1 = _cover(l1 & ~u0, u1, count - 1)
    both, f2 = _cover(l0 & ~f0 | l1 & ~f1, u0 & u1, count - 1)
    cubes = (*((*cube, -count) for cube in without), *((*cube, count) for cube in within), *both)
    return cubes, f0 | f2 | (f1 | f2) << half
