"""The work of diagrams ends after so many steps, or nodes, with the same manager as before."""

from contextlib import suppress
from math import inf
from weakref import ref

import pytest

from exover.engines.bdd import effort
from exover.engines.bdd.effort import NODE_LIMIT, STEP_LIMIT, OutOfSteps, limited
from exover.engines.bdd.manager import BddManager, Set
from exover.engines.bdd.python_manager import PythonManager
from exover.engines.bdd.space import new_manager
from tests.support.needed import needs_cudd

PAIRS = 40
BITS = [f"{side}{number}" for side in "xy" for number in range(PAIRS)]


def unequal(bdd: BddManager, pairs: int) -> Set:
    """Return the states in which no x is its y: 2 ** pairs nodes, for the order has all x before all y."""
    found = bdd.true
    for number in range(pairs):
        found = bdd.apply("&", found, bdd.apply("^", bdd.var(f"x{number}"), bdd.var(f"y{number}")))
    return found


@pytest.fixture(params=[pytest.param(new_manager, marks=needs_cudd), PythonManager])
def bdd(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> BddManager:
    """A manager that is looked at after each operation."""
    monkeypatch.setattr(effort, "OFTEN", 0)
    monkeypatch.setattr(effort, "SCANNED", 1 << 40)
    made: BddManager = request.param()
    made.configure(reordering=False)
    made.declare(*BITS)
    return made


def test_steps_are_counted_and_limited(bdd: BddManager) -> None:
    with limited(1_000_000) as spent:
        few = unequal(bdd, 8)
    assert 0 < spent.taken < 100_000
    with pytest.raises(OutOfSteps, match=STEP_LIMIT), limited(50_000) as spent:
        unequal(bdd, PAIRS)
    assert 50_000 < spent.taken < 1_000_000
    assert unequal(bdd, 8) == few


def test_only_the_body_is_limited(bdd: BddManager) -> None:
    with limited(1):
        pass
    assert len(unequal(bdd, 11)) > 1 << 11
    with limited(inf):
        assert len(unequal(bdd, 11)) > 1 << 11


@needs_cudd
def test_one_operation_is_limited_by_the_memory_of_the_manager(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(effort, "OFTEN", 0)
    monkeypatch.setattr(effort, "MEMORY", 32 << 20)
    bdd = new_manager()
    bdd.declare(*BITS)
    with pytest.raises(OutOfSteps, match=NODE_LIMIT), limited(1e12) as spent:
        unequal(bdd, PAIRS)
    assert spent.taken == 1e12
    assert bdd.manager.configure()["max_memory"] > 1 << 40  # type: ignore[attr-defined]
    assert len(unequal(bdd, 11)) > 1 << 11


@needs_cudd
def test_sets_are_freed_as_soon_as_a_limit_has_ended_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Were they in a circle of references, their manager could be the first to be freed, which it refuses."""
    monkeypatch.setattr(effort, "OFTEN", 0)
    monkeypatch.setattr(effort, "MEMORY", 32 << 20)

    class Held:
        """What stands in the frame of the body, as its sets do."""

    def worked() -> "ref[Held]":
        held, bdd = Held(), new_manager()
        bdd.declare(*BITS)
        with suppress(OutOfSteps), limited(1e12):
            unequal(bdd, PAIRS)
        return ref(held)

    assert worked()() is None


@needs_cudd
def test_other_errors_stay_what_they_are() -> None:
    with pytest.raises(ValueError, match="else"), limited(1):
        raise ValueError("something else")
