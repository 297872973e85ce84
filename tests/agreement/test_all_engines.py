"""All engines and plain enumeration say the same of every finding; `make agree` asks of more specs."""

from functools import cache

import pytest

from tests.support.agreement import ENUMERATION, Agreed, Tally, agreed, every_engine
from tests.support.needed import needs_nusmv

pytestmark = needs_nusmv

SEEDS = (29, 39, 42, 67)
"""Of specs with properties, with and without assumptions, that are enumerated and judged in a few seconds each."""


@cache
def case_of(seed: int) -> Agreed:
    return agreed(seed, every_engine())


@pytest.mark.parametrize("seed", SEEDS)
def test_all_engines_agree(seed: int) -> None:
    case = case_of(seed)
    assert not case.disagreements, f"\n{case}"


def test_every_engine_has_answers_of_every_kind() -> None:
    """Else the agreement above would say little."""
    tally = Tally()
    for seed in SEEDS:
        tally.add(case_of(seed))
    for engine in ("aig", "bdd", "z3", "nusmv", ENUMERATION):
        assert tally.answers[engine, "holds"] > 40, engine
        assert tally.answers[engine, "violated"] > 20, engine
    assert not tally.answers["bdd", "unknown"]
    assert {case_of(seed).about_nothing for seed in SEEDS} == {False, True}
