"""The NuSMV to test with: that of the wheel, wherever it is installed and has the libraries that it wants."""

from functools import cache

import pytest

from exover.engines.process import NotRunnable
from exover.engines.smv.program import find


@cache
def missing() -> str:
    """Return why there is none, or nothing."""
    try:
        find()
    except NotRunnable as reason:
        return str(reason)
    return ""


needs_nusmv = pytest.mark.skipif(bool(missing()), reason=missing())
