"""Whatever stands in a text, what is asked about it is answered."""

from pathlib import Path
from random import Random

import pytest

from exover.editor.analysis import TextAnalysis, analyse_properties, analyse_spec
from exover.editor.completion import proposals
from exover.editor.convert import action, completion, mistake, outline
from exover.editor.fixes import fix
from exover.editor.hover import hover
from exover.editor.text import EditorText
from exover.source import Source

ROOT = Path(__file__).resolve().parents[2]
ROVER = (ROOT / "specs" / "rover.exo").read_text(encoding="utf-8")
PROPERTIES = (ROOT / "properties" / "rover.prop").read_text(encoding="utf-8")
PIECES = [
    "",
    ";",
    "}",
    "{",
    '"',
    "/*",
    "*/",
    ".",
    "nd.",
    "self.",
    "active(",
    "🤖",
    "\r",
    "\0",
    "mutex ",
    "in ",
    "with ",
    "request x(",
    "-",
]


def damaged(text: str, random: Random) -> str:
    """Return a text in which a part is replaced by a piece or by another part."""
    for _ in range(random.randrange(1, 4)):
        start = random.randrange(len(text) + 1)
        end = min(start + random.choice((0, 1, 5, 200)), len(text))
        other = random.randrange(len(text) + 1)
        piece = random.choice([*PIECES, text[other : other + 40]])
        text = text[:start] + piece + text[end:]
    return text


def asked(found: TextAnalysis, spec: TextAnalysis | None, random: Random) -> None:
    """Ask everything about a text, at places of it and beyond."""
    text = EditorText(found.source.text, random.choice(("utf-8", "utf-16", "utf-32")))
    start = "file" if spec is None else "properties"
    outline(text, found)
    for each in found.diagnostics:
        mistake(text, each)
        if change := fix(each, found.source):
            action(text, "file:///a.exo", each, change)
    for _ in range(5):
        offset = random.randrange(len(found.source.text) + 1)
        hover(found, offset, spec)
        for each in proposals(found, offset, start, spec):
            completion([one for one in (found, spec) if one], each)
        assert 0 <= text.offset((random.randrange(200), random.randrange(200))) <= len(found.source.text)


@pytest.mark.parametrize("seed", range(8))
def test_damaged_texts_are_answered(seed: int) -> None:
    random = Random(seed)
    spec = before = analyse_spec(Source("a.exo", ROVER))
    last = None
    for _ in range(25):
        before = analyse_spec(Source("a.exo", damaged(ROVER, random)), before)
        asked(before, None, random)
        text = Source("a.prop", damaged(PROPERTIES, random))
        last = analyse_properties(text, random.choice((spec, before)), last)
        asked(last, spec, random)
