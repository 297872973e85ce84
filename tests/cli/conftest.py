"""A small spec in a file, and a keyboard."""

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.cli.specs import SPEC


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    path = tmp_path / "demo.exo"
    path.write_text(SPEC)
    return path


@pytest.fixture
def cached(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let commands keep what they find out, which they do not elsewhere in the tests."""
    monkeypatch.delenv("EXOVER_NO_CACHE", raising=False)


@pytest.fixture(autouse=True, scope="session")
def _ctrl_c() -> Iterator[None]:
    """Let commands that are started hear Ctrl-C, which they would not where the tests run in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
