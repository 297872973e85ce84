"""Work for the processes that checks are made in."""

from exover.pipeline import Build, build, load
from exover.source import Source


def built(text: str) -> Build:
    model = load(Source("demo.exo", text)).model
    assert model is not None
    return build(model)


def silent(text: str) -> None:
    """Tell nobody."""


def hang() -> None:
    """Stay in one call of C code for minutes; no signal handler of Python runs meanwhile."""
    pow(7, 10**8)
