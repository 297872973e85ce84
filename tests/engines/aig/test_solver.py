"""The SAT solver."""

import gc
from typing import Any

import pysolvers
import pytest

from exover.engines.aig.solver import Solver
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
