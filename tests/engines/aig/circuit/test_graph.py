"""What the literals of a circuit depend on."""

import pytest

from exover.engines.aig.circuit import kernel
from exover.engines.aig.circuit.graph import Circuit, Graph, Influence, Literal
from tests.support.circuits import random_circuit


def depends(circuit: Circuit, root: Literal) -> set[int]:
    """Return the latches on which a literal depends in any number of steps, found step by step."""
    following = {latch.node: latch.next for latch in circuit.latches}
    found: set[int] = set()
    new = following.keys() & circuit.cone([root])
    while new - found:
        found |= new
        new = following.keys() & circuit.cone([following[node] for node in found])
    return found


def cones(circuit: Circuit) -> list[list[int]]:
    """Return the cone of each bad literal, and of the next state of each latch."""
    return [circuit.cone([root]) for root in (*circuit.bad, *(latch.next for latch in circuit.latches))]


def test_the_loop_in_c_finds_the_same_cones(monkeypatch: pytest.MonkeyPatch) -> None:
    circuits = [random_circuit(seed, latches=12) for seed in range(40)]
    plain = [(cones(circuit), [circuit.support([root]) for root in circuit.bad]) for circuit in circuits]
    monkeypatch.setattr(kernel, "WORTH", 0)
    if kernel.kernel() is None:
        pytest.skip("no C compiler")
    assert plain == [(cones(circuit), [circuit.support([root]) for root in circuit.bad]) for circuit in circuits]
    assert all(found == sorted(set(found)) for some, _ in plain for found in some)


@pytest.mark.parametrize("worth", [0, kernel.WORTH], ids=["C", "Python"])
def test_the_latches_that_literals_depend_on_are_those_of_their_cones_step_by_step(
    worth: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernel, "WORTH", worth)
    partial = 0
    for seed in range(40):
        circuit = random_circuit(seed, latches=12)
        influence = Influence(circuit)
        each = {root: depends(circuit, root) for root in circuit.bad}
        for root, wanted in each.items():
            assert {latch.node for latch in influence.on([root])} == wanted
            partial += 0 < len(wanted) < len(circuit.latches)
        together = circuit.support(circuit.bad)
        assert [latch.node for latch in together] == sorted(set().union(*each.values()))
    assert partial > 20, "most of them do not depend on all"


def test_nothing_depends_on_latches_that_no_root_leads_to() -> None:
    graph = Graph()
    one, other = graph.latch(False), graph.latch(True)
    circuit = graph.circuit([one ^ 1, one], [one])
    assert [latch.node for latch in circuit.support([one])] == [one >> 1]
    assert [latch.node for latch in circuit.support([other])] == [one >> 1, other >> 1]
    assert circuit.support([0, 1]) == circuit.support([]) == ()
