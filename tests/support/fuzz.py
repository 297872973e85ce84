"""Long random runs: `python -m tests.support.fuzz --seconds 60` compares the engines on ever new specs and events.

Every disagreement is printed, made small; the status is 1 if there was one.
"""

import argparse
import signal
import sys
from dataclasses import replace
from time import monotonic
from types import FrameType

from exover.model.types import Int, Real
from tests.support.engines import Disagreement, disagreement, model_of
from tests.support.events import Stream
from tests.support.generate import random_spec
from tests.support.scene import TINY, Size
from tests.support.shrink import shrink

SIZES = (
    TINY,
    replace(TINY, requests=2, clauses=4, rules=2, readings=3),
    Size(requests=4, rules=4, readings=4, clauses=3),
    Size(requests=3, rules=3, readings=3, clauses=5),
    Size(requests=7, rules=6, readings=3, clauses=2, depth=1),
    Size(requests=3, rules=5, readings=4, clauses=4, instances=2),
    replace(Size(), requests=3, rules=2, clauses=4, resources=3, types=Size().types[:2]),
    replace(Size(), requests=3, rules=2, clauses=4, readings=4, types=Size().types[4:7]),
    Size(requests=4, rules=3, clauses=3, types=(Int(-(10**18), 10**18), Int(0, 70_000), Real())),
)
"""What specs are made in turn: small ones meet each other's clauses more often."""
PATIENCE = 5
"""Seconds that one spec may take: the decisions of a few random specs have large diagrams."""


class Slow(Exception):
    """A spec took longer than `PATIENCE`."""


def _slow(_number: int, _frame: FrameType | None) -> None:
    raise Slow


def spec_of(seed: int) -> str:
    """Return the spec of this seed, of a size that depends on it."""
    return random_spec(seed, SIZES[seed % len(SIZES)])


def compared(seed: int, events: int, native: bool) -> Disagreement | None:
    """Return what the engines disagree about on the spec and the events of this seed."""
    spec = spec_of(seed)
    return disagreement(spec, tuple(Stream(model_of(spec), seed).lines(events)), native)


def main() -> int:
    """Run for as long as the command line says; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--seed", type=int, default=0, help="the first seed")
    parser.add_argument("--events", type=int, default=200, help="events for each spec")
    parser.add_argument("--native", action="store_true", help="ask the compiled C too")
    given = parser.parse_args()
    signal.signal(signal.SIGALRM, _slow)
    end, seed, wrong, slow = monotonic() + given.seconds, given.seed, 0, 0
    while monotonic() < end:
        signal.alarm(PATIENCE)
        try:
            found = compared(seed, given.events, given.native)
        except Slow:
            slow += 1
            found = None
        finally:
            signal.alarm(0)
        if found:
            wrong += 1
            print(f"seed {seed}: {shrink(found, given.native)}\n", flush=True)
        seed += 1
    print(f"{seed - given.seed} specs of {given.events} events each, {slow} given up, {wrong} disagreements")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
