"""What is not installed everywhere: a test that needs it is skipped where it is missing."""

from collections.abc import Callable
from importlib.util import find_spec

import pytest

from exover.engines.aig.abc import prover
from exover.engines.process import NotRunnable
from exover.engines.smv import program


def missing(find: Callable[[], str]) -> str:
    """Return why a program is not found, or nothing."""
    try:
        find()
    except NotRunnable as reason:
        return str(reason)
    return ""


NO_ABC, NO_NUSMV = missing(prover.find), missing(program.find)
"""Why ABC and NuSMV are not here, or nothing."""
needs_abc = pytest.mark.skipif(bool(NO_ABC), reason=NO_ABC)
needs_nusmv = pytest.mark.skipif(bool(NO_NUSMV), reason=NO_NUSMV)
needs_cudd = pytest.mark.skipif(find_spec("dd.cudd") is None, reason="dd has no CUDD here")
