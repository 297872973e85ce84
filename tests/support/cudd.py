"""Whether dd has CUDD here; what is measured on its diagrams, or shown of its runs, is not so without."""

from importlib.util import find_spec

import pytest

needs_cudd = pytest.mark.skipif(find_spec("dd.cudd") is None, reason="dd has no CUDD here")
