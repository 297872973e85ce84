"""A small spec in a file."""

from pathlib import Path

import pytest

from tests.cli.specs import SPEC


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    path = tmp_path / "demo.exo"
    path.write_text(SPEC)
    return path
