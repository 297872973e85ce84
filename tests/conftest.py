"""What holds for all tests."""

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from tests.support.command import Run

os.environ["EXOVER_NO_CACHE"] = "1"
"""What tests ask is decided, not remembered; tests of the cache take it away."""
settings.register_profile("steady", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("steady")
"""A test does not fail because the machine is busy."""


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """Return what runs the command in the folder of a test."""
    return Run(tmp_path)
