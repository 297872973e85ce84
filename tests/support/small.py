"""Random specs whose states can all be counted, for the checks and their oracle."""

from dataclasses import replace

from exover.model.types import Bool, Enum, Int, Real
from tests.support.generate import random_spec
from tests.support.scene import TINY

SIZES = (
    TINY,
    replace(TINY, requests=2, clauses=3),
    replace(TINY, requests=2, rules=2, readings=2, depth=2, types=(Bool(), Real(0.0, 2.0))),
    replace(TINY, requests=3, readings=0, resources=2, types=(Bool(), Enum(("left", "right")))),
    replace(TINY, requests=2, rules=2, readings=2, clauses=3, instances=1, types=(Int(0, 2), Real(0.0, 2.0))),
)
"""What specs are made in turn."""


def small_spec_of(seed: int) -> str:
    """Return the spec of this seed, of a size that depends on it."""
    return random_spec(seed, SIZES[seed % len(SIZES)])
