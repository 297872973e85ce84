"""An editor at work, for the tests of this folder."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.editing import Editor


@pytest.fixture(scope="module")
def editor(folder: Path) -> Iterator[Editor]:
    """Return a client of a server that was started in the `folder` of a module of tests."""
    found = Editor(folder)
    yield found
    found.stop()
