"""Circuits strengthened by known invariants (Cabodi, Nocco, Quer 2009).

A latch becomes true once a state violates the known clauses; bad literals count only before that. No run violates them,
so the answers are the same; but a backward search from bad literals stays within the clauses and need not learn them.
"""

from collections.abc import Iterable, Sequence
from contextlib import closing
from dataclasses import field, replace

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Answer, Clause, Unreachable
from exover.engines.aig.circuit.graph import FALSE, TRUE, Circuit, LatchNode
from exover.engines.aig.induction.inductive import Induction


@dataclass(frozen=True, slots=True)
class Strengthened:
    """A circuit in which bad literals count only as long as all states satisfy the known clauses.

    `left`: the node of the latch that is true after a state that violates them.
    """

    circuit: Circuit
    known: tuple[Clause, ...]
    left: int

    def answer(self, answer: Answer) -> Answer:
        """Return an answer as one about the circuit without the latch, of which the known clauses are an invariant.

        In states of the known clauses the latch stays false: with it set to false, the clauses of the answer and the
        known ones together are an inductive invariant.
        """
        if not isinstance(answer, Unreachable):
            return answer
        here = [clause for clause in answer.invariant if 2 * self.left + 1 not in clause]
        rest = [tuple(literal for literal in clause if literal != 2 * self.left) for clause in here]
        return Unreachable(tuple(dict.fromkeys([*self.known, *rest])))


def strengthened(circuit: Circuit, known: Sequence[Clause]) -> Strengthened:
    """Return a circuit strengthened by clauses that are an invariant of it; without clauses the circuit itself."""
    if not known:
        return Strengthened(circuit, (), len(circuit.fanins))
    fanins = circuit.fanins.copy()
    inside = fanins.add() ^ 1
    for clause in known:
        violated = TRUE
        for literal in clause:
            violated = fanins.add(violated, literal ^ 1)
        inside = fanins.add(inside, violated ^ 1)
    bad = tuple(each if each in (FALSE, TRUE) else fanins.add(each, inside) for each in circuit.bad)
    left = len(circuit.fanins)
    latches = (*circuit.latches, LatchNode(left, False, inside ^ 1))
    return Strengthened(replace(circuit, fanins=fanins, latches=latches, bad=bad), tuple(known), left)


@dataclass
class Lemmas:
    """Lemmas about one graph: sets of clauses, each kept by every step; some are over latches of monitors."""

    _sets: list[frozenset[Clause]] = field(default_factory=list)
    _lone: set[Clause] = field(default_factory=set)
    """Clauses that are not inductive without others of their set."""

    def copy(self) -> "Lemmas":
        """Return a copy: what either learns later is not in the other."""
        return Lemmas(list(self._sets), set(self._lone))

    def add(self, clauses: Iterable[Clause]) -> None:
        """Add a set of clauses that every step keeps, if all of them are assumed.

        A part of a set is kept beside it if it is over fewer latches: circuits without the others have it.
        """
        fresh = frozenset(clauses)
        if not any(_replaces(known, fresh) for known in self._sets):
            self._sets = [known for known in self._sets if not _replaces(fresh, known)] + [fresh]

    def of(self, circuit: Circuit) -> tuple[Clause, ...]:
        """Return lemmas that are an inductive invariant of a circuit of the graph, perhaps one with fewer latches."""
        initial = {latch.node: latch.initial for latch in circuit.latches}

        def fits(clause: Clause) -> bool:
            nodes = [literal >> 1 for literal in clause]
            return all(node in initial for node in nodes) and any(
                initial[literal >> 1] != bool(literal & 1) for literal in clause
            )

        parts = [(known, frozenset(filter(fits, known))) for known in self._sets]
        whole = frozenset[Clause]().union(*(part for known, part in parts if len(part) == len(known)))
        rest = frozenset[Clause]().union(*(part for _, part in parts)) - whole - self._lone
        if rest:
            with closing(Induction(circuit)) as induction:
                kept = frozenset(induction.kept(sorted(rest), sorted(whole)))
            self._lone |= rest - kept
            whole |= kept
            self.add(whole)
        return tuple(sorted(whole))


def _replaces(larger: frozenset[Clause], part: frozenset[Clause]) -> bool:
    """Return True iff a set contains another one and is over the same latches."""
    return part <= larger and _latches(part) == _latches(larger)


def _latches(clauses: Iterable[Clause]) -> set[int]:
    return {literal >> 1 for clause in clauses for literal in clause}
