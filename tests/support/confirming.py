"""Whether an answer is right, found without anything of what found it: only the circuit itself is read."""

from collections.abc import Iterable, Sequence
from typing import assert_never

from exover.engines.aig.circuit.answer import Answer, Clause, Inputs, Open, Reachable, Unreachable
from exover.engines.aig.circuit.graph import Circuit, Literal


def confirms(circuit: Circuit, bad: Literal, answer: Answer) -> bool:
    """Return True iff the answer shows what it says of this literal; one that leaves it open shows nothing."""
    match answer:
        case Reachable(inputs):
            return makes_true(circuit, bad, inputs)
        case Unreachable(invariant):
            return is_invariant(circuit, invariant) and excludes(circuit, invariant, bad)
        case Open():
            return False
        case _:
            assert_never(answer)


def makes_true(circuit: Circuit, bad: Literal, inputs: Inputs) -> bool:
    """Return True iff the literal is true in the last step of this run from the start."""
    if not inputs or not frozenset().union(*inputs) <= set(circuit.inputs):
        return False
    state = {latch.node: latch.initial for latch in circuit.latches}
    for true in inputs:
        values = _values(circuit, {**dict.fromkeys(circuit.inputs, False), **dict.fromkeys(true, True), **state})
        state = {latch.node: values[latch.next >> 1] != (latch.next & 1) for latch in circuit.latches}
    return values[bad >> 1] != (bad & 1)


def _values(circuit: Circuit, leaves: dict[int, bool]) -> list[bool]:
    """Return the value of each node."""
    values: list[bool] = []
    for node, pair in enumerate(circuit.fanins):
        if pair is None:
            values.append(leaves.get(node, False))
        else:
            left, right = pair
            values.append(values[left >> 1] != (left & 1) and values[right >> 1] != (right & 1))
    return values


def is_invariant(circuit: Circuit, clauses: Sequence[Clause]) -> bool:
    """Return True iff the clauses are about latches, hold at the start, and a step from where all hold keeps all."""
    latches = {latch.node: latch for latch in circuit.latches}
    if any(literal >> 1 not in latches for clause in clauses for literal in clause):
        return False
    if not all(any(latches[literal >> 1].initial != (literal & 1) for literal in clause) for clause in clauses):
        return False
    formula = _formula(circuit, [latches[literal >> 1].next for clause in clauses for literal in clause])
    formula += [[_variable(literal) for literal in clause] for clause in clauses]
    broken = []
    for number, clause in enumerate(clauses, 2 + len(circuit.fanins)):
        broken.append(number)
        formula += [[-number, -_variable(latches[literal >> 1].next ^ literal & 1)] for literal in clause]
    return not _satisfiable([*formula, broken])


def excludes(circuit: Circuit, clauses: Sequence[Clause], bad: Literal) -> bool:
    """Return True iff the literal is false wherever all clauses hold."""
    formula = _formula(circuit, [bad])
    formula += [[_variable(literal) for literal in clause] for clause in clauses]
    return not _satisfiable([*formula, [_variable(bad)]])


def _formula(circuit: Circuit, roots: Iterable[Literal]) -> list[list[int]]:
    """Return clauses that give each node in the cone of the roots its value (Tseitin 1968)."""
    clauses = [[-_variable(0)]]
    waiting, done = [root >> 1 for root in roots], set()
    while waiting:
        node = waiting.pop()
        pair = circuit.fanins[node]
        if node in done or pair is None:
            continue
        done.add(node)
        gate, left, right = _variable(2 * node), _variable(pair[0]), _variable(pair[1])
        clauses += [[-gate, left], [-gate, right], [gate, -left, -right]]
        waiting += [pair[0] >> 1, pair[1] >> 1]
    return clauses


def _variable(literal: Literal) -> int:
    """Return the solver's literal."""
    return -(literal >> 1) - 1 if literal & 1 else (literal >> 1) + 1


def _satisfiable(clauses: list[list[int]]) -> bool:
    """Return True iff some assignment satisfies all clauses."""
    from pysat.solvers import Cadical195

    with Cadical195(bootstrap_with=clauses) as solver:
        return bool(solver.solve())
