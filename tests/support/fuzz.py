"""Long random runs: `python -m tests.support.fuzz --seconds 60` compares the engines on ever new specs and events.

Every disagreement is printed, made small; the status is 1 if there was one.
"""

import argparse
import signal
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import monotonic
from types import FrameType

from exover.model.types import Bool, Int, Real
from exover.pipeline import load
from exover.source import Source
from tests.support.engines import Disagreement, compared
from tests.support.generate import random_spec
from tests.support.oracle import explore
from tests.support.representatives import TooLarge
from tests.support.scene import TINY, Size
from tests.support.shrink import shrink, smallest
from tests.support.small import Differences, compiled, differences, findings_of, small_spec_of

SIZES = (
    TINY,
    replace(TINY, requests=2, clauses=4, rules=2, readings=3),
    Size(requests=4, rules=4, readings=4, clauses=3),
    Size(requests=3, rules=3, readings=3, clauses=5),
    Size(requests=7, rules=6, readings=3, clauses=2, depth=1),
    Size(requests=3, rules=5, readings=4, clauses=4, instances=2),
    replace(Size(), requests=3, rules=1, clauses=6, resources=3, conflicts=0, types=Size().types[:2]),
    replace(Size(), requests=3, rules=2, clauses=4, readings=4, types=Size().types[4:7]),
    Size(requests=5, rules=5, clauses=3, readings=3, depth=1, conflicts=90),
    Size(requests=3, modules=1, readings=0, latches=0, resources=0, rules=1, clauses=5, depth=0, conflicts=100),
    Size(requests=4, rules=3, clauses=4, readings=2, depth=1, conflicts=70, types=(Bool(), Int(0, 2), Real(0.0, 2.0))),
    Size(requests=4, rules=3, clauses=3, types=(Int(-(10**18), 10**18), Int(0, 70_000), Real())),
    Size(requests=3, rules=1, clauses=4, readings=3, depth=1, conflicts=60, launches=3, types=(Bool(), Int(0, 2))),
    Size(requests=4, rules=2, clauses=3, readings=2, depth=1, conflicts=40, instances=2, launches=4),
)
"""What specs are made in turn: small ones meet each other's clauses more often."""
VARIED = (11, 14, 20, 34, 40, 66, 69, 72, 85, 104)
"""Seeds of small ones with two of each construct that a hundred have; `tests/agreement` holds it."""
MOST_STATES, MOST_STEPS = 1500, 6000
"""How large a small spec may be."""
PATIENCE = 5
"""Seconds that one spec may take: the decisions of a few random specs have large diagrams."""


@dataclass(frozen=True, slots=True)
class Counterexample:
    """A spec of which the checks say something else than the oracle."""

    spec: str
    differences: Differences

    def __str__(self) -> str:
        """Return all that is needed to see it again."""
        return f"{self.spec}\noracle, checks: {self.differences}"


class Slow(Exception):
    """A spec took longer than `PATIENCE`."""


def _slow(_number: int, _frame: FrameType | None) -> None:
    raise Slow


def spec_of(seed: int) -> str:
    """Return the spec of this seed, of a size that depends on it."""
    return random_spec(seed, SIZES[seed % len(SIZES)])


def checked(seed: int) -> Counterexample | None:
    """Return in what the checks differ from the oracle on the small spec of this seed, if that can be counted."""
    spec = small_spec_of(seed)
    found = differing(spec)
    return Counterexample(spec, found) if found else None


def differing(spec: str) -> Differences:
    """Return in what the checks differ from the oracle; nothing for what is no spec, or a large one."""
    model = load(Source("small.exo", spec)).model
    if model is None:
        return {}
    try:
        return differences(explore(model, MOST_STATES, MOST_STEPS), findings_of(compiled(model)))
    except TooLarge:
        return {}


def smaller(found: Counterexample) -> Counterexample:
    """Return a shorter spec with a difference of the same kind."""
    kinds = {(check, *said) for (check, _), said in found.differences.items()}

    def same(lines: Sequence[str]) -> bool:
        return bool(kinds & {(check, *said) for (check, _), said in differing("\n".join(lines)).items()})

    spec = "\n".join(smallest(found.spec.splitlines(), same))
    return Counterexample(spec, differing(spec))


def main() -> int:
    """Run for as long as the command line says; return the exit status."""
    given = _arguments()
    signal.signal(signal.SIGALRM, _slow)
    end, seed, wrong, slow = monotonic() + given.seconds, given.seed, 0, 0
    while monotonic() < end:
        found: Counterexample | Disagreement | None = None
        signal.alarm(PATIENCE)
        try:
            found = checked(seed) if given.checks else compared(spec_of(seed), seed, given.events, given.native)
        except Slow:
            slow += 1
        finally:
            signal.alarm(0)
        if found:
            wrong += 1
            small = smaller(found) if isinstance(found, Counterexample) else shrink(found, given.native)
            print(f"seed {seed}: {small}\n", flush=True)
        seed += 1
    print(f"{seed - given.seed} specs, {slow} given up, {wrong} with a disagreement")
    return int(wrong > 0)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--seed", type=int, default=0, help="the first seed")
    parser.add_argument("--events", type=int, default=200, help="events for each spec")
    parser.add_argument("--native", action="store_true", help="ask the compiled C too")
    parser.add_argument("--checks", action="store_true", help="compare the checks with the oracle, on small specs")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
