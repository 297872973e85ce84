"""The specs and event streams of tests/vectors, with the answers that docs/language.md gives them."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from exover.model.model import Model
from exover.pipeline import load
from exover.source import Source

VECTORS = Path(__file__).parents[1] / "vectors"
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
