"""Whatever can be parsed is resolved: to a model or to mistakes, and never to a traceback."""

import random
import re
from pathlib import Path

import pytest

from exover.resolve import resolve
from exover.source import Source
from exover.syntax.parse import parse
from tests.resolve.specs import WORLD

TEXTS = {path.stem: path.read_text() for path in sorted((Path(__file__).parent.parent / "vectors").glob("*.exo"))}
TOKEN = re.compile(r'"[^"]*"|[A-Za-z_]\w*|\d+\.\d+|\d+|\.\.|[<>=!]=|\S')
WORDS = ["m", "a", "v", "st", "pw", "film", "sp", "none", "self", "0", "0.5", "1e999", str(2**63 - 1), "true", "ma.*"]


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS.keys())
def test_specs_of_the_vectors_have_no_mistake(text: str) -> None:
    source = Source("vector.exo", text)
    spec, found = parse(source)
    assert spec is not None, found
    model, found = resolve(spec, source)
    assert model is not None, found
    assert found == ()


@pytest.mark.parametrize("text", [*TEXTS.values(), WORLD], ids=[*TEXTS.keys(), "world"])
def test_shuffled_words_give_a_model_or_mistakes(text: str) -> None:
    chance = random.Random(len(text))
    pieces = TOKEN.findall(text)
    names = [piece for piece in pieces if piece.isidentifier() or piece[0].isdigit()] + WORDS
    places = [index for index, piece in enumerate(pieces) if piece.isidentifier() or piece[0].isdigit()]
    resolved = 0
    for _ in range(40):
        changed = list(pieces)
        for _ in range(chance.randint(1, 2)):
            changed[chance.choice(places)] = chance.choice(names)
        source = Source("any.exo", " ".join(changed))
        spec, _ = parse(source)
        if spec is None:
            continue
        resolved += 1
        model, found = resolve(spec, source)
        assert (model is None) == bool(found), source.text
        assert all(mistake.span is not None and mistake.severity == "error" for mistake in found)
        starts = [mistake.span.start for mistake in found if mistake.span]
        assert starts == sorted(starts)
        assert resolve(spec, source) == (model, found)
    assert resolved > 5, "almost nothing was parsed: the test looks at nothing"
