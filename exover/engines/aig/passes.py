"""How many passes of the checker settle every step of every run."""

from exover.engines.aig.encoding.encoder import PASSES, Encoding
from exover.engines.aig.engine import BUDGET
from exover.engines.aig.inquiry import Inquiry
from exover.loop.claim import Opinion
from exover.model.property import Properties
from exover.ocrd.compile import Compiled

FIRST = 1
"""The number of passes that is tried first; many small specs need no more."""


def enough_passes(compiled: Compiled, properties: Properties) -> int | None:
    """Return a number of passes that is proved to settle every step of every run under the assumptions.

    Fewer are too few for some run, or were not soon proved to be enough. None if no number is proved. The embedded
    solver does the proofs, not ABC, so that the same number is found everywhere.
    """
    known: Inquiry | None = None
    for passes in range(FIRST, PASSES.stop):
        inquiry = Inquiry(Encoding(compiled, properties, passes), (), _unasked, "", BUDGET)
        if inquiry.explore(known) and inquiry.settle(insist=passes > FIRST):
            return passes if inquiry.evidence.settled else None
        known = inquiry
    return None


def _unasked(place: int, opinion: Opinion) -> None:
    raise AssertionError("nothing is claimed")
