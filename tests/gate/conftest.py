"""The gates of these tests, which are processes of their own, share what they compile."""

from collections.abc import Iterator

import pytest

from tests.support.compiled import keeping_compiler


@pytest.fixture(autouse=True, scope="module")
def _compiled_once_for_gates(_compiled_once: None) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CC", str(keeping_compiler()))
        yield
