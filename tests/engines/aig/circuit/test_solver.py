"""The SAT solver."""

import gc
from typing import Any

import pysolvers
import pytest

from exover.engines.aig.circuit.graph import Graph
from exover.engines.aig.circuit.solver import Solver
from tests.support.circuits import counter


def test_a_solver_is_freed_once_though_a_signal_raises_meanwhile(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a signal's handler raises comes as soon as the call returns in which the signal came."""
    gc.collect()  # solvers that other tests have left
    freed: list[object] = []
    free = pysolvers.minisat22_del

    def interrupted(solver: Any) -> None:
        free(solver)
        freed.append(solver)
        raise KeyboardInterrupt

    solver = Solver(counter(2, 3, 3))
    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(pysolvers, "minisat22_del", interrupted)
        solver.close()
    with monkeypatch.context() as patch:
        patch.setattr(pysolvers, "minisat22_del", freed.append)
        del solver
        gc.collect()
    assert len(freed) == 1


@pytest.mark.parametrize("ignored", [0, 1])
def test_a_model_need_not_have_what_no_clause_names(ignored: int) -> None:
    """`(a and b) or (a and not b)` is `a`: its clauses name no `b`, which may be the last variable."""
    graph = Graph()
    latches = [graph.latch(False), graph.latch(False)]
    free, told = latches[ignored], latches[1 - ignored]
    bad = graph.any([graph.conjunction(told, free), graph.conjunction(told, free ^ 1)])
    solver = Solver(graph.circuit(latches, [bad]))
    assert solver.knows(bad >> 1) is False
    assert solver.satisfiable([solver.literal(bad)])
    assert solver.knows(free >> 1)
    assert told >> 1 in solver.true([free >> 1, told >> 1])
