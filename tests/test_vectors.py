"""The specs and event streams of tests/vectors: every engine gives the answers that docs/language.md gives them."""

import json
from collections.abc import Iterator
from pathlib import Path
from shutil import which
from typing import Any

import pytest

from exover.cli.arguments import ENGINES
from exover.model.model import Model
from exover.pipeline import engine, load
from exover.run.simulate import simulate
from exover.source import Source

VECTORS = Path(__file__).parent / "vectors"
NAMES = sorted(path.stem for path in VECTORS.glob("*.exo"))


def model_of(name: str) -> Model:
    path = VECTORS / f"{name}.exo"
    model = load(Source(path.name, path.read_text(encoding="utf-8"))).model
    assert model is not None
    return model


def without_details(line: str) -> dict[str, Any]:
    answer: dict[str, Any] = json.loads(line)
    for action in answer["actions"]:
        action.pop("detail", None)
    return answer


def lines(name: str) -> Iterator[tuple[str, str]]:
    events = (VECTORS / f"{name}.events.jsonl").read_text(encoding="utf-8").splitlines()
    answers = (VECTORS / f"{name}.answers.jsonl").read_text(encoding="utf-8").splitlines()
    return zip(events, answers, strict=True)


def test_the_vectors_are_there() -> None:
    assert len(NAMES) == 9
    assert ENGINES == ("reference", "tables", "c", "rust")


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("chosen", ENGINES)
def test_answers(chosen: str, name: str) -> None:
    if chosen == "rust" and which("rustc") is None:
        pytest.skip("rustc is not installed")
    model = model_of(name)
    pairs = list(lines(name))
    with engine(chosen, model) as running:
        for (event, expected), answer in zip(pairs, simulate(model, running, [e for e, _ in pairs]), strict=True):
            assert json.dumps(without_details(answer)) == json.dumps(without_details(expected)), event
