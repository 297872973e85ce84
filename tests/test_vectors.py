"""The specs and event streams of tests/vectors: every engine gives the answers that docs/language.md gives them."""

import json
from shutil import which

import pytest

from exover.cli.options import RUN_ENGINES
from exover.pipeline import engine
from exover.run.simulate import simulate
from tests.support.vectors import NAMES, lines, model_of, without_details


def test_the_vectors_are_there() -> None:
    assert len(NAMES) == 11
    assert RUN_ENGINES == ("reference", "tables", "c", "rust")


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("chosen", RUN_ENGINES)
def test_answers(chosen: str, name: str) -> None:
    if chosen == "rust" and which("rustc") is None:
        pytest.skip("rustc is not installed")
    model = model_of(name)
    pairs = list(lines(name))
    with engine(chosen, model) as running:
        for (event, expected), answer in zip(pairs, simulate(model, running, [e for e, _ in pairs]), strict=True):
            assert json.dumps(without_details(answer)) == json.dumps(without_details(expected)), event
