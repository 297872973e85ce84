"""Large diagrams take many frames, but the limit on recursion is as before once they are built."""

import sys

from exover.pipeline import build, load
from exover.source import Source


def test_the_limit_is_restored_after_a_spec_that_needs_more() -> None:
    requests = "".join(f"request r{k}();" for k in range(1200))
    text = f"spec crowd; module m {{ {requests} request all_of() {{ check active(m.r0, {names()}); }} }}"
    before = sys.getrecursionlimit()
    model = load(Source("crowd.exo", text)).model
    assert model is not None
    assert build(model).compiled.figures.depth > before
    assert sys.getrecursionlimit() == before


def names() -> str:
    return ", ".join(f"m.r{k}" for k in range(1, 1200))
