"""Random specs whose states can all be counted, and what the checks and the oracle say of one."""

from collections.abc import Iterable
from dataclasses import replace
from functools import cache

from exover.checks.finding import Finding
from exover.loop.claim import APPROXIMATE
from exover.model.model import Model
from exover.model.types import Bool, Enum, Int, Real
from exover.ocrd.compile import Compiled, compile_model
from exover.ocrd.packing import decode, pack
from tests.support.diagrams import check_by_diagrams
from tests.support.engines import DIGEST, model_of
from tests.support.generate import random_spec
from tests.support.oracle import Graph, explore, verdicts
from tests.support.scene import TINY

Differences = dict[tuple[str, str], tuple[str | None, str | None]]
"""By check and subject what the oracle says and what the checks say."""
SIZES = (
    TINY,
    replace(TINY, requests=2, clauses=3),
    replace(TINY, requests=2, rules=2, readings=2, depth=2, types=(Bool(), Real(0.0, 2.0))),
    replace(TINY, requests=3, readings=0, resources=2, types=(Bool(), Enum(("left", "right")))),
    replace(TINY, requests=2, rules=2, readings=2, clauses=3, instances=1, types=(Int(0, 2), Real(0.0, 2.0))),
)
"""What specs are made in turn."""
MOST_STATES, MOST_STEPS = 1500, 6000
ENUMERABLE = (
    *(0, 4, 7, 8, 14, 15, 23, 24, 26, 27, 28, 30, 32, 37, 40, 41, 42, 47, 48, 50, 54, 55, 57, 58, 60, 63, 64, 67),
    *(68, 69, 70, 71, 73, 74, 82, 87, 88, 89, 90, 91, 92, 94, 95, 96, 98, 100, 101, 103, 104, 109, 111, 112, 115),
    *(122, 124, 128, 130, 131, 133, 134, 136, 4053),
)
"""Of specs that are neither trivial nor large: some dozens of states, some hundreds of steps."""
VARIED = (27, 30, 71, 98, 101, 109, 112)
"""Some of them, soon checked, with every construct and every verdict of all; `tests/agreement` holds it."""


def small_spec_of(seed: int) -> str:
    """Return the spec of this seed, of a size that depends on it."""
    return random_spec(seed, SIZES[seed % len(SIZES)])


@cache
def explored(seed: int) -> Graph:
    """Return all states and steps of one that has few, found once for all tests of a process."""
    return explore(model_of(small_spec_of(seed)), MOST_STATES, MOST_STEPS)


def compiled(model: Model) -> Compiled:
    """Return what the checks are given: tables that were packed and decoded."""
    made = compile_model(model, DIGEST)
    return replace(made, tables=decode(pack(made.tables)))


def findings_of(made: Compiled) -> tuple[Finding, ...]:
    """Return what the checks say, starvation apart: what it says is compared where runs without end are."""
    return tuple(each for each in check_by_diagrams(made).findings if each.check != "starvation")


def differences(graph: Graph, findings: Iterable[Finding]) -> Differences:
    """Return where the oracle and the checks differ, and what they say; that the tables are right goes without it.

    What diagrams do not know since it rests on runs through compared reals is no difference: `make agree` compares it.
    """
    wanted: dict[tuple[str, str], str] = dict(verdicts(graph))
    given = {(each.check, each.subject): each for each in findings}
    found: dict[tuple[str, str], str] = {key: each.verdict for key, each in given.items()}
    wanted |= {key: "holds" for key in found if key[0] == "tables"}
    wanted |= {key: "unknown" for key, each in given.items() if key in wanted and each.message == APPROXIMATE}
    return {key: (wanted.get(key), found.get(key)) for key in wanted | found if wanted.get(key) != found.get(key)}
