"""What holds for all tests."""

import gc
import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from exover.cli.main import OBJECTS
from tests.support.command import Run
from tests.support.compiled import KEPT, STORE, across_runs, kept_in, store

os.environ["EXOVER_NO_CACHE"] = "1"
"""What tests ask is decided, not remembered; tests of the cache take it away."""
settings.register_profile("steady", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("steady")
"""A test does not fail because the machine is busy."""
gc.set_threshold(OBJECTS)
"""As in the command: cycles are looked for less often."""


def pytest_configure(config: pytest.Config) -> None:
    """Say, before there are processes of tests, where they keep what is compiled for the next run as well."""
    if KEPT in os.environ and not hasattr(config, "workerinput"):
        os.environ[STORE] = str(across_runs(Path(os.environ[KEPT])))


def pytest_collection_finish() -> None:
    """Keep garbage from being looked for among the tests themselves: that takes longer than many of them."""
    gc.freeze()


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """Return what runs the command in the folder of a test."""
    return Run(tmp_path)


@pytest.fixture(autouse=True, scope="session")
def _compiled_once(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Share what is compiled among all processes of a run of the tests."""
    if KEPT not in os.environ:
        mine = tmp_path_factory.getbasetemp()
        shared = mine.parent if "PYTEST_XDIST_WORKER" in os.environ else mine
        os.environ[STORE] = str(shared / "compiled")
    with kept_in(store()):
        yield
