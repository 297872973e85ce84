"""The ABC to test with, wherever it is installed."""

from functools import cache

import pytest

from exover.engines.aig.abc.prover import find
from exover.engines.process import NotRunnable


@cache
def missing() -> str:
    """Return why there is none, or nothing."""
    try:
        find()
    except NotRunnable as reason:
        return str(reason)
    return ""


needs_abc = pytest.mark.skipif(bool(missing()), reason=missing())
