"""What tests of questions in processes share: nobody is left behind."""

from collections.abc import Iterator

import pytest

from tests.checks.schedule.spreading import children


@pytest.fixture
def nobody_is_left() -> Iterator[None]:
    """Fail if a test leaves a process."""
    before = children()
    yield
    assert children() == before
